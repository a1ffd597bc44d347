// A plot of lines over logarithmic axes, as SVG: panels side by side that share their series and their y axis.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace palpate {

struct PlotSeries {
    std::string name;
    std::vector<std::vector<std::pair<double, double>>> points;  // by panel: (x, y), both positive; others are left out
};

struct LinePlot {
    std::string title;
    std::string y_label;
    std::vector<std::string> x_labels;  // one panel for each
    std::vector<PlotSeries> series;
};

[[nodiscard]] std::string to_svg(const LinePlot& plot);

}  // namespace palpate
