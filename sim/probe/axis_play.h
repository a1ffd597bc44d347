// Backlash: where axes with play really are, while a machine counts steps.
//
// The play of an axis is how much higher it is than the machine says: 0 after it went up, the backlash after it went down. Between, when
// it turns, it stands still until the play is taken up.
#pragma once

#include <vector>

#include "planner/geometry.h"

namespace palpate {

struct PlayAt {
    double share = 0.0;  // of the way, 0 to 1
    Vector play = Vector::Zero();
};

// Along a straight way (mm, as the machine says), beginning with `play`: linear between the elements, whose first is at 0 and last at 1.
// REQUIRES: backlash >= 0, play from 0 to that.
[[nodiscard]] std::vector<PlayAt> play_along(const Vector& way, const Vector& play, const Vector& backlash);

// At that share of the way. REQUIRES: what play_along() gives.
[[nodiscard]] Vector play_at(const std::vector<PlayAt>& plays, double share);

}  // namespace palpate
