#include "tools/view/line_plot.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace palpate::line_plot_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
}

// The centres of the markers.
std::vector<std::pair<double, double>> markers(const std::string& svg) {
    std::vector<std::pair<double, double>> all;
    for (std::size_t at = svg.find("<circle cx=\""); at != std::string::npos; at = svg.find("<circle cx=\"", at + 1)) {
        double x = 0;
        double y = 0;
        EXPECT_EQ(std::sscanf(svg.c_str() + at, "<circle cx=\"%lf\" cy=\"%lf\"", &x, &y), 2);
        all.emplace_back(x, y);
    }
    return all;
}

TEST(LinePlot, DrawsEveryPointThatALogarithmHas) {
    const double infinity = std::numeric_limits<double>::infinity();
    const LinePlot plot{"a < b & c",
                        "error",
                        {"n", "m"},
                        {{"one", {{{1, 10}, {10, 1}, {100, 0.1}}, {{5, 10}, {0, 1}, {-1, 1}}}},
                         {"two", {{{1, infinity}}, {{50, std::nan("")}, {50, 0.1}}}}}};
    const std::string svg = to_svg(plot);
    EXPECT_EQ(markers(svg).size(), 5U);
    EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; c"));
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
    EXPECT_EQ(count(svg, "<svg"), 1U);
    EXPECT_EQ(count(svg, "</svg>"), 1U);
    EXPECT_EQ(count(svg, "<text"), count(svg, "</text>"));
    // Logarithmic: equal steps for equal factors, larger errors higher up.
    const auto at = markers(svg);
    EXPECT_NEAR(at[1].first - at[0].first, at[2].first - at[1].first, 0.01);
    EXPECT_NEAR(at[1].second - at[0].second, at[2].second - at[1].second, 0.01);
    EXPECT_LT(at[0].second, at[1].second);
}

TEST(LinePlot, AnEmptyPlotIsStillAPlot) {
    const std::string svg = to_svg({"nothing", "y", {"x"}, {{"none", {{}}}}});
    EXPECT_TRUE(markers(svg).empty());
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_EQ(count(svg, "</svg>"), 1U);
}

}  // namespace
}  // namespace palpate::line_plot_test
