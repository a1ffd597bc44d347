// Shows how far a run is: one line that rewrites itself on a terminal, plain lines in a pipe.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "planner/progress.h"
#include "tools/terminal/time_left.h"

namespace palpate {

// What the far end of a stream can do.
struct DisplayTraits {
    bool rewrites = false;  // a terminal that understands "\r" and "erase to the end of the line"
    bool colours = false;
    bool unicode = false;        // block characters for the bar
    std::function<int()> width;  // columns, asked for at every drawing, as windows are resized; empty or ≤ 0: unknown

    // Of a file descriptor: is it a terminal, what do TERM, NO_COLOR and the locale's variables say? Throws nothing.
    [[nodiscard]] static DisplayTraits of(int file_descriptor);
};

// Where lines go that stay, and one that rewrites itself until it is empty.
struct ProgressSink {
    std::function<void(const std::string&)> line;
    std::function<void(const std::string&)> status;
};

class ProgressDisplay {
public:
    using Clock = std::function<std::chrono::nanoseconds()>;  // time since any fixed moment

    // The default clock is std::chrono::steady_clock.
    ProgressDisplay(ProgressSink sink, DisplayTraits traits, Clock clock = {});
    // Leaves the last status where it is, as a line of its own, also after an exception.
    ~ProgressDisplay();
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;
    ProgressDisplay(ProgressDisplay&&) = delete;
    ProgressDisplay& operator=(ProgressDisplay&&) = delete;

    // To be called as often as one likes: draws at most every 0.1 s on a terminal, every 2 s in a pipe, and otherwise
    // costs a look at the clock.
    void update(const Progress& progress, const TimeLeft& time_left = {});
    // Draws `progress` for good.
    void finish(const Progress& progress);

private:
    [[nodiscard]] std::string text(const Progress& progress, const TimeLeft& time_left) const;

    ProgressSink sink_;
    DisplayTraits traits_;
    Clock clock_;
    std::optional<std::chrono::nanoseconds> last_drawn_;
    std::string status_;  // drawn now, if any is
};

// The line, at most `columns` wide: percent, bar, the time that is left if it is known, and counts; when it is narrow, the last ones go
// first.
[[nodiscard]] std::string progress_line(const Progress& progress, const std::string& time_left, int columns, bool unicode);

}  // namespace palpate
