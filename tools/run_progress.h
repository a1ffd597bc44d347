// How far a run is, told in the form that was asked for: a line that rewrites itself, plain lines, events, or not at all.
#pragma once

#include <optional>

#include "planner/probe_surface.h"
#include "tools/terminal/output.h"
#include "tools/terminal/progress_display.h"

namespace palpate {

class RunProgress {
public:
    // `output` must outlive it.
    explicit RunProgress(Output& output);

    void update(const Progress& progress);
    // Looks at the mesh now and then, to see how much of it is open: what it costs stays a small share of the run.
    void look(const RunView& run);
    // The run has come to its end, with that.
    void finish(const Result& result);

private:
    void tell(const Progress& progress);
    [[nodiscard]] double fraction_of(const Progress& progress) const;

    Output& output_;
    std::optional<ProgressDisplay> display_;
    Progress last_;
    TimeLeft time_left_;  // for events; the display reckons by itself
    std::optional<std::chrono::steady_clock::time_point> told_;
    std::chrono::steady_clock::time_point next_look_{};
    double expected_samples_ = 0.0;  // as the open area has it; 0: not known
    double fraction_ = 0.0;          // told last
};

// What `run` returns, a value with a Result in it, with progress. It is given the observer to call.
template <typename Run>
[[nodiscard]] auto with_progress(Output& output, const Run& run) {
    RunProgress progress(output);
    Observer observer;
    observer.on_progress = [&](const Progress& now) { progress.update(now); };
    observer.on_sample = [&](const RunView& now) { progress.look(now); };
    auto finished = run(observer);
    progress.finish(finished.result);
    return finished;
}

}  // namespace palpate
