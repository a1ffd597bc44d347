// Where what a command says goes: results to standard output, progress, messages and warnings to the console.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>

#include "tools/terminal/console.h"

namespace palpate {

struct Output {
    std::ostream& results;
    Console& console;
    // Instead of text for people: one JSON object per line and event, on standard output. Like the console it is waited for by nobody until
    // what moves has come to rest.
    Console* events = nullptr;
    int columns = 0;        // of the terminal that the results go to; 0: none
    bool is_quiet = false;  // no progress, and of messages only warnings and errors
};

// An event as its line. What is no UTF-8 in it, a file's name perhaps, is replaced.
[[nodiscard]] std::string event_line(const nlohmann::ordered_json& event);

}  // namespace palpate
