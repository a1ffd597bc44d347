#include "devices/calibration/probe_calibration.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;
using Shaft = ToolShape::Shaft;

// Of tools and feeds that are the same: they come from configurations, where they are written with fewer digits.
constexpr double kSame = 1e-6;

// An object whose keys are taken one after the other; what is left over is an error.
class Keys {
public:
    Keys(Json json, std::string name, std::string path) : json_(std::move(json)), name_(std::move(name)), path_(std::move(path)) {
        if (!json_.is_object()) fail(path_.empty() ? "is no JSON object" : fmt::format("\"{}\" is no object", path_));
    }

    [[noreturn]] void fail(const std::string& what) const { throw CalibrationError(fmt::format("{}: {}", name_, what)); }
    Json take(const char* key) {
        const auto found = json_.find(key);
        if (found == json_.end()) fail(fmt::format("\"{}\" is missing", full(key)));
        Json value = std::move(*found);
        json_.erase(found);
        return value;
    }
    Keys take_object(const char* key) { return {take(key), name_, full(key)}; }
    std::optional<Keys> take_object_or_null(const char* key) {
        Json value = take(key);
        if (value.is_null()) return std::nullopt;
        return Keys(std::move(value), name_, full(key));
    }
    std::string take_text(const char* key) {
        const Json value = take(key);
        if (!value.is_string()) fail(fmt::format("\"{}\" is no text", full(key)));
        return value.get<std::string>();
    }
    double take_number(const char* key) { return number(take(key), key); }
    double take_positive(const char* key) {
        const double value = take_number(key);
        if (!(value > 0)) fail(fmt::format("\"{}\" is {}, it has to be positive", full(key), value));
        return value;
    }
    double take_size(const char* key) {
        const double value = take_number(key);
        if (value < 0) fail(fmt::format("\"{}\" is {}, it cannot be negative", full(key), value));
        return value;
    }
    std::size_t take_count(const char* key) {
        const Json value = take(key);
        if (!value.is_number_unsigned()) fail(fmt::format("\"{}\" is no count", full(key)));
        return value.get<std::size_t>();
    }
    template <std::size_t N>
    std::array<double, N> take_numbers(const char* key) {
        const Json value = take(key);
        if (!value.is_array() || value.size() != N) fail(fmt::format("\"{}\" is no list of {} numbers", full(key), N));
        std::array<double, N> numbers{};
        for (std::size_t k = 0; k < N; ++k) numbers[k] = number(value[k], key);
        return numbers;
    }
    void finish() const {
        if (!json_.empty()) fail(fmt::format("\"{}\" is unknown", full(json_.begin().key())));
    }

private:
    [[nodiscard]] double number(const Json& value, const char* key) const {
        if (!value.is_number() || !std::isfinite(value.get<double>())) fail(fmt::format("\"{}\" is no number", full(key)));
        return value.get<double>();
    }
    [[nodiscard]] std::string full(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

    Json json_;
    std::string name_;
    std::string path_;
};

// "2026-01-31", or that and what begins with "T".
bool is_date(std::string_view text) {
    constexpr std::string_view kForm = "0000-00-00";
    if (text.size() < kForm.size() || (text.size() > kForm.size() && text[kForm.size()] != 'T')) return false;
    for (std::size_t k = 0; k < kForm.size(); ++k) {
        const bool is_digit = text[k] >= '0' && text[k] <= '9';
        if (kForm[k] == '0' ? !is_digit : text[k] != kForm[k]) return false;
    }
    return true;
}

Json json_of(const std::optional<Shaft>& shaft) {
    if (!shaft) return nullptr;
    return {{"diameter_mm", shaft->diameter}, {"length_mm", shaft->length}};
}

std::optional<Shaft> take_shaft(Keys& tool, const char* key) {
    std::optional<Keys> keys = tool.take_object_or_null(key);
    if (!keys) return std::nullopt;
    const double diameter = keys->take_positive("diameter_mm");
    const double length = keys->take_positive("length_mm");
    keys->finish();
    return Shaft{diameter, length};
}

ToolShape take_tool(Keys& file) {
    Keys keys = file.take_object("tool");
    ToolShape tool;
    tool.ball_diameter = keys.take_positive("ball_diameter_mm");
    tool.stylus = take_shaft(keys, "stylus");
    tool.holder = take_shaft(keys, "holder");
    const std::array<double, 3> axis = keys.take_numbers<3>("axis");
    tool.axis = {axis[0], axis[1], axis[2]};
    if (std::abs(tool.axis.norm() - 1) > kSame) keys.fail("\"tool.axis\" is no unit vector");
    keys.finish();
    return tool;
}

bool is_same(double a, double b) { return std::abs(a - b) <= kSame; }

bool is_same(const std::optional<Shaft>& a, const std::optional<Shaft>& b) {
    if (!a || !b) return a.has_value() == b.has_value();
    return is_same(a->diameter, b->diameter) && is_same(a->length, b->length);
}

std::string shaft_text(const std::optional<Shaft>& shaft) {
    return shaft ? fmt::format("{} mm thick and {} mm long", shaft->diameter, shaft->length) : "not described";
}

}  // namespace

