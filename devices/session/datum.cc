#include "devices/session/datum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

namespace palpate {
namespace {

// Touches around a place that show its normal, ...
constexpr std::size_t kNeighbors = 12;
constexpr std::size_t kLeastNeighbors = 9;
// ... or, where S is flat but not so far, ...
constexpr std::size_t kFlatNeighbors = 7;
// ... if what fits them best leaves that part of their distance, and they lie on no line.
constexpr double kSmooth = 0.03;
constexpr double kBroad = 0.4;
// Nor on one side of the place: their centre is that near to it, as part of their distance.
constexpr double kAround = 0.5;
constexpr int kTurns = 4;
// A touch at a flatter angle to S than 45 degrees tells little of where S is if its normal is a little off.
constexpr double kSteep = 0.7;
// Places whose normals are looked at: the nearest ones, and as many of the others, spread over the session.
constexpr std::size_t kNearest = 150;
constexpr std::size_t kSpread = 150;
// How independent the normals of three places are to be (least_share): the strictest that can be had. Orthogonal ones have 0.577.
constexpr std::array<double, 3> kStrictness{0.54, 0.51, 0.48};
// 0.4 makes a shift of 5 touch errors an offset of 2 at one of three places at least; the rest is for normals that are some degrees off.
constexpr double kIndependent = 0.48;
// The same of fewer directions, as singular values: at one of three places it is that share of the shift over sqrt(3).
constexpr double kIndependentFew = 0.78;

// A contact with what it costs to touch it again.
struct Candidate {
    DatumPlace place;
    double cost = 0.0;  // mm of way
};

std::vector<Candidate> contacts_of(const Journal& journal, std::size_t moves) {
    std::vector<Candidate> contacts;
    for (std::size_t k = 0; k < std::min(moves, journal.moves.size()); ++k) {
        const JournalMove& move = journal.moves[k];
        if (move.datum || move.pace != Pace::probe || move.result.outcome != MoveResult::Outcome::contact) continue;
        const Point& from = journal.rest_before(k);
        const Vector way = move.result.position - from;
        if (way.isZero()) continue;
        contacts.push_back({{move.line, from, move.result.position, way.normalized(), Vector::Zero()}, way.norm()});
    }
    return contacts;
}

// The nearest touches of others around a place that came from its side of S, relative to it.
std::vector<Vector> neighbors_of(const DatumPlace& place, const std::vector<Candidate>& touches) {
    std::vector<Vector> near;
    for (const Candidate& c : touches) {
        if (c.place.line != place.line && c.place.inwards.dot(place.inwards) > 0) near.emplace_back(c.place.touched - place.touched);
    }
    const std::size_t count = std::min(kNeighbors, near.size());
    const auto is_nearer = [](const Vector& a, const Vector& b) { return a.squaredNorm() < b.squaredNorm(); };
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end(), is_nearer);
    near.resize(count);
    return near;
}

// Of the plane through the place that they lie in best, up to `most` of their distance; nothing if they do not, or not around it.
Vector flat_normal(std::span<const Vector> near, double most) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    Vector mean = Vector::Zero();
    for (const Vector& d : near) {
        spread += d * d.transpose() / static_cast<double>(near.size());
        mean += d / static_cast<double>(near.size());
    }
    if (mean.norm() > kAround * std::sqrt(spread.trace())) return Vector::Zero();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    const Vector size = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // in order, the least first
    if (size[1] < kBroad * size[2] || size[0] > most * near.back().norm()) return Vector::Zero();
    return solver.eigenvectors().col(0);
}

// The normal at the place of the parabola over the plane of `normal` that fits its neighbors best, the near ones most; nothing if S is not
// smooth there.
Vector curved_normal(std::span<const Vector> near, const Vector& normal) {
    const Vector x = normal.unitOrthogonal();
    const Vector y = normal.cross(x);
    const double scale = near.back().norm();
    const auto count = static_cast<Eigen::Index>(near.size());
    Eigen::Matrix<double, Eigen::Dynamic, 5> a(count, 5);
    Eigen::VectorXd heights(count);
    Eigen::VectorXd weights(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const Vector d = near[static_cast<std::size_t>(k)] / scale;
        const double u = d.dot(x);
        const double v = d.dot(y);
        weights[k] = 1 / (0.1 + d.squaredNorm());
        a.row(k) << u, v, u * u, u * v, v * v;
        heights[k] = d.dot(normal);
    }
    const Eigen::VectorXd fit = (weights.asDiagonal() * a).colPivHouseholderQr().solve(weights.cwiseProduct(heights));
    const double residual = std::sqrt((a * fit - heights).squaredNorm() / static_cast<double>(count));
    if (!(residual <= kSmooth)) return Vector::Zero();
    return (normal - fit[0] * x - fit[1] * y).normalized();
}

// S's normal at a place, against the way of its touch, as the touches around show it; nothing if they do not.
Vector normal_at(const DatumPlace& place, const std::vector<Candidate>& touches) {
    const std::vector<Vector> near = neighbors_of(place, touches);
    Vector normal = Vector::Zero();
    if (near.size() >= kLeastNeighbors) normal = flat_normal(near, 1.0);
    for (int turn = 0; turn < kTurns && !normal.isZero(); ++turn) normal = curved_normal(near, normal);
    if (normal.isZero() && near.size() >= kFlatNeighbors) normal = flat_normal(std::span(near).first(kFlatNeighbors), kSmooth);
    return normal.dot(place.inwards) > 0 ? Vector(-normal) : normal;
}

