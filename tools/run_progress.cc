#include "tools/run_progress.h"

#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

constexpr std::chrono::seconds kEventPeriod{1};
// Of the time, looking takes one in that.
constexpr int kLookShare = 100;
constexpr std::chrono::milliseconds kLookPeriod{200};

ProgressSink sink_of(Console& console) {
    return {[&console](const std::string& line) { console.write(line + '\n'); },
            [&console](const std::string& status) { console.set_status(status); }};
}

}  // namespace

RunProgress::RunProgress(Output& output) : output_(output) {
    if (output.events == nullptr && !output.is_quiet) display_.emplace(sink_of(output.console), DisplayTraits::of(STDERR_FILENO));
}

void RunProgress::update(const Progress& progress, const RunView& run) {
    look(progress, run);
    last_ = progress;
    last_.fraction_done = fraction_ = std::max(fraction_, estimate_.fraction_done(progress));
    if (display_) display_->update(last_, estimate_.time_left());
    if (output_.events == nullptr) return;
    const auto now = std::chrono::steady_clock::now();
    if (!told_ || now - *told_ >= kEventPeriod) {
        told_ = now;
        tell(last_);
    }
}

void RunProgress::look(const Progress& progress, const RunView& run) {
    const auto begin = std::chrono::steady_clock::now();
    if (begin < next_look_) return;
    estimate_.note(begin.time_since_epoch(), progress, run.surface());
    const auto end = std::chrono::steady_clock::now();
    next_look_ = end + std::max<std::chrono::nanoseconds>(kLookShare * (end - begin), kLookPeriod);
}

void RunProgress::finish(const Result& result) {
    last_.samples = result.samples;
    last_.probes = result.cost.probes();
    last_.worst_ball_radius = result.max_ball_radius;
    last_.open_edges = result.topology.boundary_edges;
    // What is incomplete stays at what was estimated last.
    if (result.certificate.status != Certificate::Status::incomplete) last_.fraction_done = 1.0;
    if (display_) display_->finish(last_);
    if (output_.events != nullptr) tell(last_);
}

void RunProgress::tell(const Progress& progress) {
    using Json = nlohmann::ordered_json;
    const std::chrono::nanoseconds left = estimate_.time_left().left();
    const Json event = {{"event", "progress"},
                        {"fraction_done", progress.fraction_done},
                        {"seconds_left", left.count() < 0 ? Json() : Json(std::chrono::duration<double>(left).count())},
                        {"samples", progress.samples},
                        {"probes", progress.probes},
                        {"open_edges", progress.open_edges},
                        {"worst_ball_radius", progress.worst_ball_radius}};
    output_.events->write(event_line(event));
}

}  // namespace palpate
