#include "tools/results.h"

#include <fmt/format.h>

#include <ostream>

#include "planner/number_text.h"
#include "sim/objects/mesh/mesh_file.h"
#include "tools/session_files.h"
#include "tools/summary.h"
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

void list_places(std::ostream& out, const char* kind, const std::vector<BadPlace>& places) {
    constexpr std::size_t kShown = 10;
    for (std::size_t k = 0; k < places.size() && k < kShown; ++k) {
        out << "  " << kind << "    " << places[k].what << " at " << point_text(places[k].position) << ": needs an epsilon below "
            << places[k].epsilon_needed << " mm\n";
    }
    if (places.size() > kShown) out << "  and " << places.size() - kShown << " more " << kind << "s, see summary.json\n";
}

// "12 (1.5 x the bound)"; without a mesh there is no bound.
std::string per_bound(double amount, double bound, const std::string& of_what) {
    if (!(bound > 0)) return "";
    return fmt::format(" ({:.6g} x the {})", amount / bound, of_what);
}

}  // namespace

std::string write_results(const std::filesystem::path& folder, const Result& result, const std::string& summary,
                          const PictureChoice& picture) {
    write_file(folder / kMeshFile, to_ply(result.mesh));
    write_file(folder / "touches.csv", to_csv(result.touches));
    write_file(folder / "summary.json", summary);
    const std::string names = "mesh.ply, touches.csv, summary.json";
    if (!picture.drawn || result.mesh.triangles.empty()) {
        // One that is there shows another mesh.
        std::error_code ignored;
        std::filesystem::remove(folder / kPictureFile, ignored);
        return names;
    }
    draw_samples(folder, result.mesh, picture.up);
    return fmt::format("{}, {}", names, kPictureFile);
}

void draw_session_picture(const std::filesystem::path& folder, char up) { draw_samples(folder, read_triangles(folder / kMeshFile), up); }

void print_result(const Result& r, double epsilon, const std::string& truth, std::ostream& out) {
    const Cost& a = r.cost;
    out << "samples        " << r.samples << per_bound(static_cast<double>(r.samples), r.lower_bound_samples, "hexagonal bound") << "\n"
        << "probes         " << a.probes() << " (" << static_cast<double>(a.probes()) / static_cast<double>(r.samples)
        << " per sample): " << a.contact << " contacts, " << a.clear << " clear"
        << (a.failed > 0 ? fmt::format(", {} failed", a.failed) : "") << "\n"
        << "displacement   " << a.displacement() << " mm" << per_bound(a.displacement(), r.lower_bound_displacement, "bound") << ": "
        << a.travel << " travel, " << a.probing << " probing\n"
        << "mesh           " << r.topology.facets << " facets, " << r.topology.components << " component(s), Euler characteristic "
        << r.topology.euler_characteristic << ", " << r.topology.boundary_edges << " boundary and " << r.topology.nonmanifold_edges
        << " non-manifold edges, largest ball " << r.max_ball_radius << " mm (epsilon " << epsilon << ")\n"
        << (truth.empty() ? "" : fmt::format("truth          {}\n", truth)) << "certificate    " << to_string(r.certificate.status) << ": "
        << r.certificate.statement << '\n';
    for (const Premise& premise : r.certificate.premises) {
        out << "  " << to_string(premise.state) << "  " << name_of(premise.kind) << " - " << premise.detail << '\n';
    }
    list_places(out, "bad place", r.bad_places);
    list_places(out, "thin place", r.thin_places);
}

}  // namespace palpate
