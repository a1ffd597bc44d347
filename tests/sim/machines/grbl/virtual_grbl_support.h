// A virtual GRBL machine with a ball of radius 10 mm around the origin, its tool at (20, 0, 0), and ways to talk to it.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "sim/machines/grbl/virtual_grbl.h"
#include "sim/objects/hidden_object.h"

namespace palpate {

using Lines = std::vector<std::string>;

// Checks on the way that every line ends in CR LF.
inline Lines lines_of(const std::string& text) {
    Lines lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        EXPECT_TRUE(!line.empty() && line.back() == '\r') << line;
        line.pop_back();
        if (!line.empty()) lines.push_back(line);
    }
    return lines;
}

class VirtualGrblTest : public testing::TestWithParam<GrblDialect> {
protected:
    static constexpr char kReset = 0x18;

    VirtualGrblTest() {
        tool_options.start = Point(20, 0, 0);
        tool_options.limits = {Point(-50, -50, -50), Point(50, 50, 50)};
        options.homed_position = Point(50, 50, 50);
    }

    // Powers it on; the banner is taken.
    Lines start() {
        tool = std::make_unique<VirtualTool>(ball, tool_options);
        grbl = std::make_unique<VirtualGrbl>(*tool, options);
        return lines_of(grbl->take_output());
    }
    // What comes at once.
    Lines send(const std::string& bytes) {
        grbl->receive(bytes);
        return lines_of(grbl->take_output());
    }
    Lines after(double seconds) {
        grbl->advance(Seconds(seconds));
        return lines_of(grbl->take_output());
    }
    // What comes until the machine has nothing more to do.
    Lines rest() {
        int events = 0;
        while (const auto next = grbl->time_to_event()) {
            grbl->advance(*next);
            if (++events > 10000) {
                ADD_FAILURE() << "it never comes to rest";
                break;
            }
        }
        return lines_of(grbl->take_output());
    }
    Lines command(const std::string& line) {
        Lines lines = send(line + "\n");
        const Lines more = rest();
        lines.insert(lines.end(), more.begin(), more.end());
        return lines;
    }
    std::string status() {
        const Lines lines = send("?");
        return lines.size() == 1 ? lines[0] : "no answer";
    }

    HiddenObject ball{ShapeSpec{SphereSpec{10.0}}};
    VirtualToolOptions tool_options;
    VirtualGrblOptions options;
    std::unique_ptr<VirtualTool> tool;
    std::unique_ptr<VirtualGrbl> grbl;
};

// The same for both dialects.
class EveryGrblTest : public VirtualGrblTest {
protected:
    EveryGrblTest() { options.dialect = GetParam(); }
    [[nodiscard]] bool is_hal() const { return GetParam() == GrblDialect::grblhal; }
    [[nodiscard]] std::string banner() const { return is_hal() ? "GrblHAL 1.1f ['$' or '$HELP' for help]" : "Grbl 1.1h ['$' for help]"; }
};

constexpr const char* kLockMessage = "[MSG:'$H'|'$X' to unlock]";

inline std::string dialect_name(const testing::TestParamInfo<GrblDialect>& info) {
    return info.param == GrblDialect::grbl ? "grbl" : info.param == GrblDialect::grblhal ? "grblHAL" : "FluidNC";
}

}  // namespace palpate
