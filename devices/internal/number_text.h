// Numbers as text that reads back to the same bits.
#pragma once

#include <string>

#include "planner/geometry.h"

namespace palpate {

// Shortest digits. Negative zero is "-0.0", which readers of JSON do not take for the integer 0.
void append_number(std::string& text, double x);
[[nodiscard]] std::string number_text(double x, const char* unit = "");
// "(1, 2.5, 3)".
[[nodiscard]] std::string place_text(const Point& p);

}  // namespace palpate
