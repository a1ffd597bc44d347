#include "sim/machines/external/virtual_program.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "devices/clock.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;
using Steady = std::chrono::steady_clock;

constexpr Seconds kTick{0.01};   // of motion
constexpr Seconds kAlive{0.08};  // from one sign of life to the next
constexpr int kIdle_ms = 2;
constexpr double kBeside = 3.0;  // mm: what is told falsely is off by that

Json list(const Point& p) { return Json::array({p.x(), p.y(), p.z()}); }
Point point_of(const Json& json) { return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()}; }

}  // namespace

struct VirtualProgram::Move {
    std::uint64_t id = 0;
    bool until_open = false;
    Point from = Point::Zero();
    Point to = Point::Zero();
    bool is_stopped = false;
    std::vector<std::uint64_t> stops{};  // questions that wait for its end
    Seconds since_sign{0};
    Steady::time_point heard = Steady::now();
};

VirtualProgram::VirtualProgram(VirtualTool& tool, VirtualProgramOptions options)
    : tool_(tool),
      options_(std::move(options)),
      end_(options_.port),
      is_homed_(options_.homed),
      thread_([this](const std::stop_token& stop) { serve(stop); }) {}

VirtualProgram::~VirtualProgram() = default;

std::string VirtualProgram::address() const { return fmt::format("127.0.0.1:{}", end_.port()); }

void VirtualProgram::with(const std::function<void(VirtualTool&)>& use) {
    const std::scoped_lock lock(mutex_);
    use(tool_);
}

std::uint64_t VirtualProgram::moves() const {
    const std::scoped_lock lock(mutex_);
    return moves_;
}

std::uint64_t VirtualProgram::abandoned() const {
    const std::scoped_lock lock(mutex_);
    return abandoned_;
}

bool VirtualProgram::suffers(ProgramFault::Kind kind) const {
    return std::ranges::any_of(options_.faults, [&](const ProgramFault& fault) { return fault.kind == kind && fault.at == moves_; });
}

bool VirtualProgram::is_probe_closed() const { return is_stuck_ || tool_.is_probe_closed(); }

void VirtualProgram::serve(const std::stop_token& stop) {
    auto last = Steady::now();
    while (!stop.stop_requested()) {
        bool is_moving = false;
        {
            const std::scoped_lock lock(mutex_);
            const auto now = Steady::now();
            const Seconds passed = options_.is_fast ? kTick : Seconds(now - std::exchange(last, now));
            const bool had_client = end_.has_client();
            heard_ += end_.read();
            if (end_.take_openings()) {
                // A new client finds a new program.
                heard_.clear();
                to_send_.clear();
                is_mute_ = false;
            } else if (had_client && !end_.has_client()) {
                leave();
            }
            for (std::size_t end = heard_.find('\n'); end != std::string::npos; end = heard_.find('\n')) {
                const std::string line = heard_.substr(0, end);
                heard_.erase(0, end + 1);
                hear(line);
            }
            if (move_) advance(passed);
            if (is_mute_) to_send_.clear();
            to_send_.erase(0, end_.write(to_send_));
            is_moving = move_ != nullptr;
        }
        if (is_moving && options_.is_fast) continue;
        std::array<pollfd, 2> fds{pollfd{end_.descriptor(), POLLIN, 0}, pollfd{end_.openings_descriptor(), POLLIN, 0}};
        ::poll(fds.data(), fds.size(), kIdle_ms);
    }
}

// Whoever told it to move is gone.
void VirtualProgram::leave() {
    heard_.clear();
    to_send_.clear();
    if (!move_) return;
    ++abandoned_;
    move_->is_stopped = true;
    tool_.decelerate();
}

void VirtualProgram::hear(const std::string& line) {
    if (move_) move_->heard = Steady::now();
    const Json json = Json::parse(line);
    const std::string ask = json.at("ask");
    if (ask == "alive") return;
    const std::uint64_t id = json.at("id");
    if (ask == "hello") {
        silence_s_ = json.at("silence");
        const VirtualToolOptions& axes = tool_.options();
        say(Json{{"id", id},
                 {"name", options_.name},
                 {"limits", {{"min", list(axes.limits.min)}, {"max", list(axes.limits.max)}}},
                 {"feed", 1000.0},
                 {"acceleration", axes.motion.acceleration_mm_per_s2},
                 {"resolution", axes.motion.resolution_mm},
                 {"stops_at_touch", options_.stops_at_touch},
                 {"latches", options_.latches},
                 {"homes", options_.homes},
                 {"latch_time", options_.latch_time.count()}}
                .dump());
    } else if (ask == "state") {
        say(Json{{"id", id},
                 {"position", list(tool_.position())},
                 {"moving", move_ != nullptr},
                 {"probe", is_probe_closed() ? "closed" : "open"},
                 {"homed", is_homed_},
                 {"fault", options_.fault}}
                .dump());
    } else if (ask == "stop" && move_) {
        move_->stops.push_back(id);
        move_->is_stopped = true;
        tool_.decelerate();
    } else if (ask == "stop") {
        say(Json{{"id", id}, {"position", list(tool_.position())}, {"probe", is_probe_closed() ? "closed" : "open"}}.dump());
    } else if (ask == "home") {
        is_homed_ = is_homed_ || options_.homes;
        const Json position = list(tool_.position());
        say((is_homed_ ? Json{{"id", id}, {"position", position}} : Json{{"id", id}, {"error", "it cannot home"}}).dump());
    } else {
        begin(id, point_of(json.at("to")), json.at("feed"), json.at("until") == "open");
    }
}

