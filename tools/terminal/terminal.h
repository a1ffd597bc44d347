// The terminal that the operator sits at, whatever standard input and output lead to.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

#include "tools/terminal/stop_signals.h"

namespace palpate {

class Terminal {
public:
    // The controlling terminal of this process, or nothing.
    [[nodiscard]] static std::optional<Terminal> of_process();
    ~Terminal();
    Terminal(Terminal&& other) noexcept;
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;
    Terminal& operator=(Terminal&&) = delete;

    // Until the terminal takes text, or a stop.
    void wait_while_held(StopSignals& signals) const;
    // Waits for a terminal that is held, until a stop.
    void say(std::string_view text, StopSignals& signals) const;
    // Says it. What was typed before its last character is out, blindly on a terminal that is held, is no answer and dropped.
    void pose(std::string_view question, StopSignals& signals) const;
    // What is typed after the question, without the end of its line, or what of it came before the end of the file or a stop. After a
    // pause the question is asked again.
    [[nodiscard]] std::string ask(std::string_view question, StopSignals& signals) const;
    // Waits so long. True if something was entered.
    [[nodiscard]] bool is_line_entered(std::chrono::milliseconds patience) const;

private:
    explicit Terminal(int file) : file_(file) {}

    int file_ = -1;
};

}  // namespace palpate
