#include "tests/config/support.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace palpate::test {

namespace {

using Random = std::mt19937_64;

bool flip(Random& random) { return (random() & 1U) != 0; }

// All magnitudes, many digits or few.
double positive(Random& random, double greatest_logarithm = 200.0) {
    if (flip(random)) {
        return static_cast<double>(1 + random() % 200) / 8.0;
    }
    return std::exp(std::uniform_real_distribution<double>(-200.0, greatest_logarithm)(random));
}

// No length and no coordinate is beyond a kilometre; these leave a millimetre to it.
double length(Random& random) { return positive(random, std::log(999'998.0)); }
double coordinate(Random& random) { return flip(random) ? length(random) : -length(random); }
Vector lengths(Random& random) { return {length(random), length(random), length(random)}; }
Vector any_point(Random& random) { return {coordinate(random), coordinate(random), coordinate(random)}; }

double any_angle(Random& random) {
    if (flip(random)) {
        return static_cast<double>(random() % 25) * std::numbers::pi / 12.0;
    }
    return std::uniform_real_distribution<double>(-6.28, 6.28)(random);
}

ShapeSpec random_shape(Random& random, int depth) {
    ShapeSpec shape;
    switch (random() % (depth > 0 ? 7U : 6U)) {
        case 0:
            shape.kind = SphereSpec{length(random)};
            break;
        case 1:
            shape.kind = EllipsoidSpec{lengths(random)};
            break;
        case 2: {
            const double major = length(random);
            shape.kind = TorusSpec{major, major * 0.37};
            break;
        }
        case 3:
            shape.kind = CapsuleSpec{length(random), flip(random) ? length(random) : 0.0};
            break;
        case 4: {
            const Vector size = lengths(random);
            shape.kind = RoundedBoxSpec{size, size.minCoeff() * static_cast<double>(random() % 3) / 4.0};
            break;
        }
        case 5:
            shape.kind = Genus2Spec{length(random)};
            break;
        default: {
            std::vector<ShapeSpec> parts;
            for (std::uint64_t i = 1 + random() % 3; i > 0; --i) {
                parts.push_back(random_shape(random, depth - 1));
            }
            shape.kind = std::move(parts);
        }
    }
    shape.at = any_point(random);
    shape.rotate = {any_angle(random), any_angle(random), any_angle(random)};
    return shape;
}

WorkspaceSpec random_workspace(Random& random) {
    switch (random() % 3) {
        case 0:
            return AutoWorkspace{};
        case 1:
            return Ball{any_point(random), length(random)};
        default: {
            const Vector a = any_point(random);
            Vector b = any_point(random);
            b = (a.array() == b.array()).select(b.array() + 1.0, b.array());
            return Box{a.cwiseMin(b), a.cwiseMax(b)};
        }
    }
}

// What is read is scaled to length 1, unless it is that long already.
Vector any_direction(Random& random) { return any_point(random).stableNormalized().stableNormalized(); }

ToolShape::Shaft any_shaft(Random& random, double diameter) { return {diameter, length(random)}; }

ToolShape random_tool(Random& random) {
    ToolShape tool;
    tool.ball_diameter = length(random);
    if (flip(random)) {
        tool.stylus = any_shaft(random, tool.ball_diameter);
        tool.axis = any_direction(random);
        if (flip(random)) tool.holder = any_shaft(random, length(random));
    }
    return tool;
}

// Next to the workspace, so that none covers it.
Fixtures random_fixtures(Random& random, const Box& workspace) {
    Fixtures fixtures;
    for (std::uint64_t i = random() % 4; i > 0; --i) {
        const Vector normal = any_direction(random);
        const Vector outermost = (normal.array() > 0).select(workspace.min, workspace.max);
        switch (random() % 3) {
            case 0:
                fixtures.solids.emplace_back(Table{workspace.min.z()});
                break;
            case 1:
                fixtures.solids.emplace_back(Box{workspace.min - Vector::Ones(), workspace.min});
                break;
            default:
                fixtures.solids.emplace_back(HalfSpace{outermost, normal});
        }
    }
    if (flip(random)) fixtures.clearance = length(random);
    fixtures.assume_clear = flip(random);
    return fixtures;
}

// Around the workspace's middle.
Area random_area(Random& random, const Box& workspace) {
    const Point middle = workspace.center();
    const auto share = [&] { return std::uniform_real_distribution<double>(0.1, 0.9)(random); };
    const Vector half = (workspace.max - workspace.min) / 2;
    if (flip(random)) return Box{middle - share() * half, middle + share() * half};
    Prism prism;
    const std::uint64_t corners = 3 + random() % 5;
    for (std::uint64_t k = 0; k < corners; ++k) {
        const double angle = 6.28 * static_cast<double>(k) / static_cast<double>(corners);
        // As far along x as along y: seen from the middle, the corners are in order.
        const double far = share();
        prism.corners.emplace_back(middle.x() + far * half.x() * std::cos(angle), middle.y() + far * half.y() * std::sin(angle));
    }
    if (flip(random)) prism.z = {middle.z() - share() * half.z(), middle.z() + share() * half.z()};
    return prism;
}

int any_speed(Random& random) {
    constexpr std::array<int, 5> kSpeeds = {1200, 19200, 115200, 921600, 1500000};
    return kSpeeds[random() % kSpeeds.size()];
}

MachineConfig random_machine(Random& random) {
    MachineConfig machine;
    const auto kind = random() % 3;
    if (kind == 2) {
        ExternalSpec external;
        if (flip(random)) {
            external.command = {"python3", "an \"odd\" name.py", "--port=" + std::to_string(random() % 100)};
        } else {
            external.address = "robot:" + std::to_string(1 + random() % 65535);
        }
        external.silence = Seconds(std::uniform_real_distribution<double>(0.3, 5)(random));
        external.slowest_answer = Seconds(positive(random));
        external.start_time = Seconds(positive(random));
        machine.connection = external;
    } else if (kind == 1) {
        GrblSpec grbl{{"/dev/tty \"odd\" #" + std::to_string(random() % 100), any_speed(random), flip(random)}};
        if (flip(random)) grbl.port.path = "tcp://[fe80::1]:" + std::to_string(1 + random() % 65535);
        if (flip(random)) grbl.delay = Seconds(std::uniform_real_distribution<double>(0, 5)(random));
        grbl.boot_time = Seconds(std::uniform_real_distribution<double>(1, 120)(random));
        machine.connection = grbl;
    } else {
        ModbusSpec modbus;
        if (flip(random)) {
            modbus.link.where = ModbusTcp{"host-" + std::to_string(random() % 100), static_cast<int>(1 + random() % 65535)};
        } else {
            modbus.link.where = ModbusRtu{"/dev/ttyS1", any_speed(random), "NEO"[random() % 3], static_cast<int>(1 + random() % 2)};
        }
        modbus.link.unit = static_cast<int>(1 + random() % 247);
        modbus.link.answer_timeout = modbus.link.slowest_answer = Seconds(positive(random));
        modbus.link.reconnect_time = Seconds(positive(random));
        modbus.link.busy_time = Seconds(positive(random));
        if (flip(random)) modbus.profile = "/no such folder/profile.yaml";
        machine.connection = modbus;
    }
    if (std::holds_alternative<GrblSpec>(machine.connection)) machine.homing = static_cast<Homing>(random() % 3);
    if (std::holds_alternative<ExternalSpec>(machine.connection)) machine.homing = static_cast<Homing>(random() % 2);
    machine.origin = any_point(random);
    machine.limits.min = any_point(random);
    machine.limits.max = machine.limits.min.cwiseAbs().array() + 1;
    const auto share = [&] { return std::uniform_real_distribution<double>(0.01, 10)(random); };
    MotionModel& k = machine.motion;
    k.feeds = {share() + 0.02, share() + 0.02, share() + 0.02};
    k.acceleration_mm_per_s2 = share();
    k.latency = Seconds(share());
    k.overtravel_mm = 1e4;  // more than any of these feeds needs to stop
    k.retract_mm = 50 + share();
    k.resolution_mm = share();
    machine.noise_mm = share();
    machine.touch.samples = static_cast<int>(1 + random() % 100);
    machine.touch.tolerance_mm = share();
    machine.touch.retries = static_cast<int>(random() % 100);
    machine.touch.discard_first = flip(random);
    machine.touch.confirm = flip(random);
    machine.touch.confirm_travel = flip(random);
    if (flip(random)) machine.datum_tolerance_mm = share();
    machine.probe_proof = static_cast<ProbeProof>(random() % 3);
    return machine;
}

ProbeErrors random_errors(Random& random) {
    const auto share = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    ProbeErrors errors;
    errors.sigma_mm = length(random);
    errors.latency = Seconds(share());
    errors.lobes_mm = length(random);
    for (double& a : errors.harmonics_mm) a = coordinate(random);
    errors.trigger_force_n = positive(random);
    errors.compliance_across_mm_per_n = length(random);
    errors.compliance_along_mm_per_n = length(random);
    errors.backlash_mm = lengths(random);
    errors.drift_mm_per_hour = any_point(random);
    errors.drift_mm_per_1000_touches = any_point(random);
    errors.swing_mm = any_point(random);
    errors.swing_period = Seconds(positive(random));
    errors.false_triggers = share();
    errors.misses = share();
    errors.bounces = share();
    return errors;
}

// One flat list of everything in a config, doubles by their bits.
class Flattener {
public:
    void add(std::uint64_t value) { words_.push_back(std::to_string(value)); }
    void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
    void add(const Vector& v) {
        for (const double value : v) {
            add(value);
        }
    }
    void add(const SphereSpec& s) { add(s.radius); }
    void add(const EllipsoidSpec& s) { add(s.semi_axes); }
    void add(const TorusSpec& s) { add_all(s.major, s.minor); }
    void add(const CapsuleSpec& s) { add_all(s.radius, s.length); }
    void add(const RoundedBoxSpec& s) { add_all(s.size, s.fillet); }
    void add(const Genus2Spec& s) { add(s.scale); }
    void add(const std::vector<ShapeSpec>& parts) {
        add(std::uint64_t{parts.size()});
        std::for_each(parts.begin(), parts.end(), [this](const ShapeSpec& part) { add(part); });
    }
    void add(const ShapeSpec& s) {
        add(s.kind);
        add_all(s.at, s.rotate);
    }
    void add(const MeshSpec& s) {
        words_.push_back(s.file.string());
        add_all(s.scale, s.at, s.rotate, std::uint64_t{s.repair});
    }
    void add(const AutoWorkspace&) {}
    void add(const Table& t) { add(t.z); }
    void add(const HalfSpace& h) { add_all(h.point, h.normal); }
    void add(const std::optional<double>& value) { add_all(std::uint64_t{value.has_value()}, value.value_or(0.0)); }
    void add(const std::optional<ToolShape::Shaft>& shaft) {
        add(std::uint64_t{shaft.has_value()});
        if (shaft) add_all(shaft->diameter, shaft->length);
    }
    void add(const ToolShape& t) { add_all(t.ball_diameter, t.stylus, t.holder, t.axis); }
    void add(const Fixtures& f) {
        add(std::uint64_t{f.solids.size()});
        for (const Fixture& solid : f.solids) add(solid);
        add_all(f.clearance, std::uint64_t{f.assume_clear});
    }
    void add(const Ball& b) { add_all(b.center, b.radius); }
    void add(const Box& b) { add_all(b.min, b.max); }
    void add(const Prism& p) {
        add(std::uint64_t{p.corners.size()});
        for (const Eigen::Vector2d& corner : p.corners) add_all(corner.x(), corner.y());
        add_all(p.z[0], p.z[1]);
    }
    template <class... Kinds>
    void add(const std::variant<Kinds...>& value) {
        add(std::uint64_t{value.index()});
        std::visit([this](const auto& kind) { add(kind); }, value);
    }
    void add(const std::string& text) { words_.push_back(text); }
    void add(const GrblSpec& g) {
        add_all(g.port.path, std::uint64_t(g.port.baud), std::uint64_t{g.port.reset}, g.boot_time.count(),
                g.delay.has_value() ? g.delay->count() : -1.0);
    }
    void add(const ExternalSpec& e) {
        for (const std::string& word : e.command) add(word);
        add_all(e.address, e.silence.count(), e.slowest_answer.count(), e.start_time.count());
    }
    void add(const ModbusTcp& t) { add_all(t.host, std::uint64_t(t.port)); }
    void add(const ModbusRtu& r) { add_all(r.path, std::uint64_t(r.baud), std::string(1, r.parity), std::uint64_t(r.stop_bits)); }
    void add(const ModbusSpec& m) {
        add_all(m.link.where, std::uint64_t(m.link.unit), m.link.slowest_answer.count(), m.link.reconnect_time.count(),
                m.link.busy_time.count(), m.profile.string());
    }
    void add(const MachineConfig& m) {
        const MotionModel& k = m.motion;
        add_all(m.connection, std::uint64_t(m.homing), m.origin, m.limits, k.feeds.travel_mm_per_s, k.feeds.probe_mm_per_s,
                k.feeds.touch_mm_per_s, k.acceleration_mm_per_s2, k.latency.count(), k.overtravel_mm, k.retract_mm, k.resolution_mm,
                m.noise_mm, std::uint64_t(m.touch.samples), m.touch.tolerance_mm, std::uint64_t(m.touch.retries),
                std::uint64_t{m.touch.discard_first}, std::uint64_t{m.touch.confirm}, std::uint64_t{m.touch.confirm_travel},
                m.datum_tolerance_mm.value_or(0), std::uint64_t(m.probe_proof));
    }
    void add(const ProbeErrors& e) {
        add_all(e.sigma_mm, e.latency.count(), e.lobes_mm, e.trigger_force_n, e.compliance_across_mm_per_n, e.compliance_along_mm_per_n,
                e.backlash_mm, e.drift_mm_per_hour, e.drift_mm_per_1000_touches, e.swing_mm, e.swing_period.count(), e.false_triggers,
                e.misses, e.bounces);
        for (const double a : e.harmonics_mm) add(a);
    }
    void add(const Options& o) {
        add_all(o.epsilon, std::uint64_t{o.reach.has_value()}, o.reach.value_or(0.0), o.refinement_floor, o.trust, o.audit, o.random_seed,
                std::uint64_t{o.standoff.has_value()}, o.standoff.value_or(0.0));
        for (const int word : {static_cast<int>(o.strategy.refine), static_cast<int>(o.strategy.explore),
                               static_cast<int>(o.strategy.infer), static_cast<int>(o.strategy.travel)}) {
            add(static_cast<std::uint64_t>(word));
        }
        if (o.tolerance_box) add(*o.tolerance_box);
        for (const auto& value :
             {o.tolerance, o.spacing_min, o.earlier_limit, o.sizing.smallest, o.budget.displacement, o.budget.machine_time}) {
            add_all(std::uint64_t{value.has_value()}, value.value_or(0.0));
        }
        add_all(o.sizing.radii_of_curvature, o.min_angle, std::uint64_t{o.budget.probes.has_value()}, o.budget.probes.value_or(0));
        for (const RegionOfInterest& region : o.sizing.regions) add_all(region.box.min, region.box.max, region.size, region.slope);
        add(std::uint64_t{o.seed_rays.size()});
        for (const Segment& ray : o.seed_rays) {
            add_all(ray.source, ray.target);
        }
    }
    template <class... Values>
    void add_all(const Values&... values) {
        (add(values), ...);
    }
    [[nodiscard]] const std::vector<std::string>& words() const { return words_; }

private:
    std::vector<std::string> words_;
};

std::vector<std::string> flatten(const SessionConfig& config) {
    Flattener flat;
    flat.add(std::uint64_t{config.object.has_value()});
    if (config.object) {
        flat.add(*config.object);
    }
    flat.add(std::uint64_t{config.machine.has_value()});
    if (config.machine) {
        flat.add(*config.machine);
    }
    flat.add(std::uint64_t{config.tool.has_value()});
    if (config.tool) flat.add(*config.tool);
    flat.add(config.earlier.file.string());
    flat.add(config.calibration.file.string());
    flat.add(config.calibration.max_age_days);
    flat.add(std::uint64_t{config.errors.has_value()});
    if (config.errors) flat.add(*config.errors);
    flat.add_all(config.workspace, config.fixtures, config.probing, config.probing.random_seed);
    flat.add(std::uint64_t{config.area.has_value()});
    if (config.area) flat.add(*config.area);
    return flat.words();
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "palpate-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
        throw std::runtime_error("cannot make a temporary folder " + name);
    }
    path_ = std::filesystem::canonical(name);
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;  // a leftover in /tmp is no reason to fail
    std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path TemporaryFolder::write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = path_ / name;
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    stream.close();
    if (!stream) {
        throw std::runtime_error("cannot write " + file.string());
    }
    return file;
}

std::vector<std::filesystem::path> example_files() {
    const std::filesystem::directory_iterator folder(std::filesystem::path(PALPATE_CONFIG_DIR) / "examples");
    std::vector<std::filesystem::path> files(begin(folder), end(folder));
    std::sort(files.begin(), files.end());
    return files;
}

std::string contents(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) {
        throw std::runtime_error("cannot read " + file.string());
    }
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::uint64_t logged_seed() {
    const char* given = std::getenv("PALPATE_TEST_SEED");
    const std::uint64_t seed = given != nullptr ? std::stoull(given) : std::random_device{}();
    std::cout << "PALPATE_TEST_SEED=" << seed << '\n';
    return seed;
}

SessionConfig random_config(std::mt19937_64& random) {
    SessionConfig config;
    switch (random() % 4) {
        case 0:
            break;
        case 1:
            config.object = MeshSpec{"/no such folder/a \"quoted\" \\ name: {é} #" + std::to_string(random()) + "\t.off", positive(random),
                                     any_point(random), Vector(any_angle(random), any_angle(random), any_angle(random)), flip(random)};
            break;
        default:
            config.object = random_shape(random, 3);
    }
    if (flip(random)) config.machine = random_machine(random);
    if (flip(random)) config.tool = random_tool(random);
    if (config.tool && flip(random)) config.calibration = {"/calibrations/probe.json", length(random)};
    if (flip(random)) config.errors = random_errors(random);
    config.workspace = random_workspace(random);
    if (const auto* box = std::get_if<Box>(&config.workspace)) config.fixtures = random_fixtures(random, *box);
    if (const auto* box = std::get_if<Box>(&config.workspace); box != nullptr && flip(random)) config.area = random_area(random, *box);
    Options& probing = config.probing;
    probing.epsilon = length(random);
    if (flip(random)) {
        probing.reach = length(random);
    }
    if (flip(random)) {
        probing.tolerance = probing.epsilon / 2;
        if (flip(random)) probing.spacing_min = length(random);
        if (flip(random)) probing.tolerance_box = Box{{-1, -2, -3}, {length(random), length(random), length(random)}};
    }
    if (flip(random)) {
        config.earlier.file = "/sessions/first/touches.csv";
        if (flip(random)) probing.earlier_limit = length(random);
    }
    probing.strategy.refine = flip(random) ? Strategy::Refine::eager : Strategy::Refine::exhaustive;
    probing.strategy.explore = flip(random) ? Strategy::Explore::closure : Strategy::Explore::exhaustive;
    if (!config.fixtures.solids.empty() || config.area) probing.strategy.infer = Strategy::Infer::adaptive;  // which `auto` is read as then
    for (std::uint64_t i = random() % 3; i > 0; --i) {
        probing.seed_rays.push_back({any_point(random), any_point(random)});
        probing.seed_rays.back().target.x() = probing.seed_rays.back().source.x() + 1;
    }
    for (std::uint64_t i = random() % 3; i > 0; --i) {
        const Vector corner = any_point(random);
        const Vector other = flip(random) ? corner : any_point(random);
        probing.sizing.regions.push_back(
            {Box{corner.cwiseMin(other), corner.cwiseMax(other)}, length(random), std::uniform_real_distribution<double>(0, 1)(random)});
    }
    if (flip(random)) probing.sizing.radii_of_curvature = positive(random);
    if (flip(random)) probing.sizing.smallest = length(random);
    probing.min_angle = std::uniform_real_distribution<double>(0, 0.52)(random);
    if (flip(random)) probing.budget.probes = random();
    if (flip(random)) probing.budget.displacement = positive(random);
    if (flip(random)) probing.budget.machine_time = positive(random);
    probing.refinement_floor = std::uniform_real_distribution<double>(1e-9, 1.0)(random);
    config.probing.random_seed = random();
    return config;
}

bool identical(const SessionConfig& a, const SessionConfig& b) { return flatten(a) == flatten(b); }

}  // namespace palpate::test
