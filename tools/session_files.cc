#include "tools/session_files.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <system_error>

#include "planner/number_text.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

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
        case Touch::Role::earlier:
            return "earlier";
    }
    return "";
}

// 0, or errno: streams do not say why they failed.
int write_bytes(const fs::path& file, const std::string& content) {
    std::FILE* const out = std::fopen(file.c_str(), "wb");
    if (out == nullptr) return errno;
    const bool is_whole = std::fwrite(content.data(), 1, content.size(), out) == content.size();
    const int reason = is_whole ? 0 : errno;
    if (std::fclose(out) != 0 && is_whole) return errno;
    return reason;
}

}  // namespace

void remove_unbegun_session(const fs::path& folder) {
    std::error_code ignored;
    const fs::path journal = folder / kJournalFile;
    if (fs::exists(journal, ignored) && fs::file_size(journal, ignored) > 0) return;
    fs::remove(journal, ignored);
    // Without a journal, the mesh of a simulation says that there is a session.
    if (fs::exists(folder / kMeshFile, ignored)) return;
    fs::remove(folder / kConfigFile, ignored);
    fs::remove(folder / kEarlierFile, ignored);
}

std::string shell_word(const std::string& word) {
    constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%";
    if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + '\'';
}

std::string read_file(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

fs::path file_of_session(const fs::path& folder, const char* name) {
    const fs::path file = folder / name;
    if (!fs::is_regular_file(file)) {
        throw OutputError(fmt::format("{} is not there: give the folder of a session that has one", file.string()));
    }
    return file;
}

void refuse_to_replace(const fs::path& file, bool force) {
    if (force || !fs::exists(file)) return;
    throw OutputError(fmt::format("{}: exists; choose another name, or give --force to replace it", file.string()));
}

void write_file(const fs::path& file, const std::string& content) {
    // Beside the old one first: a full disk must not cost what was there.
    const fs::path unfinished = file.string() + ".unfinished";
    std::error_code error(write_bytes(unfinished, content), std::generic_category());
    if (!error) fs::rename(unfinished, file, error);
    if (!error) return;
    std::error_code ignored;
    fs::remove(unfinished, ignored);
    throw OutputError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
}

std::string to_ply(const TriangleMesh& mesh, const std::vector<std::string>& comments) {
    std::string text = "ply\nformat ascii 1.0\n";
    for (const std::string& comment : comments) fmt::format_to(std::back_inserter(text), "comment {}\n", comment);
    fmt::format_to(std::back_inserter(text),
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
