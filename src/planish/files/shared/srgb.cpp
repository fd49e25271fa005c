// Based on: IEC 61966-2-1, "Default RGB colour space - sRGB", 1999.
#include "planish/files/shared/srgb.h"

#include <algorithm>
#include <cmath>

namespace planish {

double linear_of_srgb(double encoded) {
  if (encoded >= 1) return 1;
  if (encoded <= 0.04045) return std::max(encoded, 0.0) / 12.92;
  return std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_of_linear(double linear) {
  // Exactly 1, which the power below may miss by a bit.
  if (linear >= 1) return 1;
  if (linear <= 0.0031308) return 12.92 * std::max(linear, 0.0);
  return 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

glm::vec4 linear_of_srgb(const glm::dvec4& encoded) {
  return {linear_of_srgb(encoded.r), linear_of_srgb(encoded.g), linear_of_srgb(encoded.b),
          std::clamp(encoded.a, 0.0, 1.0)};
}

glm::dvec4 srgb_of_linear(const glm::vec4& linear) {
  return {srgb_of_linear(linear.r), srgb_of_linear(linear.g), srgb_of_linear(linear.b),
          std::clamp<double>(linear.a, 0.0, 1.0)};
}

}  // namespace planish
