// Numbers and points as text, independent of the locale.
#pragma once

#include <string>

#include "planner/geometry.h"

namespace palpate {

// Shortest digits that read back to the same bits. Negative zero is "-0.0", which readers of JSON do not take for the integer 0.
void append_number(std::string& text, double x);
[[nodiscard]] std::string number_text(double x, const char* unit = "");

// "(1, 2.5, 3) mm", for people: seven digits are a micrometre within ten metres.
[[nodiscard]] std::string point_text(const Point& p);

}  // namespace palpate
