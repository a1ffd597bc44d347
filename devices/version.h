// Which Palpate this is: what files say of the program that wrote them.
#pragma once

#include <string_view>

namespace palpate {

// "0.1.0": the version of CMakeLists.txt.
[[nodiscard]] std::string_view program_version();

}  // namespace palpate
