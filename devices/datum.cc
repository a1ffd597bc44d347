#include "devices/datum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace palpate {
namespace {

// Touches that show a normal, the place's own included, ...
constexpr std::size_t kNeighbors = 9;
constexpr std::size_t kLeastNeighbors = 5;
// ... if they lie in a plane, up to that part of their spread, and not on a line.
constexpr double kFlat = 0.25;
constexpr double kBroad = 0.3;
// A touch at a flatter angle to S than 30 degrees is as much a matter of where S ends as of where it is.
constexpr double kSteep = 0.5;
// Places whose normals are looked at: the nearest ones, and as many of the others, spread over the session.
constexpr std::size_t kNearest = 150;
constexpr std::size_t kSpread = 150;
// Anchors that triples are built on.
constexpr std::size_t kAnchors = 12;
// How far two normals, and a third one with their cross product, may be from orthogonal: the strictest that can be had.
struct Strictness {
    double most_cosine;
    double least_height;
};
constexpr std::array<Strictness, 3> kStrictness{{{0.35, 0.9}, {0.6, 0.75}, {0.85, 0.5}}};
// A shift of 5 touch errors along a direction of singular value s is an offset of at least 5 s / sqrt(3) of them at one place; more than 2.
constexpr double kIndependent = 0.7;

// A contact with what it costs to touch it again.
struct Candidate {
    DatumPlace place;
    double cost = 0.0;  // mm of way
};

std::vector<Candidate> contacts_of(const Journal& journal, std::size_t moves) {
    std::vector<Candidate> contacts;
    for (std::size_t k = 0; k < std::min(moves, journal.moves.size()); ++k) {
        const JournalMove& move = journal.moves[k];
        if (move.pace != Pace::probe || move.result.outcome != MoveResult::Outcome::contact) continue;
        const Point& from = journal.rest_before(k);
        const Vector way = move.result.position - from;
        if (way.isZero()) continue;
        contacts.push_back({{move.line, from, move.result.position, way.normalized(), Vector::Zero()}, way.norm()});
    }
    return contacts;
}

// The plane through the nearest touches; nothing if they lie in none.
Vector normal_at(const Point& p, const std::vector<Point>& touches) {
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t k = 0; k < touches.size(); ++k) near.emplace_back((touches[k] - p).squaredNorm(), k);
    const std::size_t count = std::min(kNeighbors, near.size());
    if (count < kLeastNeighbors) return Vector::Zero();
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    Point mean = Point::Zero();
    for (std::size_t k = 0; k < count; ++k) mean += touches[near[k].second] / static_cast<double>(count);
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < count; ++k) {
        const Vector d = touches[near[k].second] - mean;
        spread += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    const Vector size = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();  // in order, the least first
    if (size[0] > kFlat * size[1] || size[1] < kBroad * size[2]) return Vector::Zero();
    return solver.eigenvectors().col(0);
}

// The cheapest of `candidates` that fulfils `fits`; nothing if none does. They are in the order of their cost.
template <class Fits>
const Candidate* cheapest(const std::vector<Candidate>& candidates, const Fits& fits) {
    const auto found = std::ranges::find_if(candidates, fits);
    return found == candidates.end() ? nullptr : &*found;
}

// The cheapest three whose normals are as independent as can be had; fewer where there are no three.
std::vector<DatumPlace> cheapest_triple(const std::vector<Candidate>& candidates) {
    for (const auto& [most_cosine, least_height] : kStrictness) {
        std::vector<DatumPlace> best;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < std::min(kAnchors, candidates.size()); ++k) {
            const Candidate& first = candidates[k];
            const Candidate* second =
                cheapest(candidates, [&](const Candidate& c) { return std::abs(c.place.normal.dot(first.place.normal)) <= most_cosine; });
            if (second == nullptr) continue;
            const Vector across = first.place.normal.cross(second->place.normal).normalized();
            const Candidate* third =
                cheapest(candidates, [&](const Candidate& c) { return std::abs(c.place.normal.dot(across)) >= least_height; });
            if (third == nullptr) continue;
            const double cost = first.cost + second->cost + third->cost;
            if (cost >= least) continue;
            least = cost;
            best = {first.place, second->place, third->place};
        }
        if (!best.empty()) return best;
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

std::vector<DatumPlace> choose_datum_places(const Journal& journal, const Trail& trail, const Point& from, std::size_t moves) {
    std::vector<Candidate> all = contacts_of(journal, moves);
    std::vector<Point> starts;
    std::vector<Point> touches;
    for (const Candidate& c : all) {
        starts.push_back(c.place.from);
        touches.push_back(c.place.touched);
    }
    const std::vector<double> ways = trail.lengths(from, starts);
    for (std::size_t k = 0; k < all.size(); ++k) all[k].cost += ways[k];
    std::erase_if(all, [](const Candidate& c) { return !std::isfinite(c.cost); });
    std::ranges::stable_sort(all, {}, &Candidate::cost);
    std::vector<Candidate> looked_at;
    const std::size_t rest = all.size() - std::min(kNearest, all.size());
    const std::size_t stride = std::max<std::size_t>(1, rest / kSpread);
    for (std::size_t k = 0; k < all.size(); k += k < kNearest ? 1 : stride) {
        Candidate c = all[k];
        c.place.normal = normal_at(c.place.touched, touches);
        if (!c.place.normal.isZero() && std::abs(c.place.normal.dot(c.place.inwards)) < kSteep) c.place.normal.setZero();
        looked_at.push_back(c);
    }
    std::vector<Candidate> known;
    std::ranges::copy_if(looked_at, std::back_inserter(known), [](const Candidate& c) { return !c.place.normal.isZero(); });
    std::vector<DatumPlace> places = cheapest_triple(known);
    if (places.empty() && !known.empty()) places.push_back(known.front().place);
    if (places.size() < 3) add_by_direction(places, looked_at);
    return places;
}

int independent_directions(const std::vector<DatumPlace>& places) {
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < std::min<std::size_t>(places.size(), 3); ++k) normals.row(static_cast<Eigen::Index>(k)) = places[k].normal;
    const Vector values = normals.jacobiSvd().singularValues();
    return static_cast<int>((values.array() >= kIndependent).count());
}

}  // namespace palpate
