#include "planner/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace palpate::number_text_test {
namespace {

constexpr double kMax = std::numeric_limits<double>::max();

TEST(NumberText, ReadsBackToTheSameBits) {
    for (const double x : {0.0, -0.0, 0.1, 1.0 / 3.0, -1e-320, kMax, -kMax, 123456789.125}) {
        const std::string text = number_text(x);
        const double back = std::strtod(text.c_str(), nullptr);
        EXPECT_EQ(back, x) << text;
        EXPECT_EQ(std::signbit(back), std::signbit(x)) << text;
    }
    EXPECT_EQ(number_text(0.1, " mm"), "0.1 mm");
    EXPECT_EQ(number_text(-0.0), "-0.0");
}

TEST(PointText, ShowsMicrometresAndAnythingElse) {
    EXPECT_EQ(point_text({1, 2.5, -3}), "(1, 2.5, -3) mm");
    EXPECT_EQ(point_text({0.1 + 0.2, -1234.5674, 0}), "(0.3, -1234.567, 0) mm");
    EXPECT_EQ(point_text({-1.2345678e-308, -kMax, std::numeric_limits<double>::quiet_NaN()}), "(-1.234568e-308, -1.797693e+308, nan) mm");
}

}  // namespace
}  // namespace palpate::number_text_test
