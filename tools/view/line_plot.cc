#include "tools/view/line_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

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
    std::ostringstream text;
    if (value >= 1e5 || value < 1e-3) {
        text << "1e" << static_cast<int>(std::floor(std::log10(value) + 1e-9));
        if (const double digit = value / std::pow(10.0, std::floor(std::log10(value) + 1e-9)); digit > 1.5) {
            text.str("");
            text << digit << "e" << static_cast<int>(std::floor(std::log10(value) + 1e-9));
        }
    } else {
        text << value;
    }
    return text.str();
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
    std::ostringstream svg;
    svg.precision(6);
    svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height << "\" viewBox=\"0 0 " << width << ' '
        << height << "\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\""
        << kLeft << "\" y=\"26\" font-size=\"16\">" << escaped(plot.title) << "</text>\n";
    for (std::size_t panel = 0; panel < panels; ++panel) {
        const double left = kLeft + static_cast<double>(panel) * (kPanelWidth + kGap);
        const auto at_x = [&](double value) { return left + kPanelWidth * x[panel].share(value); };
        const auto at_y = [&](double value) { return kTop + kPanelHeight * (1 - y.share(value)); };
        svg << "<rect x=\"" << left << "\" y=\"" << kTop << "\" width=\"" << kPanelWidth << "\" height=\"" << kPanelHeight
            << "\" fill=\"none\" stroke=\"#444\"/>\n";
        for (const double tick : ticks(x[panel])) {
            svg << "<path d=\"M" << at_x(tick) << ' ' << kTop << "v" << kPanelHeight << "\" stroke=\"#e4e4e4\"/><text x=\"" << at_x(tick)
                << "\" y=\"" << kTop + kPanelHeight + 18 << "\" text-anchor=\"middle\">" << label(tick) << "</text>\n";
        }
        for (const double tick : ticks(y)) {
            svg << "<path d=\"M" << left << ' ' << at_y(tick) << "h" << kPanelWidth << "\" stroke=\"#e4e4e4\"/>";
            if (panel == 0)
                svg << "<text x=\"" << left - 6 << "\" y=\"" << at_y(tick) + 4 << "\" text-anchor=\"end\">" << label(tick) << "</text>";
            svg << '\n';
        }
        svg << "<text x=\"" << left + kPanelWidth / 2 << "\" y=\"" << kTop + kPanelHeight + 42 << "\" text-anchor=\"middle\">"
            << escaped(plot.x_labels[panel]) << "</text>\n";
        for (std::size_t k = 0; k < plot.series.size(); ++k) {
            const char* const colour = kColours.at(k % kColours.size());
            std::ostringstream path;
            path.precision(6);
            std::ostringstream markers;
            markers.precision(6);
            for (const auto& p : plot.series[k].points[panel]) {
                if (!is_drawn(p)) continue;
                path << (path.str().empty() ? 'M' : 'L') << at_x(p.first) << ' ' << at_y(p.second);
                markers << "<circle cx=\"" << at_x(p.first) << "\" cy=\"" << at_y(p.second) << "\" r=\"3\" fill=\"" << colour << "\"/>";
            }
            svg << "<path d=\"" << path.str() << "\" fill=\"none\" stroke=\"" << colour << "\" stroke-width=\"2\"/>" << markers.str()
                << '\n';
        }
    }
    svg << "<text transform=\"translate(18 " << kTop + kPanelHeight / 2 << ") rotate(-90)\" text-anchor=\"middle\">"
        << escaped(plot.y_label) << "</text>\n";
    const double legend = kLeft + static_cast<double>(panels) * (kPanelWidth + kGap) - kGap + 16;
    for (std::size_t k = 0; k < plot.series.size(); ++k) {
        const double line = kTop + 14 + 24 * static_cast<double>(k);
        svg << "<path d=\"M" << legend << ' ' << line << "h26\" stroke=\"" << kColours.at(k % kColours.size())
            << "\" stroke-width=\"2\"/><text x=\"" << legend + 34 << "\" y=\"" << line + 4 << "\">" << escaped(plot.series[k].name)
            << "</text>\n";
    }
    svg << "</svg>\n";
    return svg.str();
}

}  // namespace palpate
