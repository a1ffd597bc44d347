#include "devices/calibration/probe_calibration.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/devices/calibration/sphere_device.h"
#include "tests/devices/message_of.h"

namespace palpate::probe_calibration_test {
namespace {

constexpr double kFeed = 5.0;

ProbeCalibration calibration() {
    Random random(51);
    const SphereTouches touches = synthetic_touches(three_lobes, kSigma, qualification_directions(Vector::UnitZ(), 37), random);
    const ReferenceSphere sphere{kSaidCenter, kSphere};
    return calibration_of(qualify(touches, sphere, Vector::UnitZ(), 0.001), sphere, test_tool(), kFeed, "2026-01-31T12:00:00Z");
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what << " is not in\n" << text;
    return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

std::string error_of(const std::string& text) {
    return message_of<CalibrationError>([&] { static_cast<void>(parse_calibration(text, "probe.json")); });
}

TEST(ProbeCalibration, ReadsBackToTheSameBits) {
    const ProbeCalibration written = calibration();
    const std::string text = to_json(written);
    const ProbeCalibration read = parse_calibration(text, "probe.json", test_tool(), kFeed);
    EXPECT_EQ(read.lobing, written.lobing);
    EXPECT_EQ(read.effective_radius_mm, written.effective_radius_mm);
    EXPECT_EQ(read.rms_mm, written.rms_mm);
    EXPECT_EQ(read.repeatability_mm, written.repeatability_mm);
    EXPECT_EQ(read.form_error_mm, written.form_error_mm);
    EXPECT_EQ(read.raw_form_error_mm, written.raw_form_error_mm);
    EXPECT_EQ(read.touches, 37U);
    EXPECT_EQ(read.sphere_diameter_mm, kSphere);
    EXPECT_EQ(read.date, "2026-01-31T12:00:00Z");
    EXPECT_EQ(to_json(read), text);
}

TEST(ProbeCalibration, ATextThatIsDamagedIsRefused) {
    const std::string text = to_json(calibration());
    for (std::size_t length = 0; length + 2 < text.size(); length += 7) {
        expect_says(error_of(text.substr(0, length)), "probe.json: is no JSON text");
    }
    expect_says(error_of("[1, 2]"), "probe.json: is no JSON object");
    expect_says(error_of(replaced(text, "\"calibration\"", "\"journal\"")), "is no calibration of a probe");
    expect_says(error_of(replaced(text, "\"schema\": 1", "\"schema\": 2")), "has schema 2, this Palpate knows schema 1");
    expect_says(error_of(replaced(text, "\"rms_mm\"", "\"rms\"")), "\"rms_mm\" is missing");
    expect_says(error_of(replaced(text, "\"schema\"", "\"colour\": 3, \"schema\"")), "\"colour\" is unknown");
    expect_says(error_of(replaced(text, "\"ball_diameter_mm\"", "\"color\": 3, \"ball_diameter_mm\"")), "\"tool.color\" is unknown");
    expect_says(error_of(replaced(text, "\"feed_mm_per_s\": 5.0", "\"feed_mm_per_s\": -5")),
                "\"feed_mm_per_s\" is -5, it has to be positive");
    expect_says(error_of(replaced(text, "\"feed_mm_per_s\": 5.0", "\"feed_mm_per_s\": \"5\"")), "\"feed_mm_per_s\" is no number");
    expect_says(error_of(replaced(text, "\"lobing_mm\": [", "\"lobing_mm\": [1,")), "\"lobing_mm\" is no list of 12 numbers");
    expect_says(error_of(replaced(text, "\"touches\": 37", "\"touches\": 3.5")), "\"touches\" is no count");
    expect_says(error_of(replaced(text, "2026-01-31T", "31.1.2026 ")), "\"date\" is no date as 2026-01-31");
    expect_says(error_of(replaced(text, "\"diameter_mm\": 1.2", "\"diameter_mm\": 0")), "\"tool.stylus.diameter_mm\" is 0");
}

TEST(ProbeCalibration, AnotherToolOrFeedIsRefused) {
    const std::string text = to_json(calibration());
    const auto message = [&](const ToolShape& tool, double feed) {
        return message_of<CalibrationError>([&] { static_cast<void>(parse_calibration(text, "probe.json", tool, feed)); });
    };
    ToolShape tool = test_tool();
    tool.ball_diameter = 3;
    expect_says(message(tool, kFeed), "probe.json: belongs to another tool: its ball's diameter is 2 mm, this one's 3 mm");
    tool = test_tool();
    tool.stylus->length = 50;
    expect_says(message(tool, kFeed), "its stylus is 1.2 mm thick and 40 mm long, this one's 1.2 mm thick and 50 mm long");
    tool.stylus.reset();
    expect_says(message(tool, kFeed), "this one's not described");
    tool = test_tool();
    tool.axis = Vector::UnitX();
    expect_says(message(tool, kFeed), "whose axis points elsewhere");
    expect_says(message(test_tool(), 2.0), "was made at a feed of 5 mm/s, and touches are made at 2 mm/s");
}

TEST(ProbeCalibration, NothingIsWrittenThatCannotBeRead) {
    ProbeCalibration broken = calibration();
    broken.rms_mm = std::numeric_limits<double>::quiet_NaN();
    expect_says(message_of<CalibrationError>([&] { static_cast<void>(to_json(broken)); }), "\"rms_mm\" is no number");
    broken = calibration();
    broken.date = "today";
    expect_says(message_of<CalibrationError>([&] { static_cast<void>(to_json(broken)); }), "\"date\" is no date");
}

TEST(ProbeCalibration, AToolWithoutStylusIsOne) {
    ProbeCalibration bare = calibration();
    bare.tool.stylus.reset();
    bare.tool.holder.reset();
    const ProbeCalibration read = parse_calibration(to_json(bare), "probe.json");
    EXPECT_FALSE(read.tool.stylus.has_value());
    EXPECT_FALSE(read.tool.holder.has_value());
}

}  // namespace
}  // namespace palpate::probe_calibration_test
