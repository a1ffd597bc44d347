// YAML is Unicode: bytes that are not UTF-8 cannot be written down in it.
#pragma once

#include <string_view>

namespace palpate::yaml {

// Is `text` made of whole UTF-8 characters? Throws nothing.
[[nodiscard]] bool is_utf8(std::string_view text);

}  // namespace palpate::yaml
