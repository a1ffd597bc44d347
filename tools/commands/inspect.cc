// palpate inspect: a session's result against a reference mesh.
#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "planner/number_text.h"
#include "sim/objects/mesh/mesh_file.h"
#include "tools/commands/commands.h"
#include "tools/inspection.h"
#include "tools/session_files.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFacetPoints = 100'000;
constexpr std::size_t kBins = 15;
constexpr std::size_t kWidest = 50;  // characters of a bar

void tell(std::ostream& out, const char* what, const DeviationSummary& sum) {
    out << fmt::format("{:<14} {} places: mean {}, RMS {}, from {} to {}; 95 in 100 within {}, 99 within {}\n", what, sum.count,
                       number_text(sum.mean, " mm"), number_text(sum.rms, " mm"), number_text(sum.lowest, " mm"),
                       number_text(sum.highest, " mm"), number_text(sum.p95, " mm"), number_text(sum.p99, " mm"));
}

void draw(std::ostream& out, std::span<const double> deviations, double limit) {
    const std::vector<std::size_t> counts = histogram(deviations, limit, kBins);
    const std::size_t most = std::ranges::max(counts);
    const double width = 2 * limit / static_cast<double>(kBins);
    for (std::size_t k = 0; k < kBins; ++k) {
        const double low = -limit + static_cast<double>(k) * width;
        out << fmt::format("  {:>11.4g} to {:>11.4g} mm  {:>6.2f} %  {}\n", low, low + width,
                           100 * static_cast<double>(counts[k]) / static_cast<double>(deviations.size()),
                           std::string(counts[k] * kWidest / std::max<std::size_t>(most, 1), '#'));
    }
}

std::string table_of(const Inspected& part, const Deviations& found, const RigidMotion& motion) {
    std::string text = "x,y,z,deviation\n";
    for (std::size_t k = 0; k < part.samples.size(); ++k) {
        const Point p = motion(part.samples[k]);
        text += fmt::format("{},{},{},{}\n", p.x(), p.y(), p.z(), found.at_samples[k]);
    }
    return text;
}

}  // namespace

ExitCode run(const InspectCommand& command, Output& output) {
    std::ostream& out = output.results;
    const fs::path source = file_of_session(command.folder, command.mesh == "surface" ? kSurfaceFile : kMeshFile);
    if (!command.table.empty()) refuse_to_replace(command.table, command.force);
    const HiddenObject reference(MeshSpec{command.reference, command.scale});
    const Inspected part = inspected_part(read_triangles(source), read_file(source));
    if (part.samples.empty()) throw OutputError(fmt::format("{} has nothing that was measured", source.string()));
    RigidMotion motion;
    if (command.align) {
        const auto fit = best_fit(reference, part);
        if (!fit) throw OutputError("no best fit was found: is it the same part, about where the reference is? Else leave out --align");
        motion = *fit;
        out << fmt::format("aligned        turned by {}°, moved by {}\n", number_text(motion.degrees()), point_text(motion.translation));
    }
    const Deviations found = deviations_from(reference, part, motion, kFacetPoints);
    const DeviationSummary samples = summarize(found.at_samples);
    const DeviationSummary facets = summarize(found.at_facets);
    tell(out, "samples", samples);
    tell(out, "facets", facets);
    draw(out, found.at_facets, facets.largest());
    if (!command.table.empty()) {
        write_file(command.table, table_of(part, found, motion));
        out << "written to     " << command.table.string() << '\n';
    }
    if (!command.tolerance) return ExitCode::done;
    const bool is_within = samples.largest() <= *command.tolerance;
    const auto outside = std::ranges::count_if(found.at_samples, [&](double d) { return std::abs(d) > *command.tolerance; });
    out << (is_within ? fmt::format("within         all samples lie within {}\n", number_text(*command.tolerance, " mm"))
                      : fmt::format("OUT            {} of {} samples lie farther off than {}\n", outside, samples.count,
                                    number_text(*command.tolerance, " mm")));
    return is_within ? ExitCode::done : ExitCode::out_of_tolerance;
}

}  // namespace palpate
