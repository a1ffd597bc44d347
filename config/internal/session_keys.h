// Every key of a configuration.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <variant>

#include "config/internal/machine_keys.h"
#include "config/internal/object_keys.h"
#include "config/internal/probing_keys.h"
#include "config/internal/simulation_keys.h"
#include "config/internal/tool_keys.h"
#include "config/session_config.h"

namespace palpate::yaml {

inline constexpr std::array<std::string_view, 2> kPartWords{"closed", "open"};

template <class Archive>
void describe(Archive& keys, ResultSpec& results) {
    keys.value({"part", "mesh.ply of a part that a tool probed: closed by shadows and by what lies on fixtures, or cut off there"},
               results.part, Word{kPartWords});
    keys.value({"surface", "whether surface.ply is made, a curved surface through the touches"}, results.surface, kFlag);
}

[[nodiscard]] inline bool overlap(const Box& a, const Box& b) {
    return (a.min.array() < b.max.array()).all() && (a.max.array() > b.min.array()).all();
}

template <class Archive>
void describe(Archive& keys, SessionConfig& config) {
    mapping(keys, {"object", "the hidden object of a simulation or of a virtual machine", Need::optional, "", "none", Layout::block},
            config.object);
    mapping(
        keys,
        {"machine", "the machine that `palpate probe` drives, and that `palpate vm` imitates", Need::optional, "", "none", Layout::block},
        config.machine);
    ToolShape tool = config.tool.value_or(ToolShape{});
    if (keys.mapping({"tool", "what the machine touches with; none: a point", Need::optional, "", "none"}, config.tool.has_value(),
                     [&](Archive& inner) { describe(inner, tool, config.calibration); })) {
        config.tool = tool;
    }
    keys.mapping({"simulation", "what a simulation and a virtual machine do that an exact probe would not; real machines pass over it",
                  Need::optional, "", "none", Layout::block},
                 config.errors.has_value(), [&](Archive& inner) {
                     mapping(inner, {"errors", "of the probe and its axes", Need::required, "", "", Layout::block}, config.errors);
                 });
    const bool is_auto = std::holds_alternative<AutoWorkspace>(config.workspace);
    keys.word_or_mapping(
        {"workspace",
         "region that contains the object; everything outside it is free. `auto` is for simulations only: around the hidden object",
         Need::optional, "", "auto", are_given(config.fixtures) ? Layout::block : Layout::flow},
        kWorkspaceWords, is_auto ? std::optional<std::size_t>(0) : std::nullopt,
        [&](Archive& inner) { describe(inner, config.workspace, config.fixtures); });
    keys.mapping({.name = "probing", .meaning = "the task", .need = Need::required, .layout = Layout::block}, true, [&](Archive& inner) {
        describe(inner, config.probing);
        if (inner.wants(!config.earlier.file.empty())) {
            inner.value(
                {"earlier",
                 "touches.csv of an earlier session on the same object, which has not moved since: nothing of that is touched again "
                 "but three places (`palpate continue` sets this); a file, relative to the config file",
                 Need::optional, "", "none"},
                config.earlier.file, File{});
            inner.value({"earlier_limit",
                         "how far off these may be met; null: a hundredth of epsilon, or half the tolerance if that is less, or 5 touch "
                         "errors if those are more",
                         Need::optional, kMillimetres},
                        config.probing.earlier_limit, kLengthOrNull);
        }
        mapping(inner,
                {"area",
                 "places of the tool's centre: only what lies within is probed, what is outside is never entered, and the result is open "
                 "there; with workspace.box only",
                 Need::optional, "", "none"},
                config.area);
        const auto* const box = std::get_if<Box>(&config.workspace);
        inner.require(!config.area || box != nullptr, "area", "has no box around it; allowed: with workspace.box only");
        inner.require(!config.area || box == nullptr || overlap(bounds_of(*config.area), *box), "area",
                      "lies outside workspace.box; allowed: one that has some of it");
        const Options& options = config.probing;
        inner.require(!options.tolerance || *options.tolerance < options.epsilon, "tolerance",
                      "is no less than epsilon; allowed: below it (mm)");
        inner.require(options.tolerance || !options.tolerance_box, "tolerance_box",
                      "has no tolerance that it belongs to; allowed: with probing.tolerance only");
        inner.require(!config.earlier.file.empty() || !options.earlier_limit, "earlier_limit",
                      "has no earlier touches that it belongs to; allowed: with probing.earlier only");
        inner.require(options.tolerance || !options.spacing_min, "spacing_min",
                      "has no tolerance that it belongs to; allowed: with probing.tolerance only");
    });
    if (keys.wants(config.results != ResultSpec{})) {
        mapping(keys, {"results", "what is made of what was touched", Need::optional, "", "all"}, config.results);
    }
    keys.value({"random_seed", "the same seed and configuration give the same run"}, config.probing.random_seed, Whole{});
}

}  // namespace palpate::yaml
