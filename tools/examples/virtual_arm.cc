// A virtual arm that Palpate drives: a template for a program of your own (devices/external/PROTOCOL.md).
//
// It moves a point probe around a ball that it hides (radius 20 mm, around 0, 0, 0). What to replace for a real arm is in class Arm. Built
// with nlohmann-json alone: c++ -std=c++20 -o virtual_arm virtual_arm.cc
#include <poll.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
using Point = std::array<double, 3>;

double seconds_since(Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); }
double distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

// A straight move at constant speed. A real arm moves by itself, and stops by itself when its probe changes.
class Arm {
public:
    Point position{0, 0, 60};
    std::optional<Point> touched;

    [[nodiscard]] bool probe_closed() const { return distance(position, {0, 0, 0}) <= 20; }
    void begin(const Point& to, double feed, bool until_closed) {
        start_ = position, to_ = to, feed_ = feed, until_closed_ = until_closed, begun_ = Clock::now();
        touched.reset();
    }
    // Stops it, and returns once it stands. This one stands at once; a real one is told to, and waited for.
    void stop() { to_ = start_ = position; }
    // Goes on; true once it stands.
    bool step() {
        const double length = distance(start_, to_);
        const double gone = std::min(feed_ * seconds_since(begun_), length);
        for (double at = distance(start_, position); at < gone;) {
            at = std::min(at + 0.005, gone);  // mm, so that the touch is found that exactly
            for (std::size_t k = 0; k < 3; ++k) position[k] = start_[k] + (to_[k] - start_[k]) * at / length;
            if (probe_closed() != until_closed_) continue;
            touched = position;
            return true;
        }
        return gone >= length;
    }

private:
    Point start_{}, to_{};
    double feed_ = 0;
    bool until_closed_ = true;
    Clock::time_point begun_;
};

// Whatever ends this program: Palpate may be gone, and nobody watches.
struct StopAtTheEnd {
    Arm& arm;
    ~StopAtTheEnd() { arm.stop(); }
};

int main() {
    Arm arm;
    const StopAtTheEnd stop_at_the_end{arm};
    std::optional<std::uint64_t> move;
    double silence = 0.5;
    Clock::time_point heard, told;
    std::string buffer;
    const auto say = [](const Json& line) { std::cout << line.dump() << std::endl; };
    const auto probe = [&] { return arm.probe_closed() ? "closed" : "open"; };
    while (true) {
        pollfd input{STDIN_FILENO, POLLIN, 0};
        if (::poll(&input, 1, move ? 2 : 100) > 0) {
            std::array<char, 4096> part{};
            const ssize_t count = ::read(STDIN_FILENO, part.data(), part.size());
            if (count <= 0) return 0;  // Palpate is gone
            buffer.append(part.data(), static_cast<std::size_t>(count));
            heard = Clock::now();
        }
        for (std::size_t end = buffer.find('\n'); end != std::string::npos; end = buffer.find('\n')) {
            const Json ask = Json::parse(buffer.substr(0, end));
            buffer.erase(0, end + 1);
            const std::string what = ask["ask"];
            if (what == "hello") {
                silence = ask["silence"];
                say({{"id", ask["id"]},
                     {"name", "Virtual arm in C++"},
                     {"limits", {{"min", {-100, -100, -100}}, {"max", {100, 100, 100}}}},
                     {"feed", 500},
                     {"acceleration", 1000},
                     {"resolution", 0.005},
                     {"stops_at_touch", true},
                     {"latches", true}});
            } else if (what == "state") {
                say({{"id", ask["id"]},
                     {"position", arm.position},
                     {"moving", move.has_value()},
                     {"probe", probe()},
                     {"homed", true},
                     {"fault", ""}});
            } else if (what == "stop") {
                arm.stop();
                if (move) say({{"id", *move}, {"ended", "stopped"}, {"position", arm.position}, {"probe", probe()}});
                move.reset();
                say({{"id", ask["id"]}, {"position", arm.position}, {"probe", probe()}});
            } else if (what == "move_guarded" || what == "travel") {
                const Point to = ask["to"];
                const bool until_closed = ask["until"] == "closed";
                if (move || (until_closed && arm.probe_closed())) {
                    say({{"id", ask["id"]}, {"error", move ? "it moves" : "the probe is closed"}});
                } else if (std::max({std::abs(to[0]), std::abs(to[1]), std::abs(to[2])}) > 100) {
                    say({{"id", ask["id"]}, {"error", "beyond the limits"}});
                } else {
                    arm.begin(to, ask["feed"], until_closed);
                    move = ask["id"].get<std::uint64_t>();
                    told = Clock::now();
                }
            }
        }
        if (move && seconds_since(heard) > silence) return 0;  // nobody watches
        if (move && arm.step()) {
            Json end{{"id", *move}, {"ended", arm.touched ? "probe" : "target"}, {"position", arm.position}, {"probe", probe()}};
            if (arm.touched) end["touched"] = *arm.touched;
            say(end);
            move.reset();
        } else if (move && seconds_since(told) > 0.08) {
            told = Clock::now();
            say({{"alive", true}, {"position", arm.position}});
        }
    }
}
