// `tool:` of a configuration, and the fixtures of its `workspace:`.
#pragma once

#include <limits>
#include <variant>

#include "config/internal/kinds.h"
#include "config/session_config.h"
#include "planner/fixtures.h"
#include "planner/tool_shape.h"

namespace palpate::yaml {

// One that is a unit vector up to rounding stays as it is, so that what was written reads back bit for bit.
[[nodiscard]] inline Vector direction_of(const Vector& v) {
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    const double largest = v.cwiseAbs().maxCoeff();
    if (largest == 0.0 || std::abs(v.squaredNorm() - 1.0) <= kRounding) return v;
    return (v / largest).normalized();  // by two steps: squares of tiny numbers are 0
}

// Of any length; of length 1 afterwards.
template <class Archive>
void describe_direction(Archive& keys, const Key& key, Vector& direction) {
    keys.value(key, direction, Triple{Number{kCoordinate}});
    keys.require(!direction.isZero(0), key.name, "has no direction; allowed: [x, y, z], not all 0");
    direction = direction_of(direction);
}

template <class Archive>
void describe_shaft(Archive& keys, std::string_view meaning_of_length, ToolShape::Shaft& shaft) {
    keys.value({"diameter", "its diameter", Need::required, kMillimetres}, shaft.diameter, Number{kLength});
    keys.value({"length", meaning_of_length, Need::required, kMillimetres}, shaft.length, Number{kLength});
}

template <class Archive>
void describe(Archive& keys, CalibrationSpec& calibration) {
    keys.value(
        {"calibration", "what `palpate calibrate` found out about it: a file, relative to the config file", Need::optional, "", "none"},
        calibration.file, File{});
    keys.value({"calibration_max_age", "an older calibration is warned of", Need::optional, "days"}, calibration.max_age_days,
               Number{kPositive});
}

template <class Archive>
void describe(Archive& keys, ToolShape& tool, CalibrationSpec& calibration) {
    keys.mapping({"ball", "its tip; positions are those of the ball's centre", Need::required}, true, [&](Archive& inner) {
        inner.value({"diameter", "diameter of the ball", Need::required, kMillimetres}, tool.ball_diameter, Number{kLength});
    });
    ToolShape::Shaft stylus = tool.stylus.value_or(ToolShape::Shaft{});
    const auto describe_stylus = [&](Archive& inner) {
        describe_shaft(inner, "from the ball's centre to the holder", stylus);
        describe_direction(inner, {"axis", "where it leads to from the ball; of any length"}, tool.axis);
    };
    if (keys.mapping({"stylus", "the shaft that carries the ball, no thicker than that; none: the ball floats", Need::optional, "", "none"},
                     tool.stylus.has_value(), describe_stylus)) {
        tool.stylus = stylus;
    }
    ToolShape::Shaft holder = tool.holder.value_or(ToolShape::Shaft{});
    const auto describe_holder = [&](Archive& inner) {
        describe_shaft(inner, "from the end of the stylus on; its ends are round, so what is shorter than it is wide is a ball", holder);
    };
    if (keys.mapping({"holder", "what holds the stylus, on the same axis", Need::optional, "", "none"}, tool.holder.has_value(),
                     describe_holder)) {
        tool.holder = holder;
    }
    if (keys.wants(!calibration.file.empty())) describe(keys, calibration);
    keys.require(!tool.stylus || tool.stylus->diameter <= tool.ball_diameter, "stylus",
                 "is thicker than the ball; allowed: a diameter of at most that of the ball (mm)");
    keys.require(tool.stylus || !tool.holder, "holder", "has no stylus that it could hold; allowed: with tool.stylus only");
}

template <class Archive>
void describe(Archive& keys, Table& table) {
    keys.value({"z", "its height", Need::required, kMillimetres}, table.z, Number{kCoordinate});
}

template <class Archive>
void describe(Archive& keys, HalfSpace& half) {
    keys.value({"point", "a point of its boundary", Need::required, kMillimetres}, half.point, Triple{Number{kCoordinate}});
    describe_direction(keys, {"normal", "leads out of it; of any length", Need::required}, half.normal);
}

template <class Archive>
void describe(Archive& keys, Fixture& fixture) {
    alternative<Table>(keys, {"table", "all that lies below a height"}, fixture);
    alternative<Box>(keys, {"box", "a box along the axes"}, fixture);
    alternative<HalfSpace>(keys, {"half_space", "all that lies behind a plane"}, fixture);
    keys.require_one_alternative();
}

// Does it leave nothing of the box?
[[nodiscard]] inline bool covers(const Fixture& fixture, const Box& box) {
    if (const auto* solid = std::get_if<Box>(&fixture)) return solid->contains(box);
    const auto* table = std::get_if<Table>(&fixture);
    const HalfSpace half = table != nullptr ? HalfSpace{Point(0, 0, table->z), Vector::UnitZ()} : std::get<HalfSpace>(fixture);
    const Vector outermost = (half.normal.array() > 0).select(box.max, box.min);
    return half.normal.dot(outermost - half.point) <= 0;
}

// What there is to know of fixtures, beside the workspace's shape.
template <class Archive>
void describe(Archive& keys, Fixtures& fixtures) {
    list(keys, {"fixtures", "what stands around the part and is known: the table that it lies on, clamps; with `box` only"}, {},
         fixtures.solids);
    keys.value(
        {"clearance", "the tool keeps so far off the fixtures; null: twice what touches may be wrong by", Need::optional, kMillimetres},
        fixtures.clearance, OrNull{Number{kLength}});
    keys.value({"assume_clear", "nothing but the part stands on the fixtures, so that what is far from the part is not looked at"},
               fixtures.assume_clear, kFlag);
}

[[nodiscard]] inline bool are_given(const Fixtures& fixtures) {
    return !fixtures.solids.empty() || fixtures.clearance || !fixtures.assume_clear;
}

}  // namespace palpate::yaml
