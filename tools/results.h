// What a finished run leaves and says, wherever its answers came from.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <functional>
#include <iostream>
#include <string>

#include "planner/probe_surface.h"
#include "tools/progress_display.h"

namespace palpate {

// What `run` returns, a value with a Result in it, with a progress line on standard error. It is given what to call with progress.
template <typename Run>
[[nodiscard]] auto with_progress(const Run& run) {
    ProgressDisplay display(std::cerr, DisplayTraits::of(STDERR_FILENO));
    Progress last;
    auto finished = run(std::function<void(const Progress&)>([&](const Progress& progress) {
        last = progress;
        display.update(progress);
    }));
    const Result& result = finished.result;
    last.samples = result.samples;
    last.probes = result.cost.probes();
    last.worst_ball_radius = result.max_ball_radius;
    last.open_edges = result.topology.boundary_edges;
    last.fraction_done = 1.0;
    display.finish(last);
    return finished;
}

struct PictureChoice {
    bool drawn = true;
    char up = 'z';  // x, y or z
};

// mesh.ply, touches.csv, summary.json and, if there is a mesh, picture.png; returns their names, with commas between. Throws OutputError.
[[nodiscard]] std::string write_results(const std::filesystem::path& folder, const Result& result, const std::string& summary,
                                        const PictureChoice& picture);

// Draws picture.png of a session again, from its mesh.ply. Throws ObjectError if that is no mesh of triangles, OutputError.
void draw_session_picture(const std::filesystem::path& folder, char up);

// Counts, mesh, certificate. `truth`: what only a simulation knows, as a line of its own; may be empty.
void print_result(const Result& result, double epsilon, const std::string& truth, std::ostream& out);

}  // namespace palpate
