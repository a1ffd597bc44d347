#include "devices/session/datum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/random.h"

namespace palpate::datum_test {
namespace {

// A place of a solid's surface, with the normal there.
struct Place {
    Point p;
    Vector normal;
};

enum class Solid { sphere, ellipsoid, box, cylinder };

Place random_place(Solid solid, Random& random) {
    const auto sign = [&] { return random.chance(0.5) ? 1.0 : -1.0; };
    switch (solid) {
        case Solid::sphere: {
            const Vector normal = random.direction();
            return {5 * normal, normal};
        }
        case Solid::ellipsoid: {
            const Vector axes(6, 4, 3);
            const Point p = axes.cwiseProduct(random.direction());
            return {p, p.cwiseQuotient(axes.cwiseAbs2()).normalized()};
        }
        case Solid::box: {
            const Point corner(5, 4, 3);
            Point p = random.in_box(-corner, corner);
            const auto axis = static_cast<int>(random.below(3));
            const Vector normal = sign() * Vector::Unit(axis);
            p[axis] = corner[axis] * normal[axis];
            return {p, normal};
        }
        case Solid::cylinder: {
            const double angle = random.uniform(0, 2 * std::numbers::pi);
            const Vector out(std::cos(angle), std::sin(angle), 0);
            if (random.chance(0.7)) return {4 * out + random.uniform(-5, 5) * Vector::UnitZ(), out};
            const Vector normal = sign() * Vector::UnitZ();
            return {5 * normal + 4 * std::sqrt(random.uniform(0, 1)) * out, normal};
        }
    }
    return {};
}

struct Touched {
    Journal journal;
    std::vector<Vector> normals;  // by contact
};

constexpr double kNoise = 0.01;
constexpr double kTouchError = 0.012;
constexpr double kFlattest = 0.4;  // of a touch: its cosine with the normal

// `count` touches of random places that are at least `least` from the middle along `axis`, at random angles.
Touched touch(Solid solid, std::size_t count, const Vector& axis, double least, Random& random) {
    Touched touched;
    touched.journal.header.start = Point(0, 0, 14);
    while (touched.normals.size() < count) {
        const Place place = random_place(solid, random);
        if (place.p.dot(axis) < least) continue;
        Vector inwards = random.direction();
        while (inwards.dot(place.normal) > -kFlattest) inwards = random.direction();
        JournalMove there;
        there.target = there.rest = there.result.position = place.p - random.uniform(0.5, 2) * inwards;
        there.result.outcome = MoveResult::Outcome::reached;
        there.line = touched.journal.moves.size() + 1;
        JournalMove touch;
        touch.target = place.p + inwards;
        touch.pace = Pace::probe;
        touch.result.outcome = MoveResult::Outcome::contact;
        touch.result.position = place.p + random.uniform(-kNoise, kNoise) * inwards;
        touch.rest = place.p - 0.2 * inwards;
        touch.line = there.line + 1;
        touched.journal.moves.insert(touched.journal.moves.end(), {there, touch});
        touched.normals.push_back(place.normal);
    }
    return touched;
}

std::vector<DatumPlace> choose(const Journal& journal) {
    const VisitedWays visited_ways(journal, Region(Ball{Point::Zero(), 9}));
    return choose_datum_places(journal, visited_ways, journal.last_rest(), journal.moves.size());
}

const Vector& true_normal(const Touched& touched, const DatumPlace& place) { return touched.normals[place.line / 2 - 1]; }

// What a session sees of a shift at a place: along the way of the touch, then along what it takes for the normal.
double offset_of(const Vector& shift, const DatumPlace& place, const Vector& normal) {
    return std::abs(place.normal.dot(place.inwards) * shift.dot(normal) / place.inwards.dot(normal));
}

double degrees_between(const Vector& a, const Vector& b) { return std::acos(std::min(1.0, a.dot(b))) * 180 / std::numbers::pi; }

template <class Use>
void for_random_sessions(std::uint64_t seed, const Use& use) {
    constexpr int kSessions = 60;
    Random random(seed);
    for (const Solid solid : {Solid::sphere, Solid::ellipsoid, Solid::box, Solid::cylinder}) {
        for (const std::size_t count : {15U, 40U, 100U, 300U}) {
            for (int session = 0; session < kSessions; ++session) {
                // Half of them have seen one side only.
                const double least = session % 2 == 0 ? -10.0 : 0.5;
                SCOPED_TRACE("solid " + std::to_string(static_cast<int>(solid)) + ", " + std::to_string(count) + " touches, session " +
                             std::to_string(session));
                use(touch(solid, count, random.direction(), least, random), count, random);
                if (testing::Test::HasFailure()) return;
            }
        }
    }
}

TEST(Datum, AShiftOfFiveTouchErrorsIsMoreThanTwoAtOnePlaceIfDirectionsAreThree) {
    constexpr std::uint64_t kSeed = 11;
    constexpr int kShifts = 500;
    SCOPED_TRACE(seed_text(kSeed));
    int large = 0;
    int large_with_three = 0;
    for_random_sessions(kSeed, [&](const Touched& touched, std::size_t count, Random& random) {
        const std::vector<DatumPlace> places = choose(touched.journal);
        ASSERT_LE(places.size(), 3U);
        const bool is_three = independent_directions(places) == 3;
        if (count == 300) ++large;
        if (count == 300 && is_three) ++large_with_three;
        if (!is_three) return;
        for (int k = 0; k < kShifts; ++k) {
            const Vector shift = 5 * kTouchError * random.direction();
            double most = 0;
            for (const DatumPlace& place : places) most = std::max(most, offset_of(shift, place, true_normal(touched, place)));
            ASSERT_GT(most, 2 * kTouchError) << shift.transpose();
        }
    });
    EXPECT_GE(large_with_three, 0.97 * large) << "of " << large;
}

TEST(Datum, NormalsOfChosenPlacesAreThoseOfTheSolid) {
    constexpr std::uint64_t kSeed = 12;
    SCOPED_TRACE(seed_text(kSeed));
    int known = 0;
    int rough = 0;
    int wrong = 0;
    for_random_sessions(kSeed, [&](const Touched& touched, std::size_t count, Random&) {
        for (const DatumPlace& place : choose(touched.journal)) {
            if (place.normal.isZero()) continue;
            EXPECT_NEAR(place.normal.norm(), 1, 1e-9);
            EXPECT_LT(place.normal.dot(place.inwards), -0.7) << "too flat a touch";
            if (count < 100) continue;
            const double off = degrees_between(place.normal, true_normal(touched, place));
            ++known;
            if (off > 10) ++rough;
            if (off > 30) ++wrong;
        }
    });
    EXPECT_GT(known, 1000);
    EXPECT_LT(rough, 0.02 * known);
    EXPECT_LT(wrong, 0.003 * known) << "a place on an edge may be taken for one of the other face";
}

TEST(Datum, OnOneFaceOnlyOneDirectionIsShown) {
    Random random(13);
    Touched touched;
    while (touched.normals.size() < 50) {
        const Touched one = touch(Solid::box, 1, Vector::UnitZ(), 2.999, random);
        if (one.normals[0] != Vector::UnitZ()) continue;
        for (JournalMove move : one.journal.moves) {
            move.line = touched.journal.moves.size() + 1;
            touched.journal.moves.push_back(move);
        }
        touched.normals.push_back(one.normals[0]);
    }
    const std::vector<DatumPlace> places = choose(touched.journal);
    EXPECT_EQ(places.size(), 3U) << "what can be had is touched";
    EXPECT_EQ(independent_directions(places), 1);
    EXPECT_TRUE(choose(Journal{}).empty());
}

TEST(Datum, DirectionsAreThoseOfTheNormals) {
    const auto directions = [](const std::vector<Vector>& normals) {
        std::vector<DatumPlace> places;
        for (const Vector& normal : normals) {
            places.emplace_back();
            places.back().normal = normal;
        }
        return independent_directions(places);
    };
    const Vector x = Vector::UnitX();
    const Vector y = Vector::UnitY();
    const Vector z = Vector::UnitZ();
    EXPECT_EQ(directions({}), 0);
    EXPECT_EQ(directions({Vector::Zero(), Vector::Zero(), Vector::Zero()}), 0);
    EXPECT_EQ(directions({x}), 1);
    EXPECT_EQ(directions({x, -x, x}), 1);
    EXPECT_EQ(directions({x, y}), 2);
    EXPECT_EQ(directions({x, y, Vector::Zero()}), 2);
    EXPECT_EQ(directions({x, y, (x + y).normalized()}), 2);
    EXPECT_EQ(directions({x, y, (x + y + z).normalized()}), 2) << "too near to their plane";
    EXPECT_EQ(directions({x, y, z}), 3);
    EXPECT_EQ(directions({x, -y, (z + 0.2 * x).normalized()}), 3);
}

}  // namespace
}  // namespace palpate::datum_test
