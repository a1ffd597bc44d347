// Shows how far a run is: one line that rewrites itself on a terminal, plain lines in a pipe.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <ostream>
#include <string>

#include "planner/progress.h"

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

class ProgressDisplay {
public:
    using Clock = std::function<std::chrono::nanoseconds()>;  // time since any fixed moment

    // Writes to `out`, which must outlive the display. The default clock is std::chrono::steady_clock.
    explicit ProgressDisplay(std::ostream& out, DisplayTraits traits, Clock clock = {});
    // Leaves the terminal on a fresh line, also after an exception.
    ~ProgressDisplay();
    ProgressDisplay(const ProgressDisplay&) = delete;
    ProgressDisplay& operator=(const ProgressDisplay&) = delete;
    ProgressDisplay(ProgressDisplay&&) = delete;
    ProgressDisplay& operator=(ProgressDisplay&&) = delete;

    // To be called as often as one likes: draws at most every 0.1 s on a terminal, every 2 s in a pipe, and otherwise
    // costs a look at the clock.
    void update(const Progress& progress);
    // Takes the line away, so that something else can be printed; the next update draws it again.
    void clear();
    // Draws `progress` for good and ends the line.
    void finish(const Progress& progress);

private:
    void draw(const Progress& progress);

    std::ostream& out_;
    DisplayTraits traits_;
    Clock clock_;
    std::optional<std::chrono::nanoseconds> last_drawn_;
    bool line_open_ = false;  // the cursor is behind a line of ours that has no end yet
};

// The line, at most `columns` wide: percent, bar and counts; when it is narrow, the last ones go first. Without escape sequences unless
// `colours`.
[[nodiscard]] std::string progress_line(const Progress& progress, int columns, bool unicode, bool colours);

}  // namespace palpate
