#include "config/internal/utf8.h"

#include <cstddef>

namespace palpate::yaml {

namespace {

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

// Bytes of the character that starts with `c`; 0 when none can. C0, C1 and F5 to FF start nothing.
std::size_t length_from(char c) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80U) {
        return 1;
    }
    if (byte >= 0xC2U && byte < 0xE0U) {
        return 2;
    }
    if (byte >= 0xE0U && byte < 0xF0U) {
        return 3;
    }
    return byte >= 0xF0U && byte < 0xF5U ? 4 : 0;
}

}  // namespace

bool is_utf8(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = length_from(text[i]);
        if (length == 0 || i + length > text.size()) {
            return false;
        }
        for (std::size_t k = 1; k < length; ++k) {
            if (!is_continuation(text[i + k])) {
                return false;
            }
        }
        i += length;
    }
    return true;
}

}  // namespace palpate::yaml
