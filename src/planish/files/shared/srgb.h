#pragma once

#include <glm/vec4.hpp>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

/// The sRGB transfer function and its inverse, 0 to 1 on both sides; what lies outside is clamped.
[[nodiscard]] double linear_of_srgb(double encoded);
[[nodiscard]] double srgb_of_linear(double linear);

/// Linear RGBA of sRGB colour with its (always linear) alpha.
[[nodiscard]] glm::vec4 linear_of_srgb(const glm::dvec4& encoded);
[[nodiscard]] glm::dvec4 srgb_of_linear(const glm::vec4& linear);

/// Makes linear colours of the numbers of a file that does not say what they go up to: sRGB from 0
/// to 1; from 0 to 255 where one is 2 or more, with the warning "color-range" unless whole numbers
/// are usual and all are. Alpha, linear, for itself. What lies outside is clamped, with the warning
/// "clamped-colors"; a colour that is no number becomes white.
void settle_colors(std::span<glm::vec4> colors, std::string_view file, bool whole_is_usual,
                   std::vector<Warning>& warnings);

}  // namespace planish
