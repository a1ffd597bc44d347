#include "tools/session_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <system_error>

#include "planner/number_text.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 6> kSessionFiles = {kConfigFile, kJournalFile, kMeshFile, "touches.csv", "summary.json", kPictureFile};

void append(std::string& text, const Point& p, char separator) {
    for (int axis = 0; axis < 3; ++axis) {
        if (axis > 0) text += separator;
        append_number(text, p[axis]);
    }
}

const char* to_string(Touch::Role role) {
    switch (role) {
        case Touch::Role::crossing:
            return "crossing";
        case Touch::Role::seed:
            return "seed";
        case Touch::Role::seed_facet:
            return "seed_facet";
        case Touch::Role::refinement:
            return "refinement";
        case Touch::Role::repair:
            return "repair";
        case Touch::Role::check:
            return "check";
    }
    return "";
}

}  // namespace

void prepare_session_folder(const fs::path& folder, bool force) {
    std::error_code error;
    for (const char* file : kSessionFiles) {
        if (!force && fs::exists(folder / file, error)) {
            throw OutputError(
                fmt::format("{}: holds a session already ({}); choose another folder, resume it, or (simulate) give --force to replace it",
                            folder.string(), file));
        }
    }
    fs::create_directories(folder, error);
    if (error || !fs::is_directory(folder)) {
        throw OutputError(fmt::format("{}: cannot make this folder: {}", folder.string(), error.message()));
    }
    write_file(folder / "palpate.trial", "");
    fs::remove(folder / "palpate.trial", error);
}

void remove_unbegun_session(const fs::path& folder) {
    std::error_code ignored;
    const fs::path journal = folder / kJournalFile;
    if (fs::exists(journal, ignored) && fs::file_size(journal, ignored) > 0) return;
    fs::remove(journal, ignored);
    // Without a journal, the mesh of a simulation says that there is a session.
    if (!fs::exists(folder / kMeshFile, ignored)) fs::remove(folder / kConfigFile, ignored);
}

void write_file(const fs::path& file, const std::string& content) {
    // Beside the old one first: a full disk must not cost what was there.
    const fs::path unfinished = file.string() + ".unfinished";
    std::error_code error;
    {
        std::ofstream out(unfinished, std::ios::binary);
        out << content;
        out.close();
        if (!out) {
            fs::remove(unfinished, error);
            throw OutputError(fmt::format("{}: cannot be written: is the disk full, or the folder read-only?", file.string()));
        }
    }
    fs::rename(unfinished, file, error);
    if (error) throw OutputError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
}

std::string to_ply(const TriangleMesh& mesh) {
    std::string text = fmt::format(
        "ply\n"
        "format ascii 1.0\n"
        "comment made by Palpate; millimetres\n"
        "element vertex {}\n"
        "property double x\n"
        "property double y\n"
        "property double z\n"
        "element face {}\n"
        "property list uchar int vertex_indices\n"
        "end_header\n",
        mesh.points.size(), mesh.triangles.size());
    for (const Point& p : mesh.points) {
        append(text, p, ' ');
        text += '\n';
    }
    for (const auto& [a, b, c] : mesh.triangles) {
        fmt::format_to(std::back_inserter(text), "3 {} {} {}\n", a, b, c);
    }
    return text;
}

std::string to_csv(const std::vector<Touch>& touches) {
    std::string text = "touch,x,y,z,from_x,from_y,from_z,role,sample\n";
    for (std::size_t k = 0; k < touches.size(); ++k) {
        const Touch& touch = touches[k];
        fmt::format_to(std::back_inserter(text), "{},", k);
        append(text, touch.position, ',');
        text += ',';
        append(text, touch.from, ',');
        const std::string sample = touch.sample ? std::to_string(*touch.sample) : "";
        fmt::format_to(std::back_inserter(text), ",{},{}\n", to_string(touch.role), sample);
    }
    return text;
}

}  // namespace palpate
