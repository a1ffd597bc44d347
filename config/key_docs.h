// What config/README.md says of each key, from where the keys are declared.
#pragma once

#include <string>
#include <vector>

namespace palpate {

// One row of the table in config/README.md.
struct KeyDoc {
    std::string key;  // full, with "[]" for "each element of"
    std::string type;
    std::string unit;
    std::string default_value;
    std::string range;
    std::string meaning;
};

// Every key that read_config accepts, in the order of reading. Declared for both at once, so that none can be missed. The
// parts of a union are shapes again and appear once, under object.shape.
[[nodiscard]] std::vector<KeyDoc> documented_keys();

}  // namespace palpate
