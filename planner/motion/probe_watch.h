// Does the probe still work? Only a contact shows that: a probe that has died answers like free space (devices/FACTS.md, "Safety floor").
#pragma once

#include <vector>

#include "planner/geometry.h"

namespace palpate {

class ProbeWatch {
public:
    // `overtravel`, `epsilon`, `longest_hop`: mm.
    ProbeWatch(double overtravel, double epsilon, double longest_hop)
        : overtravel_(overtravel), epsilon_(epsilon), longest_hop_(longest_hop) {}

    void note_contact();
    // A guarded move through ground that nothing but its own answer shows to be free.
    void note_clear(const Segment& way);
    // The probe was shown to work without a touch of S.
    void note_proof();
    // A contact that had stayed away was found when asked for again.
    void note_recovery() { misses_touches_ = true; }

    [[nodiscard]] bool has_contact() const { return has_contact_; }
    // Clears came since the last contact.
    [[nodiscard]] bool is_in_doubt() const { return clears_ > 0; }
    // So many came, or such a long way of them, that a known place has to be touched.
    [[nodiscard]] bool is_due() const;
    // Whether a straight way is known to be free by clears alone, since the last contact. Before the first every way is, and for a probe
    // that misses touches.
    [[nodiscard]] bool is_unconfirmed(const Segment& way) const;
    // The probe misses a touch now and then: one that stays away tells less, and is asked for twice.
    [[nodiscard]] bool misses_touches() const { return misses_touches_; }
    // mm: how far beyond an expected contact a move may end.
    [[nodiscard]] double overtravel() const { return overtravel_; }
    // mm: how far the tool may go, guarded, through what is not known to be free, to come to a known place.
    [[nodiscard]] double longest_hop() const { return longest_hop_; }

    static constexpr int kMaxClears = 40;
    static constexpr double kMaxWay = 40.0;  // of ε: the way of those clears

private:
    double overtravel_;
    double epsilon_;
    double longest_hop_;
    bool has_contact_ = false;
    bool misses_touches_ = false;
    int clears_ = 0;
    double way_ = 0.0;                  // mm, of clears
    std::vector<Segment> unconfirmed_;  // their ways
};

}  // namespace palpate
