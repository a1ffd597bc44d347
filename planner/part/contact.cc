#include "planner/part/internal/contact.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Of pushes away from S*, and of rounds into the cone: each halves what is left, or better, where it matters.
constexpr int kPushes = 4;
constexpr int kConeRounds = 20;
// What counts as in the cone, as a cosine.
constexpr double kInCone = 1e-9;
// rad: normals that turn by less show no bend.
constexpr double kBend = 0.1;
// rad: neighbours whose normals turn by more lie beyond an edge of their own.
constexpr double kTurnOverEdge = 1.2;
// Of the widest turn to a neighbour: how far off the normal may be for that. Measured on boxes, grooves and overhangs of a few ε.
constexpr double kUneven = 0.1;
constexpr double kUnevenOneSided = 0.45;
// Of the disagreement of neighbours' fits: how far off the normal may be for that. Measured on the bunny, whose facets are as large as ε,
// for 99 in 100 (tests/end_to_end/table_test.cpp).
constexpr double kDisagreement = 3.3;
// Of a facet's bulge: what is left of it after it has been reckoned with.
constexpr double kBulgeError = 0.5;

}  // namespace

double chord_error(const Point& a, const Vector& normal_a, const Point& b, const Vector& normal_b) {
    const Vector chord = b - a;
    const double length = chord.norm();
    if (!(length > 0)) return 0;
    const double at_a = std::asin(std::clamp(normal_a.dot(chord) / length, -1.0, 1.0));
    const double at_b = std::asin(std::clamp(-normal_b.dot(chord) / length, -1.0, 1.0));
    // Of the same sign they meet between; else each plane bounds one half.
    const double turn = std::abs(at_a) + std::abs(at_b);
    if (!(turn > 0)) return 0;
    const double sine = std::sin(std::min(turn, 1.5707963267948966));
    return length * std::abs(std::sin(at_a) * std::sin(at_b)) / std::max(sine, 1e-12);
}

TracedField::Distance TracedField::distance(const Point& p) const {
    const FacetPlace place = tree_.nearest(p);
    const auto& corners = mesh_.triangles[place.facet];
    double height = 0;
    double bulges = 0;
    Vector normal = Vector::Zero();
    for (Eigen::Index k = 0; k < 3; ++k) {
        const std::uint32_t a = corners[static_cast<std::size_t>(k)];
        const std::uint32_t b = corners[static_cast<std::size_t>((k + 1) % 3)];
        normal += place.share[k] * fits_[a].normal;
        // Over a crease the chord stays: it lies outside.
        if (is_creased(mesh_.points[a], fits_[a].normal, mesh_.points[b], fits_[b].normal)) continue;
        const double rise = bulge(mesh_.points[a], fits_[a].normal, mesh_.points[b], fits_[b].normal);
        height += place.share[k] * place.share[(k + 1) % 3] * rise;
        bulges = std::max(bulges, std::abs(rise) / 4);
    }
    const Point nearest = place.point + height * normal.normalized();
    return {(p - nearest).norm(), nearest, kBulgeError * bulges};
}

TracedField::TracedField(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<SurfaceFit>& fits, double radius, double noise)
    : mesh_(mesh), fans_(fans), fits_(fits), radius_(radius), noise_(noise), tree_(mesh) {}

std::vector<TracedField::Limit> TracedField::limits(std::uint32_t v) const {
    std::vector<Limit> found;
    for (const std::uint32_t j : fans_.two_rings(v)) {
        const Vector to = mesh_.points[j] - mesh_.points[v];
        const double distance = to.norm();
        if (!(distance > 0 && distance < 2 * radius_)) continue;
        found.push_back({to / distance, -distance / (2 * radius_) - 2 * noise_ / distance});
        const SurfaceFit& fit = fits_[j];
        // A plane that S* bends down from is the part's, too, r below: the part stays below it.
        const double depth = fit.normal.dot(to);
        if (fit.is_creased || fits_[v].is_creased || !(depth > fit.flatness)) continue;
        const double slack = 2 * noise_ + distance * std::sin(fit.angle) + 2 * fit.flatness;
        found.push_back({fit.normal, 1 - (depth + slack) / radius_});
    }
    return found;
}

