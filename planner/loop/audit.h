// Which inferred facets are touched anyway, and how many (planner/DESIGN.md, "Inference").
//
// Drawn once all else is done, with equal chances from all facets that nothing but inference put into the mesh: what the touches find is
// a fair sample of what is left untouched.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <set>
#include <vector>

namespace palpate {

class Audit {
public:
    // So many touches that agree say with 95 % confidence that not one facet in a hundred is wrong.
    static constexpr std::size_t kEnough = 300;
    // Of small runs so many are touched, ...
    static constexpr std::size_t kLeast = 60;
    // ... but never more than this share of the samples.
    static constexpr double kLargestPerSample = 0.05;

    using Facet = std::array<std::uint32_t, 3>;  // its samples in order

    // `share`, in [0, 1], of the inferred facets; 0: none.
    Audit(double share, std::uint64_t random_seed) : share_(share), random_(random_seed) {}

    // How many are to be touched of so many inferred facets on so many samples.
    [[nodiscard]] std::size_t quota(std::size_t inferred, std::size_t samples) const;
    // Those to touch now, none of which was drawn before; empty once enough were touched, or none is left to draw from. Where a touch led
    // to surface that nobody knew of, its facets are drawn from as the others were. `inferred`: all facets that are inferred by now, none
    // twice. `samples`: all by now; the quota is of `counted`, or of all.
    [[nodiscard]] std::vector<Facet> draw(std::vector<Facet> inferred, std::size_t samples, std::optional<std::size_t> counted = {});
    // A facet that was drawn was touched.
    void note(bool agrees);
    // No way led to one.
    void note_barred() { ++barred_; }

    [[nodiscard]] std::uint64_t touched() const { return touched_; }
    [[nodiscard]] std::uint64_t wrong() const { return wrong_; }
    [[nodiscard]] std::uint64_t barred() const { return barred_; }

private:
    const double share_;
    std::mt19937_64 random_;
    std::uint64_t touched_ = 0;
    std::uint64_t wrong_ = 0;
    std::uint64_t barred_ = 0;
    std::size_t samples_ = 0;  // when it was drawn last; 0: never
    std::set<Facet> drawn_;
};

}  // namespace palpate
