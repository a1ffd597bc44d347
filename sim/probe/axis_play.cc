#include "sim/probe/axis_play.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {

std::vector<PlayAt> play_along(const Vector& way, const Vector& play, const Vector& backlash) {
    // When each axis has taken up its play, and how much of it then.
    std::array<double, 3> taken_up{};
    Vector last = play;
    for (int i = 0; i < 3; ++i) {
        if (way[i] == 0.0) continue;
        const double goal = way[i] > 0 ? 0.0 : backlash[i];
        const double reach = std::abs(goal - play[i]);
        taken_up.at(static_cast<std::size_t>(i)) = std::min(1.0, reach / std::abs(way[i]));
        last[i] = reach <= std::abs(way[i]) ? goal : play[i] - way[i];
    }
    std::vector<double> shares{0.0, 1.0};
    for (const double share : taken_up) {
        if (share > 0.0 && share < 1.0) shares.push_back(share);
    }
    std::ranges::sort(shares);
    shares.erase(std::unique(shares.begin(), shares.end()), shares.end());
    std::vector<PlayAt> plays;
    for (const double share : shares) {
        PlayAt at{share, last};
        for (int i = 0; i < 3; ++i) {
            const double end = taken_up.at(static_cast<std::size_t>(i));
            if (share < end) at.play[i] = play[i] + share / end * (last[i] - play[i]);
        }
        plays.push_back(at);
    }
    return plays;
}

Vector play_at(const std::vector<PlayAt>& plays, double share) {
    const auto next = std::ranges::find_if(plays, [&](const PlayAt& at) { return at.share >= share; });
    if (next == plays.end()) return plays.back().play;
    if (next == plays.begin()) return next->play;
    const PlayAt& before = *(next - 1);
    return before.play + (share - before.share) / (next->share - before.share) * (next->play - before.play);
}

}  // namespace palpate
