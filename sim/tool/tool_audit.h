// Independent account of what the body of a moving tool did: did any part of it enter the hidden object or a fixture, and what touched.
#pragma once

#include <array>
#include <cstdint>

#include "sim/tool/tool_depth.h"

namespace palpate {

struct ToolAccount {
    std::uint64_t moves = 0;
    // Moves that began in it or entered it, deeper than the tolerance. One that does both counts for both.
    std::uint64_t moves_into_object = 0;
    std::uint64_t moves_into_fixtures = 0;
    std::uint64_t unsafe_moves = 0;  // either, each counted once
    ToolDepth deepest;               // mm

    // Touches of that part of the tool with the object, or with a fixture.
    [[nodiscard]] std::uint64_t& touches(ToolContact::Part part, ToolContact::Met met) {
        return touches_.at(static_cast<std::size_t>(part)).at(static_cast<std::size_t>(met));
    }
    [[nodiscard]] std::uint64_t touches(ToolContact::Part part, ToolContact::Met met) const {
        return touches_.at(static_cast<std::size_t>(part)).at(static_cast<std::size_t>(met));
    }

private:
    std::array<std::array<std::uint64_t, 2>, 3> touches_{};
};

// Measures distances along every move (ToolDepths), not the first contact that the tool stops at, so that an error there shows.
class ToolAudit {
public:
    // `tolerance` (mm): what a move may be deep, such as a machine's overtravel. `depths` must outlive the audit.
    explicit ToolAudit(const ToolDepths& depths, double tolerance = kTolerance_mm) : depths_(depths), tolerance_(tolerance) {}

    // A straight move of the reference point that was carried out; whether it ended at a touch.
    void record(const Segment& move, bool touched);

    [[nodiscard]] const ToolAccount& account() const { return account_; }

    // mm: far above rounding, and above 1e-9 of lengths up to half a metre, by which a contact may be deeper if it only grazes; far below
    // what a machine resolves.
    static constexpr double kTolerance_mm = 1e-6;

private:
    const ToolDepths& depths_;
    double tolerance_;
    ToolAccount account_;
};

}  // namespace palpate
