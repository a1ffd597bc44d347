#include "config/writer.h"

#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "config/internal/numbers.h"
#include "config/internal/utf8.h"
#include "config/strategy_names.h"

namespace palpate {

namespace {

using yaml::number_text;
using Lines = std::vector<std::string>;

constexpr std::string_view kHex = "0123456789abcdef";

template <class... Handlers>
struct Overloaded : Handlers... {
    using Handlers::operator()...;
};
template <class... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

template <class Spell>
std::string triple(const Vector& v, const Spell& spell) {
    return "[" + spell(v.x()) + ", " + spell(v.y()) + ", " + spell(v.z()) + "]";
}

std::string or_null(const std::optional<double>& value) { return value ? number_text(*value) : "null"; }

std::string flag_text(bool flag) { return flag ? "true" : "false"; }

std::string vector_text(const Vector& v) { return triple(v, number_text); }

std::string quoted(const std::string& text) {
    if (!yaml::is_utf8(text)) {
        throw std::invalid_argument("the file name \"" + text + "\" is not UTF-8, so YAML cannot hold it");
    }
    std::string result = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            result += std::string("\\") + c;
        } else if (byte < 0x20U || byte == 0x7FU) {
            result += std::string("\\x") + kHex[byte >> 4U] + kHex[byte & 15U];
        } else {
            result += c;
        }
    }
    return result + "\"";
}

void append_indented(Lines& lines, const Lines& inner, const std::string& first, const std::string& others) {
    for (const std::string& line : inner) {
        lines.push_back((&line == &inner.front() ? first : others) + line);
    }
}

// Where a shape or a mesh is put.
template <class Spec>
Lines place_lines(const Spec& spec) {
    return {"at: " + vector_text(spec.at), "rotate: " + triple(spec.rotate, yaml::degrees_text)};
}

Lines shape_lines(const ShapeSpec& shape) {
    Lines lines;
    const auto add = [&lines](const std::string& line) { lines.push_back(line); };
    std::visit(
        Overloaded{
            [&](const SphereSpec& s) { add("sphere: {radius: " + number_text(s.radius) + "}"); },
            [&](const EllipsoidSpec& s) { add("ellipsoid: {semi_axes: " + vector_text(s.semi_axes) + "}"); },
            [&](const TorusSpec& s) { add("torus: {major: " + number_text(s.major) + ", minor: " + number_text(s.minor) + "}"); },
            [&](const CapsuleSpec& s) { add("capsule: {radius: " + number_text(s.radius) + ", length: " + number_text(s.length) + "}"); },
            [&](const RoundedBoxSpec& s) {
                add("rounded_box: {size: " + vector_text(s.size) + ", fillet: " + number_text(s.fillet) + "}");
            },
            [&](const Genus2Spec& s) { add("genus2: {scale: " + number_text(s.scale) + "}"); },
            [&](const std::vector<ShapeSpec>& parts) {
                add("union:");
                add("  parts:");
                for (const ShapeSpec& part : parts) {
                    append_indented(lines, shape_lines(part), "    - ", "      ");
                }
            },
        },
        shape.kind);
    append_indented(lines, place_lines(shape), "", "");
    return lines;
}

void add_object(Lines& lines, const ObjectSpec& object) {
    lines.emplace_back("object:");
    std::visit(Overloaded{
                   [&](const MeshSpec& mesh) {
                       lines.push_back("  mesh: " + quoted(std::filesystem::absolute(mesh.file).string()));
                       lines.push_back("  scale: " + number_text(mesh.scale));
                       append_indented(lines, place_lines(mesh), "  ", "  ");
                       lines.push_back("  repair: " + flag_text(mesh.repair));
                   },
                   [&](const ShapeSpec& shape) {
                       lines.emplace_back("  shape:");
                       append_indented(lines, shape_lines(shape), "    ", "    ");
                   },
               },
               object);
}

std::string connection_text(const MachineConfig& machine) {
    return std::visit(Overloaded{
                          [](const GrblSpec& grbl) {
                              return "grbl: {port: " + quoted(grbl.port.path) + ", baud: " + std::to_string(grbl.port.baud) +
                                     ", reset_on_open: " + flag_text(grbl.port.reset) + "}";
                          },
                          [](const ModbusSpec& modbus) {
                              const std::string line = std::visit(
                                  Overloaded{
                                      [](const ModbusTcp& tcp) {
                                          return "tcp: {host: " + quoted(tcp.host) + ", port: " + std::to_string(tcp.port) + "}";
                                      },
                                      [](const ModbusRtu& rtu) {
                                          const std::string parity = rtu.parity == 'N' ? "none" : rtu.parity == 'E' ? "even" : "odd";
                                          return "rtu: {path: " + quoted(rtu.path) + ", baud: " + std::to_string(rtu.baud) +
                                                 ", parity: " + parity + ", stop_bits: " + std::to_string(rtu.stop_bits) + "}";
                                      },
                                  },
                                  modbus.link.where);
                              const std::string profile =
                                  modbus.profile.empty() ? "" : ", profile: " + quoted(std::filesystem::absolute(modbus.profile).string());
                              return "modbus: {" + line + ", unit: " + std::to_string(modbus.link.unit) +
                                     ", slowest_answer: " + number_text(modbus.link.slowest_answer.count()) +
                                     ", reconnect_time: " + number_text(modbus.link.reconnect_time.count()) +
                                     ", busy_time: " + number_text(modbus.link.busy_time.count()) + profile + "}";
                          },
                      },
                      machine.connection);
}

