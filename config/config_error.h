// What config/ throws on bad input.
#pragma once

#include <stdexcept>

namespace palpate {

// The message reads `file:line: key: what; allowed: …`. For a value given on the command line, `--set key=value` takes
// the place of `file:line`; what concerns a whole file has no line and no key.
class ConfigError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace palpate
