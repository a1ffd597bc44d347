#include "tools/reliability.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "tools/view/line_plot.h"

namespace palpate {
namespace {

constexpr std::array kEdges{0.0, 0.0002, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 1.0};

double found(const ReliabilityBin& bin) { return static_cast<double>(bin.wrong) / static_cast<double>(bin.facets); }

}  // namespace

std::vector<ReliabilityBin> measure_reliability(std::span<const BenchRow> rows) {
    std::vector<ReliabilityBin> bins;
    for (std::size_t k = 0; k + 1 < kEdges.size(); ++k) bins.push_back({kEdges[k], kEdges[k + 1], 0, 0, 0, 0});
    for (const BenchRow& row : rows) {
        const Result& result = row.run.result;
        for (std::size_t t = 0; t < result.confidences.size(); ++t) {
            const double chance = 1 - result.confidences[t];
            if (!(chance > 0)) continue;
            ReliabilityBin& bin =
                *std::ranges::find_if(bins, [&](const ReliabilityBin& b) { return chance < b.to || b.to == kEdges.back(); });
            ++bin.facets;
            bin.stated += chance;
            bin.wrong += row.run.verdicts[t] == FacetVerdict::wrong ? 1 : 0;
            bin.flips += row.run.verdicts[t] == FacetVerdict::flip ? 1 : 0;
        }
    }
    std::erase_if(bins, [](const ReliabilityBin& bin) { return bin.facets == 0; });
    for (ReliabilityBin& bin : bins) bin.stated /= static_cast<double>(bin.facets);
    return bins;
}

std::string reliability_table(const std::vector<ReliabilityBin>& bins) {
    std::string text = "| likely wrong, as stated | facets | wrong | flips |\n|---|---:|---:|---:|\n";
    for (const ReliabilityBin& bin : bins) {
        text += fmt::format("| {:g} to {:g} %, mean {:.2g} % | {} | {} = {:.2g} % | {} |\n", 100 * bin.from, 100 * bin.to, 100 * bin.stated,
                            bin.facets, bin.wrong, 100 * found(bin), bin.flips);
    }
    return text;
}

std::string reliability_csv(const std::vector<ReliabilityBin>& bins) {
    std::string text = "from,to,facets,stated,wrong,flips\n";
    for (const ReliabilityBin& b : bins)
        text += fmt::format("{:.10g},{:.10g},{},{:.10g},{},{}\n", b.from, b.to, b.facets, b.stated, b.wrong, b.flips);
    return text;
}

std::string reliability_svg(const std::vector<ReliabilityBin>& bins) {
    LinePlot plot;
    plot.title = "Plausible facets: stated and found";
    plot.x_labels = {"share that is stated to be wrong"};
    plot.y_label = "share that is wrong";
    plot.series = {{"found", {{}}}, {"as stated", {{}}}};
    for (const ReliabilityBin& bin : bins) {
        plot.series[0].points[0].emplace_back(bin.stated, found(bin));
        plot.series[1].points[0].emplace_back(bin.stated, bin.stated);
    }
    return to_svg(plot);
}

}  // namespace palpate
