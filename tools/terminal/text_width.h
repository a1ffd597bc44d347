// Text in the width that the operator's window has.
#pragma once

#include <string>

namespace palpate {

// The columns of the terminal that a file descriptor leads to; 0: it leads to none, or to one that does not say.
[[nodiscard]] int columns_of(int file_descriptor);

// The number of characters of a UTF-8 text.
[[nodiscard]] std::size_t width_of(const std::string& text);

// Broken at blanks into lines of at most `columns`, all but the first begun with `indent` blanks. 0 columns: not at all. A word that is
// longer stays whole.
[[nodiscard]] std::string wrapped(const std::string& text, int columns, int indent);

}  // namespace palpate
