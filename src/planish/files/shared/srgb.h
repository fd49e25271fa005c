#pragma once

#include <glm/vec4.hpp>

namespace planish {

/// The sRGB transfer function and its inverse, 0 to 1 on both sides; what lies outside is clamped.
[[nodiscard]] double linear_of_srgb(double encoded);
[[nodiscard]] double srgb_of_linear(double linear);

/// Linear RGBA of sRGB colour with its (always linear) alpha.
[[nodiscard]] glm::vec4 linear_of_srgb(const glm::dvec4& encoded);
[[nodiscard]] glm::dvec4 srgb_of_linear(const glm::vec4& linear);

}  // namespace planish