Contact TracedField::contact(std::uint32_t v) const {
    const Point& centre = mesh_.points[v];
    const SurfaceFit& fit = fits_[v];
    const std::vector<Limit> cone = limits(v);
    Vector normal = fit.normal;
    double lack = 0;
    for (int push = 0; push < kPushes; ++push) {
        // Into the cone, one neighbour after the other.
        for (int round = 0; round < kConeRounds; ++round) {
            double most = 0;
            for (const Limit& limit : cone) {
                const double off = limit.least - normal.dot(limit.direction);
                if (off <= 0) continue;
                most = std::max(most, off);
                normal = (normal + off * limit.direction).normalized();
            }
            if (most < kInCone) break;
        }
        // Away from what of S* is no neighbour.
        const Point x = centre - radius_ * normal;
        const Distance found = distance(x);
        lack = radius_ - found.distance - noise_ - found.trust;
        if (lack <= 0 || !(found.distance > 0)) break;
        normal = (centre - found.nearest - radius_ / found.distance * (x - found.nearest)).normalized();
    }
    const double angle = std::min(fit.angle, 1.5);
    return {centre - radius_ * normal,
            normal,
            angle,
            fit.disagreement,
            noise_ + radius_ * (1 - std::cos(angle)) + std::max(lack, 0.0),
            fit.is_creased};
}

namespace {

// Touches near each other show how sharp the part is, and with it what an angle costs. A shift t = r sin θ along a bend of the part with
// radius ρ leaves it by √(ρ² + t²) − ρ, along an edge (ρ = 0) by all of t.
void add_bends(std::vector<Contact>& contacts, const FacetFans& fans, double radius) {
    std::vector<double> more(contacts.size(), 0.0);
    for (std::uint32_t v = 0; v < contacts.size(); ++v) {
        const Contact& contact = contacts[v];
        const std::vector<std::uint32_t> around = fans.two_rings(v);
        double widest = 0;
        for (const std::uint32_t j : around) {
            const double turn = angle_between(contact.normal, contacts[j].normal);
            if (turn < kTurnOverEdge) widest = std::max(widest, turn);
        }
        // Where the surface turns, it may turn unevenly, and beside a crease it is seen from one side only.
        const bool is_one_sided =
            contact.is_creased || std::ranges::any_of(around, [&](std::uint32_t j) { return contacts[j].is_creased; });
        const double doubt = std::max(contact.angle, kDisagreement * contact.disagreement);
        const double angle = std::max(doubt, (is_one_sided ? kUnevenOneSided : kUneven) * widest);
        const double shift = radius * std::sin(angle);
        // Where it is seen from one side the touched points themselves are not sure to show how sharp it is.
        double leaves = contact.is_creased ? shift : 0;
        // ... and by t sin δ across one of δ, which turns to neighbours bound.
        leaves = std::max(leaves, radius * std::sin(doubt) * std::sin(widest));
        for (const std::uint32_t j : around) {
            const Vector turned = contacts[j].normal - contact.normal;
            const double turn = angle_between(contact.normal, contacts[j].normal);
            if (turn < kBend) continue;
            const double along = turned.dot(contacts[j].point - contact.point) / turned.norm();
            if (along < -shift) continue;  // a concave bend
            const double rho = std::max(along, 0.0) / turn;
            leaves = std::max(leaves, std::hypot(rho, shift) - rho);
        }
        more[v] = leaves + radius * (std::cos(contact.angle) - std::cos(angle));
    }
    for (std::uint32_t v = 0; v < contacts.size(); ++v) contacts[v].uncertainty += more[v];
}

}  // namespace

std::vector<Contact> touch_points(const TriangleMesh& mesh, const FacetFans& fans, const std::vector<SurfaceFit>& fits, double radius,
                                  double noise) {
    const TracedField field(mesh, fans, fits, radius, noise);
    std::vector<Contact> contacts;
    contacts.reserve(mesh.points.size());
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) contacts.push_back(field.contact(v));
    add_bends(contacts, fans, radius);
    return contacts;
}

}  // namespace palpate
