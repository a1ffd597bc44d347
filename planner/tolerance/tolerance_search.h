// Where touches make a curved surface through the samples nearer to S than a tolerance
// (planner/DESIGN.md, "Touches where the shape needs them").
//
// Every touch first foretells where it will meet S: on the curved surface. What it finds is a surprise. Surprises over what the surface
// stated of itself scale what it states next.
//
// May not live here: how the tool gets there (planner/loop), the surface itself (planner/curved).
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "planner/deviation_evidence.h"
#include "planner/geometry.h"

namespace palpate {

// Ŝ as the search needs it.
struct SampledSurface {
    TriangleMesh mesh;                     // its points are samples
    std::vector<Point> ball_centres;       // per triangle: of its surface Delaunay ball
    std::vector<double> ball_radii;        // per triangle, mm
    std::vector<std::uint32_t> sample_of;  // per point: its sample
    std::vector<std::uint8_t> is_known;    // per triangle: 1 lies on known solids. Empty: none does
};

class ToleranceSearch {
public:
    struct Options {
        double tolerance = 0.0;    // mm, > 0
        double epsilon = 0.0;      // mm, > 0
        double spacing_min = 0.0;  // mm, >= 0: samples come no nearer to each other
        double touch_error = 0.0;  // mm, >= 0
        std::uint64_t random_seed = 1;
        std::optional<Box> box{};  // the tolerance is asked for in there alone
    };
    explicit ToleranceSearch(const Options& options);

    struct Place {
        Point at = Point::Zero();                // on the curved surface
        Vector normal = Vector::UnitZ();         // unit, outwards
        double stated = 0.0;                     // mm: how far S is from there, as the curved surface has it; 0: it does not say
        double spacing = 0.0;                    // mm: that far from all samples at least, or the touch is not worth it
        std::array<std::uint32_t, 3> samples{};  // of the facet
    };
    // Where the surface is foretold to be beyond the tolerance, spread as evenly as balls are: all at once, but few as long as no surprises
    // tell how good that is. Empty once there is none, or touches do not help any more. Linear time.
    [[nodiscard]] std::vector<Place> places(const SampledSurface& surface);
    // So many, drawn with equal chances by area, or fewer where there is no area. Linear time.
    [[nodiscard]] std::vector<Place> draw(const SampledSurface& surface, std::size_t count);

    // A touch of that place met S there, or nothing. `inserted`: it became a sample.
    void note(const Place& place, const std::optional<Point>& met, bool inserted);
    // It is too near to a sample to be touched.
    void give_up(const Place& place) { in_vain_.push_back(place.at); }
    void note_audit(const Place& place, const std::optional<Point>& met);

    [[nodiscard]] const DeviationEvidence& evidence() const { return evidence_; }
    // About how many touches it took from when places were asked for last, as far as could be foretold then; nothing before.
    [[nodiscard]] std::optional<double> expected_touches() const { return expected_touches_; }

private:
    struct FineSurface;
    [[nodiscard]] FineSurface curved(const SampledSurface& surface) const;
    [[nodiscard]] bool is_asked_for(const Point& p) const { return !options_.box || options_.box->contains(p); }
    // By what the surface states is to be multiplied, as surprises show.
    [[nodiscard]] double scale() const;
    // The same facet's place at its ball's centre, along its dual edge.
    [[nodiscard]] Place centre(const SampledSurface& surface, std::uint32_t facet, Place place) const;
    // S was met so far (mm) from a place of which that much was stated, surprises so far included.
    void compare(double off, double stated);
    [[nodiscard]] static bool is_near(const std::vector<Point>& points, const Place& place);

    const Options options_;
    std::optional<double> expected_touches_;
    std::mt19937_64 random_;
    DeviationEvidence evidence_;
    std::deque<double> surprises_;                    // over what was stated, the latest ones
    std::vector<Point> barred_;                       // nothing was met there, once
    std::vector<Point> in_vain_;                      // ... or twice, or it was touched and no sample came of it
    std::set<std::array<std::uint32_t, 3>> centred_;  // facets whose ball's centre was asked for, by their samples in order
};

}  // namespace palpate
