// Numbers of binary data, with the byte that they stand at.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string>
#include <string_view>

#include "sim/objects/errors.h"

namespace palpate {

class ByteReader {
public:
    ByteReader(std::string_view bytes, std::size_t offset, std::endian order) : bytes_(bytes), offset_(offset), order_(order) {}

    // Throws ObjectError if the data ends before; `expected` says what should be there ("a coordinate").
    template <class Number>
    Number take(std::string_view expected) {
        number_offset_ = offset_;
        std::array<char, sizeof(Number)> raw{};
        if (bytes_.size() - offset_ < raw.size()) {
            number_offset_ = bytes_.size();
            refuse(fmt::format("the file ends where {} was expected", expected));
        }
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset_), raw.size(), raw.begin());
        offset_ += raw.size();
        if (order_ != std::endian::native) std::ranges::reverse(raw);
        return std::bit_cast<Number>(raw);
    }

    [[nodiscard]] std::string_view rest() const { return bytes_.substr(offset_); }

    // "byte 355: what", where 355 bytes come before the last number.
    [[noreturn]] void refuse(const std::string& what) const { throw ObjectError(fmt::format("byte {}: {}", number_offset_, what)); }

private:
    std::string_view bytes_;
    std::size_t offset_;
    std::endian order_;
    std::size_t number_offset_ = 0;
};

}  // namespace palpate