void add_machine(Lines& lines, const MachineConfig& machine) {
    const Kinematics& k = machine.kinematics;
    const MultiTouchOptions& touch = machine.touch;
    const std::string homing = machine.homing == Homing::require ? "require" : machine.homing == Homing::run ? "run" : "skip";
    lines.emplace_back("machine:");
    lines.push_back("  " + connection_text(machine));
    lines.push_back("  homing: " + homing);
    lines.push_back("  origin: " + vector_text(machine.origin));
    lines.push_back("  limits: {min: " + vector_text(machine.limits.min) + ", max: " + vector_text(machine.limits.max) + "}");
    lines.push_back("  feeds: {travel: " + number_text(k.feeds.travel_mm_per_s) + ", probe: " + number_text(k.feeds.probe_mm_per_s) +
                    ", touch: " + number_text(k.feeds.touch_mm_per_s) + "}");
    lines.push_back("  acceleration: " + number_text(k.acceleration_mm_per_s2));
    lines.push_back("  latency: " + number_text(k.latency.count()));
    lines.push_back("  overtravel: " + number_text(k.overtravel_mm));
    lines.push_back("  retract: " + number_text(k.retract_mm));
    lines.push_back("  resolution: " + number_text(k.resolution_mm));
    lines.push_back("  noise: " + number_text(machine.noise_mm));
    lines.push_back("  touch: {samples: " + std::to_string(touch.samples) + ", tolerance: " + number_text(touch.tolerance_mm) +
                    ", retries: " + std::to_string(touch.retries) + ", discard_first: " + flag_text(touch.discard_first) +
                    ", confirm: " + flag_text(touch.confirm) + ", confirm_travel: " + flag_text(touch.confirm_travel) + "}");
    lines.push_back("  datum_tolerance: " + or_null(machine.datum_tolerance_mm));
    const bool by_hand = machine.probe_proof == ProbeProof::hand;
    lines.push_back(std::string("  probe_proof: ") + (by_hand                                          ? "hand"
                                                      : machine.probe_proof == ProbeProof::first_touch ? "first_touch"
                                                                                                       : "auto"));
}

std::string workspace_text(const WorkspaceSpec& workspace) {
    return std::visit(
        Overloaded{
            [](const AutoWorkspace&) { return std::string("auto"); },
            [](const Ball& b) { return "{ball: {center: " + vector_text(b.center) + ", radius: " + number_text(b.radius) + "}}"; },
            [](const Box& b) { return "{box: {min: " + vector_text(b.min) + ", max: " + vector_text(b.max) + "}}"; },
        },
        workspace);
}

std::string strategy_text(const Strategy& strategy) {
    return "{refine: " + std::string(to_word(strategy.refine)) + ", explore: " + std::string(to_word(strategy.explore)) +
           ", infer: " + std::string(to_word(strategy.infer)) + ", travel: " + std::string(to_word(strategy.travel)) + "}";
}

void add_probing(Lines& lines, const Options& options) {
    lines.emplace_back("probing:");
    lines.push_back("  epsilon: " + number_text(options.epsilon));
    lines.push_back("  reach: " + or_null(options.reach));
    lines.push_back("  strategy: " + strategy_text(options.strategy));
    lines.push_back("  standoff: " + or_null(options.standoff));
    lines.push_back("  audit: " + number_text(options.audit));
    lines.emplace_back(options.seed_rays.empty() ? "  seed_rays: []" : "  seed_rays:");
    for (const Segment& ray : options.seed_rays) {
        lines.push_back("    - {from: " + vector_text(ray.source) + ", to: " + vector_text(ray.target) + "}");
    }
    lines.push_back("  refinement_floor: " + number_text(options.refinement_floor));
    lines.emplace_back("  sizing:");
    lines.emplace_back(options.sizing.regions.empty() ? "    regions: []" : "    regions:");
    for (const RegionOfInterest& region : options.sizing.regions) {
        lines.push_back("      - {min: " + vector_text(region.box.min) + ", max: " + vector_text(region.box.max) +
                        ", size: " + number_text(region.size) + ", slope: " + number_text(region.slope) + "}");
    }
    lines.push_back("    radii_of_curvature: " + number_text(options.sizing.radii_of_curvature));
    lines.push_back("    smallest: " + or_null(options.sizing.smallest));
    lines.push_back("  min_angle: " + yaml::degrees_text(options.min_angle));
    const Budget& budget = options.budget;
    const std::string probes = budget.probes ? std::to_string(*budget.probes) : "null";
    lines.push_back("  budget: {probes: " + probes + ", displacement: " + or_null(budget.displacement) +
                    ", machine_time: " + or_null(budget.machine_time) + "}");
}

}  // namespace

std::string write_config(const SessionConfig& config) {
    Lines lines;
    if (config.object) {
        add_object(lines, *config.object);
    }
    if (config.machine) {
        add_machine(lines, *config.machine);
    }
    lines.push_back("workspace: " + workspace_text(config.workspace));
    add_probing(lines, config.probing);
    lines.push_back("random_seed: " + std::to_string(config.probing.random_seed));
    std::string text;
    for (const std::string& line : lines) {
        text += line + "\n";
    }
    return text;
}

}  // namespace palpate
