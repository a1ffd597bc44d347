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
    // So much is `done` of `whole`, as far as that is known now, in any unit that stays the same; time never falls.
    void note(std::chrono::nanoseconds now, double done, double whole = 1.0);
    // "3 min left", or nothing as long as too little is done to tell.
    [[nodiscard]] std::string text() const;
    // Negative as long as too little is done to tell.
    [[nodiscard]] std::chrono::nanoseconds left() const;

private:
    struct Moment {
        std::chrono::nanoseconds time{0};
        double done = 0.0;
    };
    std::chrono::nanoseconds begun_{0};
    double whole_ = 1.0;
    std::deque<Moment> moments_;  // of the later half of the run: what is replayed from a journal goes faster than a machine
};

}  // namespace palpate
