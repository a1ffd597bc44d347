// palpate export: a session's result as other programs read it.
#include <fmt/format.h>

#include <ostream>

#include "sim/objects/mesh/mesh_file.h"
#include "tools/commands/commands.h"
#include "tools/formats/export_format.h"
#include "tools/formats/height_map.h"
#include "tools/formats/mesh_formats.h"
#include "tools/formats/sections.h"
#include "tools/session_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

// mm/min, in a file that only says what was probed.
constexpr double kFeed = 100.0;
// Of a height map whose step is not given: so many nodes along its longer side.
constexpr double kNodes = 50.0;

ExportFormat format_of(const ExportCommand& command) {
    const auto format = command.format.empty() ? export_format_of(command.file) : parse_export_format(command.format);
    if (format) return *format;
    throw OutputError(command.format.empty() ? fmt::format("{}: its extension names no format; say --format, one of {}",
                                                           command.file.string(), export_format_names())
                                             : fmt::format("--format {}: allowed: {}", command.format, export_format_names()));
}

fs::path mesh_of(const ExportCommand& command) {
    const char* const name = command.mesh == "tool" ? kToolMeshFile : command.mesh == "surface" ? kSurfaceFile : kMeshFile;
    return file_of_session(command.folder, name);
}

std::string csv_of(const TriangleMesh& mesh) {
    std::string text = "x,y,z,nx,ny,nz\n";
    for (const char c : to_xyz(mesh)) text += c == ' ' ? ',' : c;
    return text;
}

HeightMap heights_of(const TriangleMesh& mesh, const ExportCommand& command, ExportFormat format) {
    std::array<double, 2> low{};
    std::array<double, 2> high{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const auto k = static_cast<int>(axis);
        const auto at = [&](const Point& p) { return p[k]; };
        low.at(axis) = command.window.empty() ? at(*std::ranges::min_element(mesh.points, {}, at)) : command.window[axis];
        high.at(axis) = command.window.empty() ? at(*std::ranges::max_element(mesh.points, {}, at)) : command.window[axis + 2];
    }
    HeightMap map = height_map(mesh, low, high, command.step.value_or(std::max(high[0] - low[0], high[1] - low[1]) / kNodes));
    const std::size_t missing = map.missing();
    if (missing == map.heights.size()) throw OutputError("nothing of the surface lies in that window: give another --window");
    if (missing == 0 || (format == ExportFormat::opencncpilot && !command.missing)) return map;
    if (!command.missing) {
        throw OutputError(fmt::format(
            "{} of {} nodes lie beside the surface, and this format has to have them all: give a --window that the surface fills, or with "
            "--missing the height of what lies beside it",
            missing, map.heights.size()));
    }
    for (auto& z : map.heights) z = z.value_or(*command.missing);
    return map;
}

std::string height_map_text(const HeightMap& map, ExportFormat format) {
    switch (format) {
        case ExportFormat::bcnc:
            return to_bcnc(map, kFeed);
        case ExportFormat::candle:
            return to_candle(map);
        case ExportFormat::opencncpilot:
            return to_opencncpilot(map);
        default:
            return to_ugs(map);
    }
}

std::string dxf_of(const TriangleMesh& mesh, const std::vector<double>& heights) {
    if (heights.empty()) throw OutputError("DXF has level sections: say their heights, as in --sections 0,2.5,5");
    std::string text = to_dxf(mesh, heights);
    if (text.find("POLYLINE") == std::string::npos) throw OutputError("the surface reaches none of the heights in --sections");
    return text;
}

std::string content_of(const TriangleMesh& mesh, const ExportCommand& command, ExportFormat format) {
    if (is_height_map(format)) return height_map_text(heights_of(mesh, command, format), format);
    switch (format) {
        case ExportFormat::ply:
            return to_ply(mesh, {"made by Palpate; millimetres"});
        case ExportFormat::stl:
            return to_stl(mesh);
        case ExportFormat::obj:
            return to_obj(mesh);
        case ExportFormat::off:
            return to_off(mesh);
        case ExportFormat::three_mf:
            return to_3mf(mesh);
        case ExportFormat::vtp:
            return to_vtp(mesh);
        case ExportFormat::xyz:
            return to_xyz(mesh);
        case ExportFormat::csv:
            return csv_of(mesh);
        default:
            return dxf_of(mesh, command.sections);
    }
}

}  // namespace

ExitCode run(const ExportCommand& command, Output& output) {
    const ExportFormat format = format_of(command);
    const fs::path source = mesh_of(command);
    refuse_to_replace(command.file, command.force);
    const TriangleMesh mesh = read_triangles(source);
    try {
        write_file(command.file, content_of(mesh, command, format));
    } catch (const std::invalid_argument& error) {
        throw OutputError(error.what());
    }
    output.results << "written to     " << command.file.string() << ", from " << source.string() << '\n';
    return ExitCode::done;
}

}  // namespace palpate
