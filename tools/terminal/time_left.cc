#include "tools/terminal/time_left.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// A guess from less would be worth nothing.
constexpr double kEnough = 0.1;

}  // namespace

void TimeLeft::note(std::chrono::nanoseconds now, double done, double whole) {
    whole_ = whole;
    if (moments_.empty()) begun_ = now;
    moments_.push_back({now, moments_.empty() ? done : std::max(done, moments_.back().done)});
    while (moments_.size() > 2 && moments_[1].time - begun_ <= (now - begun_) / 2) moments_.pop_front();
}

std::chrono::nanoseconds TimeLeft::left() const {
    if (moments_.empty() || !(moments_.back().done >= kEnough * whole_)) return std::chrono::nanoseconds(-1);
    const double done = moments_.back().done - moments_.front().done;
    if (!(done > 0)) return std::chrono::nanoseconds(-1);
    const double seconds = std::chrono::duration<double>(moments_.back().time - moments_.front().time).count();
    return std::chrono::nanoseconds(std::llround(1e9 * seconds * std::max(0.0, whole_ - moments_.back().done) / done));
}

std::string TimeLeft::text() const {
    const std::chrono::nanoseconds left = this->left();
    return left.count() < 0 ? "" : fmt::format("{} left", duration_text(left));
}

std::string duration_text(std::chrono::duration<double> time) {
    constexpr long long kMinute = 60;
    constexpr long long kHour = 60 * kMinute;
    const long long seconds = std::llround(time.count());
    if (seconds < kMinute) return fmt::format("{} s", seconds);
    if (seconds < kHour) return fmt::format("{} min", (seconds + kMinute / 2) / kMinute);
    return fmt::format("{} h {} min", seconds / kHour, seconds % kHour / kMinute);
}

}  // namespace palpate
