// Based on: IEC 61966-2-1, "Default RGB colour space - sRGB", 1999.
#include "planish/files/shared/srgb.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"

namespace planish {
namespace {

// Numbers up to 1 that are rounded, or of light beyond white, end before; bytes of a picture that
// is not black do not.
constexpr float kLeastOfBytes = 2, kMostOfBytes = 255;

float most_of(std::span<const glm::vec4> colors, int first, int last) {
  float most = 0;
  for (const glm::vec4& color : colors)
    for (int c = first; c <= last; ++c)
      if (std::isfinite(color[c])) most = std::max(most, color[c]);
  return most;
}

bool are_whole(std::span<const glm::vec4> colors) {
  for (const glm::vec4& color : colors)
    for (int c = 0; c < 3; ++c)
      if (std::isfinite(color[c]) && color[c] != std::floor(color[c])) return false;
  return true;
}

}  // namespace

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

void settle_colors(std::span<glm::vec4> colors, std::string_view file, bool whole_is_usual,
                   std::vector<Warning>& warnings) {
  const float most = most_of(colors, 0, 2);
  const float scale = most >= kLeastOfBytes ? kMostOfBytes : 1;
  const float alpha_scale = most_of(colors, 3, 3) >= kLeastOfBytes ? kMostOfBytes : 1;
  if (scale > 1 && !(whole_is_usual && are_whole(colors)))
    warnings.push_back(
        {.code = "color-range",
         .message = formatted("{}: colours are numbers up to {}, and are taken as from 0 to 255; "
                              "from 0 to 1, or integers, need no guess",
                              file, short_number(most))});
  std::int64_t clamped = 0;
  for (glm::vec4& color : colors) {
    const glm::vec4 share = color / glm::vec4(scale, scale, scale, alpha_scale);
    bool is_number = true, is_outside = false;
    for (int c = 0; c < 4; ++c) {
      is_number = is_number && std::isfinite(share[c]);
      is_outside = is_outside || share[c] < 0 || share[c] > 1;
    }
    if (is_number && is_outside) ++clamped;
    color = is_number ? linear_of_srgb(glm::dvec4(share)) : glm::vec4(1.0f);
  }
  if (clamped > 0)
    warnings.push_back({.code = "clamped-colors",
                        .message = counted(clamped, "vertex colour") +
                                   (clamped == 1 ? " lies outside 0 to 1 and is clamped"
                                                 : " lie outside 0 to 1 and are clamped"),
                        .count = clamped});
}

}  // namespace planish
