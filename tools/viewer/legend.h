#pragma once

#include <cstdint>
#include <string>

#include "planish/fair/interpolation_method.h"

namespace planish::viewer {

/// Draws the scale of the error colours, with a number at each decade and a line of text below, in
/// the lower left corner; between Overlay::begin() and record().
void draw_legend(const std::string& line);

/// "1.2e-05", the text of an error relative to the diagonal.
[[nodiscard]] std::string error_text(double relative_error);

/// "1 iteration", "2 iterations"; "the fair method", which has none.
[[nodiscard]] std::string solve_text(InterpolationMethod method, std::uint32_t iterations);

}  // namespace planish::viewer
