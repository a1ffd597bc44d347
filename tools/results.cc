#include "tools/results.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <ostream>

#include "planner/number_text.h"
#include "planner/part/traced_surface.h"
#include "sim/objects/mesh/mesh_file.h"
#include "tools/session_files.h"
#include "tools/summary.h"
#include "tools/terminal/text_width.h"
#include "tools/view/picture.h"
#include "tools/view/png.h"

namespace palpate {
namespace {

PictureOptions picture_options(char up) {
    PictureOptions options;
    if (up == 'y') {
        options.up = Vector::UnitY();
        options.view_direction = {0.35, 0.38, 1.0};
    } else if (up == 'x') {
        options.up = Vector::UnitX();
        options.view_direction = {1.0, 1.0, -1.8};
    }
    return options;
}

// The points of a session's mesh are its samples.
void draw_samples(const std::filesystem::path& folder, const TriangleMesh& mesh, char up) {
    write_file(folder / kPictureFile, to_png(draw_picture(mesh, mesh.points, picture_options(up))));
}

// Of the part: its triangles in the colours of their tags, and which is which.
void draw_part(const std::filesystem::path& folder, const TriangleMesh& mesh, const std::vector<PartTag>& facet_tags, char up) {
    PictureOptions options = picture_options(up);
    for (const PartTag tag : facet_tags) options.triangle_colours.push_back(colour_of(tag));
    options.legend = legend_of(mesh, facet_tags);
    write_file(folder / kPictureFile, to_png(draw_picture(mesh, {}, options)));
}

void list_places(std::ostream& out, const char* kind, const std::vector<BadPlace>& places) {
    constexpr std::size_t kShown = 10;
    for (std::size_t k = 0; k < places.size() && k < kShown; ++k) {
        out << "  " << kind << "    " << places[k].what << " at " << point_text(places[k].position) << ": needs an epsilon below "
            << places[k].epsilon_needed << " mm\n";
    }
    if (places.size() > kShown) out << "  and " << places.size() - kShown << " more " << kind << "s, see summary.json\n";
}

const char* known_text(const Result& r) {
    if (r.is_outside.empty()) return "fixtures";
    return r.certificate.find(Premise::Kind::known_solids) != nullptr ? "fixtures and the area's walls" : "the area's walls";
}

// "12 (1.5 x the bound)"; without a mesh there is no bound.
std::string per_bound(double amount, double bound, const std::string& of_what) {
    if (!(bound > 0)) return "";
    return fmt::format(" ({:.6g} x the {})", amount / bound, of_what);
}

}  // namespace

std::string write_results(const std::filesystem::path& folder, const Result& result, const std::optional<PartResult>& part,
                          const std::optional<CurvedSurface>& curved, const Provenance& provenance, const std::string& summary,
                          const PictureChoice& picture) {
    const std::vector<std::string> comments = mesh_comments(provenance, result.certificate);
    // Without a part: Ŝ, open where an area ends.
    const TriangleMesh plain = part ? TriangleMesh{} : mesh_within_area(result);
    const bool is_changed = part || !result.is_outside.empty();
    write_file(folder / kMeshFile, part ? to_ply(part->surface, comments) : to_ply(plain, comments));
    if (is_changed) write_file(folder / kToolMeshFile, to_ply(result.mesh, comments));
    write_file(folder / kTouchesFile, part ? to_csv(result.touches, *part) : to_csv(result.touches));
    write_file(folder / kSummaryFile, summary);
    std::string names = is_changed ? "mesh.ply, mesh_tool.ply, touches.csv, summary.json" : "mesh.ply, touches.csv, summary.json";
    if (curved) {
        write_file(folder / kSurfaceFile, to_ply(*curved, comments));
        names += fmt::format(", {}", kSurfaceFile);
    } else {
        // One that is there is of another mesh.
        std::error_code ignored;
        std::filesystem::remove(folder / kSurfaceFile, ignored);
    }
    if (!picture.drawn || (part ? part->surface.mesh : plain).triangles.empty()) {
        // One that is there shows another mesh.
        std::error_code ignored;
        std::filesystem::remove(folder / kPictureFile, ignored);
        return names;
    }
    part ? draw_part(folder, part->surface.mesh, part->surface.facet_tags, picture.up) : draw_samples(folder, plain, picture.up);
    return fmt::format("{}, {}", names, kPictureFile);
}

void draw_session_picture(const std::filesystem::path& folder, char up) {
    const TriangleMesh mesh = read_triangles(folder / kMeshFile);
    std::ifstream in(folder / kMeshFile, std::ios::binary);
    const std::vector<PartTag> tags = facet_tags_in({std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()});
    tags.size() == mesh.triangles.size() ? draw_part(folder, mesh, tags, up) : draw_samples(folder, mesh, up);
}

void print_result(const Result& r, const std::optional<PartResult>& part, double epsilon, const ResultLine& besides, std::ostream& out,
                  int columns) {
    const Cost& a = r.cost;
    const std::size_t touched = r.samples - r.known_samples;
    constexpr int kLabel = 15;
    const auto line = [&](const char* label, const std::string& text) {
        out << wrapped(fmt::format("{:<{}}{}", label, kLabel, text), columns, kLabel) << '\n';
    };
    line("samples",
         fmt::format("{}{}{}", touched, per_bound(static_cast<double>(r.samples), r.lower_bound_samples, "hexagonal bound"),
                     r.known_samples > 0 ? fmt::format(", and {} on {}, untouched", r.known_samples, known_text(r)) : std::string()));
    line("probes", fmt::format("{} ({:.6g} per sample): {} contacts, {} clear{}", a.probes(),
                               static_cast<double>(a.probes()) / static_cast<double>(touched), a.contact, a.clear,
                               a.failed > 0 ? fmt::format(", {} failed", a.failed) : std::string()));
    line("displacement", fmt::format("{:.6g} mm{}: {:.6g} travel, {:.6g} probing", a.displacement(),
                                     per_bound(a.displacement(), r.lower_bound_displacement, "bound"), a.travel, a.probing));
    line("mesh",
         fmt::format("{} facets, {} component(s), Euler characteristic {}, {} boundary and {} non-manifold edges, largest ball {:.6g} "
                     "mm (epsilon {:.6g})",
                     r.topology.facets, r.topology.components, r.topology.euler_characteristic, r.topology.boundary_edges,
                     r.topology.nonmanifold_edges, r.max_ball_radius, epsilon));
    if (part) line("part", describe(part->report));
    if (!besides.text.empty()) line(besides.label, besides.text);
    line("certificate", fmt::format("{}: {}", to_string(r.certificate.status), r.certificate.statement));
    for (const Premise& premise : r.certificate.premises) {
        out << wrapped(fmt::format("  {}  {} - {}", to_string(premise.state), name_of(premise.kind), premise.detail), columns, 4) << '\n';
    }
    list_places(out, "bad place", r.bad_places);
    list_places(out, "thin place", r.thin_places);
}

void tell_result(Output& output, const Result& result, const std::optional<PartResult>& part, double epsilon, const ResultLine& besides,
                 const std::string& summary, const std::filesystem::path& folder, const std::string& files) {
    if (output.events == nullptr) {
        print_result(result, part, epsilon, besides, output.results, output.columns);
        output.results << wrapped(fmt::format("written to     {}: {}", folder.string(), files), output.columns, 15) << '\n';
        return;
    }
    using Json = nlohmann::ordered_json;
    const Json event = {{"event", "result"}, {"folder", folder.string()}, {"summary", Json::parse(summary)}};
    while (!output.events->flush(std::chrono::hours(1)) && !output.events->is_dead()) {
    }
    output.results << event_line(event) << std::flush;
}

bool is_stopped_by_budget(const Certificate& certificate) {
    const Premise* const own_end = certificate.find(Premise::Kind::own_end);
    return own_end != nullptr && own_end->state == Premise::State::refuted;
}

}  // namespace palpate
