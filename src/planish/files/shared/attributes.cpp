#include "planish/files/shared/attributes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/portable_math.h"
#include "planish/core/words.h"
#include "planish/files/shared/text_lines.h"

namespace planish {
namespace {

// What a vertex without a colour holds until the end; colours are not negative.
constexpr glm::vec4 kNoColor(-1.0f);
constexpr glm::vec4 kWhite(1.0f);

}  // namespace

void AttributeCollector::use_group(FaceGroup group) {
  group_ = std::move(group);
  group_index_ = -1;
}

std::int32_t AttributeCollector::group_index() {
  if (group_index_ < 0) group_index_ = groups_.index_of(group_);
  return group_index_;
}

void AttributeCollector::add_corner(std::int32_t uv) {
  if (uv >= 0 || !face_uvs_.empty()) {
    face_uvs_.resize(corner_count_, -1);
    face_uvs_.push_back(uv);
  }
  ++corner_count_;
}

void AttributeCollector::add_faces(std::size_t count) {
  if (count == 0) return;
  const bool is_named = !group_.name.empty() || !group_.material.empty();
  if (is_named && face_groups_.empty() && face_count_ > 0) {
    const FaceGroup named = std::exchange(group_, {});
    face_groups_.assign(face_count_, group_index());
    use_group(named);
  }
  if (is_named || !face_groups_.empty()) face_groups_.resize(face_count_ + count, group_index());
  face_count_ += count;
}

bool AttributeCollector::color_vertex(std::int32_t vertex, const glm::vec4& color) {
  const auto slot = static_cast<std::size_t>(vertex);
  if (colors_.size() <= slot) colors_.resize(slot + 1, kNoColor);
  if (colors_[slot] == kNoColor) colors_[slot] = color;
  return colors_[slot] == color;
}

void AttributeCollector::finish(std::vector<glm::dvec2> uvs, PolygonMesh& mesh) {
  if (!face_uvs_.empty()) mesh.uvs = std::move(uvs);
  mesh.face_uvs = std::move(face_uvs_);
  if (!colors_.empty()) {
    colors_.resize(mesh.positions.size(), kNoColor);
    std::replace(colors_.begin(), colors_.end(), kNoColor, kWhite);
    mesh.colors = std::move(colors_);
  }
  mesh.groups = groups_.take();
  mesh.face_groups = std::move(face_groups_);
}

namespace {

// Based on: IEC 61966-2-1, "Default RGB colour space - sRGB", 1999.

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
  return portable::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_of_linear(double linear) {
  // Exactly 1, which the power below may miss by a bit.
  if (linear >= 1) return 1;
  if (linear <= 0.0031308) return 12.92 * std::max(linear, 0.0);
  return 1.055 * portable::pow(linear, 1 / 2.4) - 0.055;
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

std::string identifier_of(const std::string& name) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string plain = name.empty() || is_digit(name.front()) ? "_" : "";
  for (const char c : name) {
    const bool is_plain = is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    plain += is_plain ? c : '_';
  }
  return plain;
}

namespace {

constexpr std::size_t kMostNameBytes = 64;
// Names of USD, which knows the others apart by their case.
constexpr std::array<std::string_view, 3> kTakenNames = {"st", "displaycolor", "displayopacity"};

}  // namespace

PropertyNames::PropertyNames() : taken_(kTakenNames.begin(), kTakenNames.end()) {
  for (const KnownProperty& known : kKnownProperties) taken_.emplace(known.name);
}

bool PropertyNames::add(const std::string& given) {
  std::string name = identifier_of(given);
  if (names_.size() < kMaxProperties && name.size() <= kMostNameBytes &&
      taken_.insert(lower_case(name)).second) {
    names_.push_back(std::move(name));
    return true;
  }
  if (left_out_count_++ == 0) left_out_ = given;
  return false;
}

void PropertyNames::warn(std::vector<Warning>& warnings, std::string_view file,
                         std::string_view elements) const {
  if (left_out_count_ == 0) return;
  warnings.push_back(
      {.code = "left-out-properties",
       .message =
           formatted("{}: property {} of the {} is left out{}; {} are read, of names of their own, "
                     "whatever their case",
                     file, quote(left_out_), elements,
                     left_out_count_ > 1 ? formatted(", and {} more", left_out_count_ - 1) : "",
                     kMaxProperties),
       .count = left_out_count_});
}

}  // namespace planish
