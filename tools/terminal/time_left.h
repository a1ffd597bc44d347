// How long a run will still take, as far as what was done so far tells.
#pragma once

#include <chrono>
#include <deque>
#include <string>

namespace palpate {

// "3 min", as exact as anybody would say it.
[[nodiscard]] std::string duration_text(std::chrono::duration<double> time);

class TimeLeft {
public:
    // `fraction` of the run, in [0, 1], is done; neither falls from call to call.
    void note(std::chrono::nanoseconds now, double fraction);
    // "3 min left", or nothing as long as too little is done to tell.
    [[nodiscard]] std::string text() const;
    // Negative as long as too little is done to tell.
    [[nodiscard]] std::chrono::nanoseconds left() const;

private:
    struct Moment {
        std::chrono::nanoseconds time{0};
        double fraction = 0.0;
    };
    std::chrono::nanoseconds begun_{0};
    std::deque<Moment> moments_;  // of the later half of the run: what is replayed from a journal goes faster than a machine
};

}  // namespace palpate
