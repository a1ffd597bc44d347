// What a finished run leaves and says, wherever its answers came from.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>

#include "planner/probe_surface.h"
#include "tools/curved_result.h"
#include "tools/part_result.h"
#include "tools/provenance.h"
#include "tools/terminal/output.h"

namespace palpate {

struct PictureChoice {
    bool drawn = true;
    char up = 'z';  // x, y or z
};

// mesh.ply, touches.csv, summary.json, surface.ply if there is one and, if there is a mesh, picture.png; returns their names, with commas
// between. With a part, that is mesh.ply, and Ŝ is mesh_tool.ply; with an area alone, mesh.ply is Ŝ within it. Throws OutputError.
[[nodiscard]] std::string write_results(const std::filesystem::path& folder, const Result& result, const std::optional<PartResult>& part,
                                        const std::optional<CurvedSurface>& curved, const Provenance& provenance,
                                        const std::string& summary, const PictureChoice& picture);

// Draws picture.png of a session again, from its mesh.ply and the tags in it. Throws ObjectError if that is no mesh of triangles,
// OutputError.
void draw_session_picture(const std::filesystem::path& folder, char up);

// What only some runs have to tell, as a line of its own: a simulation the truth, a machine how it drifted.
struct ResultLine {
    const char* label = "";
    std::string text;  // empty: no line
};

// Counts, mesh, certificate, in lines of at most `columns` (0: however long they are).
void print_result(const Result& result, const std::optional<PartResult>& part, double epsilon, const ResultLine& besides, std::ostream& out,
                  int columns = 0);

// The end of a run, in the form that was asked for. `summary` is summary.json, `files` what was written to `folder`. Waits until all of it
// is read.
void tell_result(Output& output, const Result& result, const std::optional<PartResult>& part, double epsilon, const ResultLine& besides,
                 const std::string& summary, const std::filesystem::path& folder, const std::string& files);

[[nodiscard]] bool is_stopped_by_budget(const Certificate& certificate);

}  // namespace palpate
