// How far a run is, told in the form that was asked for: a line that rewrites itself, plain lines, events, or not at all.
#pragma once

#include <optional>

#include "planner/probe_surface.h"
#include "tools/run_estimate.h"
#include "tools/terminal/output.h"
#include "tools/terminal/progress_display.h"

namespace palpate {

class RunProgress {
public:
    // `output` must outlive it.
    explicit RunProgress(Output& output);

    void update(const Progress& progress, const RunView& run);
    // The run has come to its end, with that.
    void finish(const Result& result);

private:
    // Looks at the mesh now and then, to see how much of it is open: what it costs stays a small share of the run.
    void look(const Progress& progress, const RunView& run);
    void tell(const Progress& progress);

    Output& output_;
    std::optional<ProgressDisplay> display_;
    Progress last_;
    RunEstimate estimate_;
    std::optional<std::chrono::steady_clock::time_point> told_;
    std::chrono::steady_clock::time_point next_look_{};
    double fraction_ = 0.0;  // told last
};

// What `run` returns, a value with a Result in it, with progress. It is given the observer to call.
template <typename Run>
[[nodiscard]] auto with_progress(Output& output, const Run& run) {
    RunProgress progress(output);
    Observer observer;
    observer.on_progress = [&](const Progress& now, const RunView& view) { progress.update(now, view); };
    auto finished = run(observer);
    progress.finish(finished.result);
    return finished;
}

}  // namespace palpate
