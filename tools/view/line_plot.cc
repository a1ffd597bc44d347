#include "tools/view/line_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

namespace palpate {
namespace {

// Pixels.
constexpr double kPanelWidth = 420;
constexpr double kPanelHeight = 340;
constexpr double kLeft = 78;
constexpr double kGap = 46;
constexpr double kTop = 52;
constexpr double kBottom = 58;
constexpr double kLegend = 130;

// Told apart by people who confuse red and green, too (Okabe and Ito), and by their markers in print.
constexpr std::array<const char*, 6> kColours{"#d55e00", "#0072b2", "#009e73", "#7f7f7f", "#cc79a7", "#e69f00"};

struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void add(double value) {
        low = std::min(low, std::log10(value));
        high = std::max(high, std::log10(value));
    }
    void widen() {
        if (low > high) low = high = 0;
        const double margin = std::max(0.05 * (high - low), 0.1);
        low -= margin;
        high += margin;
    }
    [[nodiscard]] double share(double value) const { return (std::log10(value) - low) / (high - low); }
};

bool is_drawn(const std::pair<double, double>& p) {
    return p.first > 0 && p.second > 0 && std::isfinite(p.first) && std::isfinite(p.second);
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
            case '&':
                result += "&amp;";
                break;
            case '<':
                result += "&lt;";
                break;
            case '>':
                result += "&gt;";
                break;
            default:
                result += c;
        }
    }
    return result;
}

// 1, 2 and 5 times powers of ten, as long as they are few.
std::vector<double> ticks(const Range& range) {
    std::vector<double> all;
    const bool few = range.high - range.low < 2.2;
    for (int decade = static_cast<int>(std::floor(range.low)); decade <= static_cast<int>(std::ceil(range.high)); ++decade) {
        for (const double digit : {1.0, 2.0, 5.0}) {
            const double tick = digit * std::pow(10.0, decade);
            if (digit > 1 && !few) continue;
            if (std::log10(tick) >= range.low && std::log10(tick) <= range.high) all.push_back(tick);
        }
    }
    return all;
}

std::string label(double value) {
    const bool has_exponent = value >= 1e5 || value < 1e-3;
    if (!has_exponent) return fmt::format("{:.6g}", value);
    const double exponent = std::floor(std::log10(value) + 1e-9);
    const double digit = value / std::pow(10.0, exponent);
    return fmt::format("{:.6g}e{}", digit > 1.5 ? digit : 1.0, static_cast<int>(exponent));
}

}  // namespace

std::string to_svg(const LinePlot& plot) {
    const std::size_t panels = plot.x_labels.size();
    Range y;
    std::vector<Range> x(panels);
    for (const PlotSeries& series : plot.series) {
        for (std::size_t panel = 0; panel < panels; ++panel) {
            for (const auto& p : series.points[panel]) {
                if (!is_drawn(p)) continue;
                x[panel].add(p.first);
                y.add(p.second);
            }
        }
    }
    y.widen();
    for (Range& range : x) range.widen();
    const double width = kLeft + static_cast<double>(panels) * (kPanelWidth + kGap) + kLegend;
    const double height = kTop + kPanelHeight + kBottom;
    std::string svg =
        fmt::format(R"svg(<svg xmlns="http://www.w3.org/2000/svg" width="{0:.6g}" height="{1:.6g}" viewBox="0 0 {0:.6g} {1:.6g}")svg"
                    R"svg( font-family="sans-serif" font-size="13">)svg"
                    "\n"
                    R"svg(<rect width="100%" height="100%" fill="white"/>)svg"
                    "\n"
                    R"svg(<text x="{2:.6g}" y="26" font-size="16">{3}</text>)svg"
                    "\n",
                    width, height, kLeft, escaped(plot.title));
    const auto draw = std::back_inserter(svg);
    for (std::size_t panel = 0; panel < panels; ++panel) {
        const double left = kLeft + static_cast<double>(panel) * (kPanelWidth + kGap);
        const auto at_x = [&](double value) { return left + kPanelWidth * x[panel].share(value); };
        const auto at_y = [&](double value) { return kTop + kPanelHeight * (1 - y.share(value)); };
        fmt::format_to(draw,
                       R"svg(<rect x="{:.6g}" y="{:.6g}" width="{:.6g}" height="{:.6g}" fill="none" stroke="#444"/>)svg"
                       "\n",
                       left, kTop, kPanelWidth, kPanelHeight);
        for (const double tick : ticks(x[panel])) {
            fmt::format_to(draw,
                           R"svg(<path d="M{0:.6g} {1:.6g}v{2:.6g}" stroke="#e4e4e4"/>)svg"
                           R"svg(<text x="{0:.6g}" y="{3:.6g}" text-anchor="middle">{4}</text>)svg"
                           "\n",
                           at_x(tick), kTop, kPanelHeight, kTop + kPanelHeight + 18, label(tick));
        }
        for (const double tick : ticks(y)) {
            fmt::format_to(draw, R"svg(<path d="M{:.6g} {:.6g}h{:.6g}" stroke="#e4e4e4"/>)svg", left, at_y(tick), kPanelWidth);
            if (panel == 0) {
                fmt::format_to(draw, R"svg(<text x="{:.6g}" y="{:.6g}" text-anchor="end">{}</text>)svg", left - 6, at_y(tick) + 4,
                               label(tick));
            }
            svg += '\n';
        }
        fmt::format_to(draw,
                       R"svg(<text x="{:.6g}" y="{:.6g}" text-anchor="middle">{}</text>)svg"
                       "\n",
                       left + kPanelWidth / 2, kTop + kPanelHeight + 42, escaped(plot.x_labels[panel]));
        for (std::size_t k = 0; k < plot.series.size(); ++k) {
            const char* const colour = kColours.at(k % kColours.size());
            std::string path;
            std::string markers;
            for (const auto& p : plot.series[k].points[panel]) {
                if (!is_drawn(p)) continue;
                path += fmt::format("{}{:.6g} {:.6g}", path.empty() ? 'M' : 'L', at_x(p.first), at_y(p.second));
                markers += fmt::format(R"svg(<circle cx="{:.6g}" cy="{:.6g}" r="3" fill="{}"/>)svg", at_x(p.first), at_y(p.second), colour);
            }
            fmt::format_to(draw,
                           R"svg(<path d="{}" fill="none" stroke="{}" stroke-width="2"/>{})svg"
                           "\n",
                           path, colour, markers);
        }
    }
    fmt::format_to(draw,
                   R"svg(<text transform="translate(18 {:.6g}) rotate(-90)" text-anchor="middle">{}</text>)svg"
                   "\n",
                   kTop + kPanelHeight / 2, escaped(plot.y_label));
    const double legend = kLeft + static_cast<double>(panels) * (kPanelWidth + kGap) - kGap + 16;
    for (std::size_t k = 0; k < plot.series.size(); ++k) {
        const double line = kTop + 14 + 24 * static_cast<double>(k);
        fmt::format_to(draw,
                       R"svg(<path d="M{:.6g} {:.6g}h26" stroke="{}" stroke-width="2"/><text x="{:.6g}" y="{:.6g}">{}</text>)svg"
                       "\n",
                       legend, line, kColours.at(k % kColours.size()), legend + 34, line + 4, escaped(plot.series[k].name));
    }
    svg += "</svg>\n";
    return svg;
}

}  // namespace palpate