// A shift of length 1 is an offset of so much at least at one of three places with these normals: of all shifts whose offsets are no more
// than 1 the longest has that offset at each of them.
double least_share(const Vector& a, const Vector& b, const Vector& c) {
    Eigen::Matrix3d normals;
    normals << a.transpose(), b.transpose(), c.transpose();
    constexpr double kFlatTriple = 1e-3;
    if (std::abs(normals.determinant()) < kFlatTriple) return 0.0;
    const Eigen::Matrix3d shifts = normals.inverse();
    double longest = 0.0;
    for (const double second : {-1.0, 1.0}) {
        for (const double third : {-1.0, 1.0}) longest = std::max(longest, (shifts * Vector(1.0, second, third)).norm());
    }
    return 1 / longest;
}

// The cheapest three whose normals are that independent, of `candidates` in the order of their cost; nothing if there are none.
std::vector<DatumPlace> cheapest_triple(const std::vector<Candidate>& candidates, double strictness) {
    std::vector<DatumPlace> best;
    double least = std::numeric_limits<double>::infinity();
    for (auto first = candidates.begin(); first != candidates.end() && 3 * first->cost < least; ++first) {
        const Vector& a = first->place.normal;
        for (auto second = first + 1; second != candidates.end() && first->cost + 2 * second->cost < least; ++second) {
            const Vector& b = second->place.normal;
            if (least_share(a, b, a.cross(b).normalized()) < strictness) continue;  // no third one would do
            const auto third = std::find_if(second + 1, candidates.end(),
                                            [&](const Candidate& c) { return least_share(a, b, c.place.normal) >= strictness; });
            if (third == candidates.end() || first->cost + second->cost + third->cost >= least) continue;
            least = first->cost + second->cost + third->cost;
            best = {first->place, second->place, third->place};
        }
    }
    return best;
}

// ... as independent as can be had.
std::vector<DatumPlace> most_independent_triple(const std::vector<Candidate>& candidates) {
    for (const double strictness : kStrictness) {
        std::vector<DatumPlace> triple = cheapest_triple(candidates, strictness);
        if (!triple.empty()) return triple;
    }
    return {};
}

// Where normals are not known: touches from directions as different as can be had.
void add_by_direction(std::vector<DatumPlace>& places, const std::vector<Candidate>& candidates) {
    while (places.size() < 3) {
        const Candidate* best = nullptr;
        double least = 1.0;
        for (const Candidate& c : candidates) {
            double closest = 0;
            for (const DatumPlace& p : places) closest = std::max(closest, std::abs(p.inwards.dot(c.place.inwards)));
            if (best != nullptr && closest >= least) continue;
            best = &c;
            least = closest;
        }
        const auto is_same = [&](const DatumPlace& p) { return p.line == best->place.line; };
        if (best == nullptr || std::ranges::any_of(places, is_same)) return;
        places.push_back(best->place);
    }
}

}  // namespace

std::vector<DatumPlace> choose_datum_places(const Journal& journal, const VisitedWays& visited_ways, const Point& from, std::size_t moves) {
    std::vector<Candidate> all = contacts_of(journal, moves);
    std::vector<Point> starts;
    starts.reserve(all.size());
    for (const Candidate& c : all) starts.push_back(c.place.from);
    const std::vector<double> ways = visited_ways.lengths(from, starts);
    for (std::size_t k = 0; k < all.size(); ++k) all[k].cost += ways[k];
    std::erase_if(all, [](const Candidate& c) { return !std::isfinite(c.cost); });
    std::ranges::stable_sort(all, {}, &Candidate::cost);
    std::vector<Candidate> looked_at;
    const std::size_t rest = all.size() - std::min(kNearest, all.size());
    const std::size_t stride = std::max<std::size_t>(1, rest / kSpread);
    for (std::size_t k = 0; k < all.size(); k += k < kNearest ? 1 : stride) {
        Candidate c = all[k];
        c.place.normal = normal_at(c.place, all);
        if (!c.place.normal.isZero() && std::abs(c.place.normal.dot(c.place.inwards)) < kSteep) c.place.normal.setZero();
        looked_at.push_back(c);
    }
    std::vector<Candidate> known;
    std::ranges::copy_if(looked_at, std::back_inserter(known), [](const Candidate& c) { return !c.place.normal.isZero(); });
    std::vector<DatumPlace> places = most_independent_triple(known);
    if (places.empty() && !known.empty()) places.push_back(known.front().place);
    if (places.size() < 3) add_by_direction(places, looked_at);
    return places;
}

int independent_directions(const std::vector<DatumPlace>& places) {
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    const std::size_t count = std::min<std::size_t>(places.size(), 3);
    for (std::size_t k = 0; k < count; ++k) normals.row(static_cast<Eigen::Index>(k)) = places[k].normal;
    if (count == 3 && least_share(places[0].normal, places[1].normal, places[2].normal) >= kIndependent) return 3;
    const Vector values = normals.jacobiSvd().singularValues();
    return std::min(2, static_cast<int>((values.array() >= kIndependentFew).count()));
}

}  // namespace palpate
