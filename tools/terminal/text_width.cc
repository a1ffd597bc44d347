#include "tools/terminal/text_width.h"

#include <sys/ioctl.h>

#include <algorithm>

namespace palpate {

int columns_of(int file_descriptor) {
    winsize size{};
    return ::ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 ? int{size.ws_col} : 0;
}

std::size_t width_of(const std::string& text) {
    constexpr unsigned kKind = 0xC0U;
    constexpr unsigned kContinuation = 0x80U;
    return static_cast<std::size_t>(
        std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & kKind) != kContinuation; }));
}

std::string wrapped(const std::string& text, int columns, int indent) {
    if (columns <= indent) return text;
    std::string result;
    std::size_t used = 0;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(' ', begin + 1), text.size());  // with the blank before it
        const std::string word = text.substr(begin, end - begin);
        if (used > static_cast<std::size_t>(indent) && used + width_of(word) > static_cast<std::size_t>(columns)) {
            result += '\n' + std::string(static_cast<std::size_t>(indent), ' ');
            result += word.substr(word.find_first_not_of(' '));
            used = static_cast<std::size_t>(indent) + width_of(word) - 1;
        } else {
            result += word;
            used += width_of(word);
        }
        begin = end;
    }
    return result;
}

}  // namespace palpate