ProbeCalibration calibration_of(const Qualification& qualification, const ReferenceSphere& sphere, const ToolShape& tool,
                                double feed_mm_per_s, const std::string& date) {
    return {date,
            tool,
            feed_mm_per_s,
            sphere.diameter,
            qualification.residuals_mm.size(),
            qualification.effective_radius_mm,
            qualification.lobing,
            qualification.rms_mm,
            qualification.repeatability_mm,
            qualification.form_error_mm,
            qualification.raw_form_error_mm};
}

std::string to_json(const ProbeCalibration& c) {
    const Vector& axis = c.tool.axis;
    const Json json = {
        {"palpate", "calibration"},
        {"schema", kCalibrationSchema},
        {"date", c.date},
        {"tool",
         {{"ball_diameter_mm", c.tool.ball_diameter},
          {"stylus", json_of(c.tool.stylus)},
          {"holder", json_of(c.tool.holder)},
          {"axis", Json::array({axis.x(), axis.y(), axis.z()})}}},
        {"feed_mm_per_s", c.feed_mm_per_s},
        {"sphere_diameter_mm", c.sphere_diameter_mm},
        {"touches", c.touches},
        {"effective_radius_mm", c.effective_radius_mm},
        {"lobing_mm", c.lobing.coefficients_mm},
        {"rms_mm", c.rms_mm},
        {"repeatability_mm", c.repeatability_mm},
        {"form_error_mm", c.form_error_mm},
        {"raw_form_error_mm", c.raw_form_error_mm},
    };
    // What is not finite becomes null, a date that is no text of Unicode an exception of its own.
    std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
    static_cast<void>(parse_calibration(text, "the calibration"));
    return text;
}

ProbeCalibration parse_calibration(const std::string& text, const std::string& name) {
    Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) {
        throw CalibrationError(
            fmt::format("{}: is no JSON text: it is damaged, or no calibration. Qualify the probe again, or put back a copy", name));
    }
    Keys keys(std::move(json), name, "");
    if (keys.take("palpate") != Json("calibration")) keys.fail("is no calibration of a probe");
    if (const Json schema = keys.take("schema"); schema != Json(kCalibrationSchema)) {
        keys.fail(fmt::format("has schema {}, this Palpate knows schema {}: qualify the probe again", schema.dump(), kCalibrationSchema));
    }
    ProbeCalibration c;
    c.date = keys.take_text("date");
    if (!is_date(c.date)) keys.fail("\"date\" is no date as 2026-01-31");
    c.tool = take_tool(keys);
    c.feed_mm_per_s = keys.take_positive("feed_mm_per_s");
    c.sphere_diameter_mm = keys.take_positive("sphere_diameter_mm");
    c.touches = keys.take_count("touches");
    c.effective_radius_mm = keys.take_positive("effective_radius_mm");
    c.lobing.coefficients_mm = keys.take_numbers<LobingMap::kCoefficients>("lobing_mm");
    c.lobing.axis = c.tool.axis;
    c.rms_mm = keys.take_size("rms_mm");
    c.repeatability_mm = keys.take_size("repeatability_mm");
    c.form_error_mm = keys.take_size("form_error_mm");
    c.raw_form_error_mm = keys.take_size("raw_form_error_mm");
    keys.finish();
    return c;
}

void require_fits(const ProbeCalibration& calibration, const ToolShape& tool, double feed_mm_per_s, const std::string& name) {
    const auto refuse = [&](const std::string& what) {
        throw CalibrationError(fmt::format("{}: {}. Qualify the probe as it is now", name, what));
    };
    const ToolShape& qualified = calibration.tool;
    if (!is_same(qualified.ball_diameter, tool.ball_diameter)) {
        refuse(fmt::format("belongs to another tool: its ball's diameter is {} mm, this one's {} mm", qualified.ball_diameter,
                           tool.ball_diameter));
    }
    if (!is_same(qualified.stylus, tool.stylus)) {
        refuse(
            fmt::format("belongs to another tool: its stylus is {}, this one's {}", shaft_text(qualified.stylus), shaft_text(tool.stylus)));
    }
    if ((qualified.axis - tool.axis).norm() > kSame) refuse("belongs to a tool whose axis points elsewhere");
    if (!is_same(calibration.feed_mm_per_s, feed_mm_per_s)) {
        refuse(fmt::format("was made at a feed of {} mm/s, and touches are made at {} mm/s", calibration.feed_mm_per_s, feed_mm_per_s));
    }
}

ProbeCalibration parse_calibration(const std::string& text, const std::string& name, const ToolShape& tool, double feed_mm_per_s) {
    ProbeCalibration calibration = parse_calibration(text, name);
    require_fits(calibration, tool, feed_mm_per_s, name);
    return calibration;
}

}  // namespace palpate