void VirtualProgram::begin(std::uint64_t id, const Point& to, double feed_mm_per_s, bool until_open) {
    if (std::exchange(is_pressed_, false)) tool_.press(false);
    Move move{id, until_open, tool_.position(), to};
    const auto refuse = [&](const char* why) { say(Json{{"id", id}, {"error", why}}.dump()); };
    if (move_) return refuse("it moves");
    ++moves_;
    if (suffers(ProgramFault::Kind::stays_closed)) is_stuck_ = true;
    if (suffers(ProgramFault::Kind::refuses)) return refuse("it does not want to");
    if (!is_homed_) return refuse("not homed");
    if (!options_.fault.empty()) return refuse(options_.fault.c_str());
    if (!tool_.options().limits.contains(move.to, tool_.options().motion.resolution_mm)) return refuse("beyond the limits");
    if (is_probe_closed() && !move.until_open) return refuse("the probe is closed");
    tool_.start_move(move.to, feed_mm_per_s, move.until_open ? VirtualTool::Guard::until_release : VirtualTool::Guard::until_contact);
    move_ = std::make_unique<Move>(std::move(move));
}

void VirtualProgram::advance(Seconds time) {
    using Kind = ProgramFault::Kind;
    if (suffers(Kind::silent)) is_mute_ = true;
    if (suffers(Kind::hang_up)) {
        end_.hang_up();
        if (!move_->is_stopped) leave();
    }
    tool_.advance(time);
    if (suffers(Kind::error_in_move) && (tool_.position() - move_->from).norm() > 1) {
        tool_.decelerate();
        say(Json{{"id", move_->id}, {"error", "protective stop"}}.dump());
        move_.reset();
        return;
    }
    // In fast time the host's silence cannot be told from its slowness.
    const bool is_unheard = !options_.is_fast && Seconds(Steady::now() - move_->heard).count() > silence_s_;
    if (is_unheard && !move_->is_stopped) leave();
    move_->since_sign += time;
    if (move_->since_sign >= kAlive || suffers(Kind::never_ends)) {
        move_->since_sign = Seconds(0);
        const Vector off = suffers(Kind::seen_beside) ? Vector((move_->to - move_->from).unitOrthogonal() * kBeside) : Vector::Zero();
        say(Json{{"alive", true}, {"position", list(tool_.position() + off)}}.dump());
    }
    if (suffers(Kind::never_ends) && !move_->is_stopped) {
        if (options_.is_fast) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        return;
    }
    if (!tool_.is_moving()) end_move();
}

void VirtualProgram::end_move() {
    using Kind = ProgramFault::Kind;
    const std::unique_ptr<Move> move = std::move(move_);
    const auto trigger = tool_.trigger();
    const Vector along = (move->to - move->from).normalized();
    const Vector beside = along.unitOrthogonal() * kBeside;
    if (suffers(Kind::no_json)) say("moved as told");
    Json answer{{"id", suffers(Kind::wrong_id) ? move->id + 7 : move->id}};
    answer["ended"] = suffers(Kind::stops_by_itself) ? "stopped" : trigger ? "probe" : move->is_stopped ? "stopped" : "target";
    if (trigger) answer["touched"] = list(suffers(Kind::touched_beside) ? Point(*trigger + beside) : *trigger);
    if (suffers(Kind::closed_at_end)) {
        answer.erase("touched");
        answer["ended"] = "target";
        tool_.press(is_pressed_ = true);
    }
    Point rest = tool_.position();
    if (suffers(Kind::rest_beside)) rest += beside;
    if (suffers(Kind::rest_far) && trigger) rest = *trigger + 8 * along;
    if (!suffers(Kind::half_answer)) answer["position"] = list(rest);
    if (answer["ended"] == "stopped" && !move->is_stopped) answer["why"] = "its emergency stop is in";
    answer["probe"] = is_probe_closed() ? "closed" : "open";
    say(answer.dump());
    for (const std::uint64_t id : move->stops) {
        say(Json{{"id", id}, {"position", list(tool_.position())}, {"probe", is_probe_closed() ? "closed" : "open"}}.dump());
    }
}

}  // namespace palpate
