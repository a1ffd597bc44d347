#include "config/internal/numbers.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <system_error>

#include "planner/number_text.h"

namespace palpate::yaml {

namespace {

constexpr long double kRadiansPerDegree = std::numbers::pi_v<long double> / 180.0L;
// Up to 360 without an exponent, and enough for any long double of up to 113 bits.
constexpr int kMinDegreeDigits = 3;
constexpr int kMaxDegreeDigits = 36;

double to_radians(long double degrees) { return static_cast<double>(degrees * kRadiansPerDegree); }

bool names_no_finite_number(std::string_view text) {
    if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
        text.remove_prefix(1);
    }
    if (!text.empty() && text.front() == '.') {
        text.remove_prefix(1);
    }
    return text == "inf" || text == "Inf" || text == "INF" || text == "nan" || text == "NaN" || text == "NAN";
}

template <class Real>
Real read_real(const Value& node, const Spot& spot) {
    if (node.kind != Value::Kind::scalar || node.quoted) {
        refuse(node, spot, "is not a number");
    }
    if (names_no_finite_number(node.text)) {
        refuse(node, spot, "is not finite");
    }
    std::string_view text = node.text;
    if (text.size() > 1 && text.front() == '+' && text[1] != '-') {
        text.remove_prefix(1);
    }
    Real value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end != text.data() + text.size() || error == std::errc::invalid_argument) {
        refuse(node, spot, "is not a number");
    }
    if (error == std::errc::result_out_of_range || !std::isfinite(value)) {
        refuse(node, spot, "is beyond the range of floating-point numbers");
    }
    return value;
}

void require_finite(double value) {
    if (!std::isfinite(value)) {
        throw std::invalid_argument("a configuration holds a number that is not finite");
    }
}

}  // namespace

std::string Bounds::text() const {
    if (high < std::numeric_limits<double>::infinity()) {
        // For people: 1000000, not 1e+06.
        return low_included ? fmt::format("from {} to {}", low, high) : fmt::format("greater than {}, at most {}", low, high);
    }
    return fmt::format("{} {}", low_included ? "at least" : "greater than", number_text(low));
}

std::string with_unit(const std::string& range, std::string_view unit) {
    return unit.empty() ? range : fmt::format("{} ({})", range, unit);
}

void refuse(const Value& node, const Spot& spot, const std::string& why) {
    fail(node.where, spot.path, fmt::format("{} {}; allowed: {}", spell(node), why, spot.allowed));
}

double read_number(const Value& node, const Bounds& bounds, const Spot& spot) {
    const auto value = read_real<double>(node, spot);
    if (!bounds.contain(value)) {
        refuse(node, spot, "is out of range");
    }
    return value;
}

std::uint64_t read_whole_number(const Value& node, std::uint64_t low, std::uint64_t high, const Spot& spot) {
    if (node.kind != Value::Kind::scalar || node.quoted) {
        refuse(node, spot, "is not a whole number");
    }
    std::uint64_t value = 0;
    const char* last = node.text.data() + node.text.size();
    const auto [end, error] = std::from_chars(node.text.data(), last, value);
    if (end != last || error == std::errc::invalid_argument) {
        refuse(node, spot, "is not a whole number");
    }
    if (error == std::errc::result_out_of_range || value < low || value > high) {
        refuse(node, spot, "is out of range");
    }
    return value;
}

double read_degrees(const Value& node, const Bounds& bounds, const Spot& spot) {
    const auto degrees = read_real<long double>(node, spot);
    if (!bounds.contain(static_cast<double>(degrees))) {
        refuse(node, spot, "is out of range");
    }
    return to_radians(degrees);
}

std::string number_text(double value) {
    require_finite(value);
    return palpate::number_text(value);
}

std::string degrees_text(double radians) {
    require_finite(radians);
    const long double degrees = static_cast<long double>(radians) / kRadiansPerDegree;
    std::array<char, 64> buffer{};
    for (int digits = kMinDegreeDigits; digits <= kMaxDegreeDigits; ++digits) {
        char* const end = std::to_chars(buffer.begin(), buffer.end(), degrees, std::chars_format::general, digits).ptr;
        long double back = 0.0L;
        std::from_chars(buffer.begin(), end, back);
        if (to_radians(back) == radians) {
            return {buffer.begin(), end};
        }
    }
    throw std::invalid_argument(fmt::format("an angle of {} radians cannot be written in degrees", number_text(radians)));
}

}  // namespace palpate::yaml
