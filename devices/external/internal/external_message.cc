#include "devices/external/internal/external_message.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace palpate::external {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kProtocol = 1;

// Reads members of one object; the first that is not what it has to be is named.
class Members {
public:
    explicit Members(const Json& object) : object_(object) {}

    void text(const char* key, std::optional<std::string>& field) {
        const Json* const value = find(key);
        if (value == nullptr) return;
        if (!value->is_string()) return complain(key, "is no text");
        field = value->get<std::string>();
    }
    void flag(const char* key, std::optional<bool>& field) {
        const Json* const value = find(key);
        if (value == nullptr) return;
        if (!value->is_boolean()) return complain(key, "is neither true nor false");
        field = value->get<bool>();
    }
    void number(const char* key, std::optional<double>& field) {
        const Json* const value = find(key);
        if (value == nullptr) return;
        if (!is_finite(*value)) return complain(key, "is no finite number");
        field = value->get<double>();
    }
    void point(const char* key, std::optional<Point>& field) {
        if (const Json* const value = find(key)) field = to_point(key, *value);
    }
    void box(const char* key, std::optional<Box>& field) {
        const Json* const value = find(key);
        if (value == nullptr) return;
        if (!value->is_object() || !value->contains("min") || !value->contains("max")) return complain(key, "has no min and max");
        const auto low = to_point(key, value->at("min"));
        const auto high = to_point(key, value->at("max"));
        if (low && high) field = Box{*low, *high};
    }
    [[nodiscard]] const Json* find(const char* key) const {
        const auto found = object_.find(key);
        return found == object_.end() || found->is_null() ? nullptr : &*found;
    }
    void complain(const char* key, const char* what) {
        if (problem_.empty()) problem_ = fmt::format("\"{}\" {}", key, what);
    }
    [[nodiscard]] const std::string& problem() const { return problem_; }

private:
    [[nodiscard]] static bool is_finite(const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); }
    std::optional<Point> to_point(const char* key, const Json& value) {
        bool is_good = value.is_array() && value.size() == 3;
        for (std::size_t k = 0; is_good && k < 3; ++k) is_good = is_finite(value[k]);
        if (!is_good) {
            complain(key, "is no list of three finite numbers");
            return std::nullopt;
        }
        return Point(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
    }

    const Json& object_;
    std::string problem_;
};

Json list(const Point& p) { return Json::array({p.x(), p.y(), p.z()}); }

std::string line(const Json& json) { return json.dump() + '\n'; }

}  // namespace

std::variant<Line, Malformed> parse(std::string_view text) {
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) return Malformed{"is no JSON"};
    if (!json.is_object()) return Malformed{"is no JSON object"};
    Members members(json);
    Line line;
    if (const Json* const id = members.find("id")) {
        if (id->is_number_unsigned()) {
            line.id = id->get<std::uint64_t>();
        } else {
            members.complain("id", "is no whole number");
        }
    } else if (const Json* const alive = members.find("alive"); alive == nullptr || *alive != true) {
        return Malformed{R"(has neither an "id" nor "alive": true)"};
    }
    members.text("error", line.error);
    members.point("position", line.position);
    members.point("touched", line.touched);
    std::optional<std::string> probe;
    members.text("probe", probe);
    if (probe && *probe != "open" && *probe != "closed") members.complain("probe", R"(is neither "open" nor "closed")");
    if (probe) line.probe_closed = *probe == "closed";
    members.text("ended", line.ended);
    members.flag("moving", line.moving);
    members.flag("homed", line.homed);
    members.text("fault", line.fault);
    members.text("name", line.name);
    members.box("limits", line.limits);
    members.number("feed", line.feed);
    members.number("acceleration", line.acceleration);
    members.number("resolution", line.resolution);
    members.flag("stops_at_touch", line.stops_at_touch);
    members.flag("latches", line.latches);
    members.number("latch_time", line.latch_time);
    members.flag("homes", line.homes);
    members.text("why", line.why);
    if (!members.problem().empty()) return Malformed{members.problem()};
    return line;
}

std::string ask(std::uint64_t id, std::string_view what) { return line({{"id", id}, {"ask", what}}); }

std::string ask_hello(std::uint64_t id, double silence_s) {
    return line({{"id", id}, {"ask", "hello"}, {"protocol", kProtocol}, {"silence", silence_s}});
}

std::string ask_move(std::uint64_t id, const Move& move) {
    return line({{"id", id},
                 {"ask", move.is_travel ? "travel" : "move_guarded"},
                 {"to", list(move.to)},
                 {"feed", move.feed_mm_per_s},
                 {"acceleration", move.acceleration_mm_per_s2},
                 {"until", move.until_open ? "open" : "closed"}});
}

}  // namespace palpate::external
