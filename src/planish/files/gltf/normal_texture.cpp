// Based on: Khronos Group, "glTF 2.0 Specification", sections 3.8 (textures, samplers) and 3.9.3
// (normal textures); KHR_texture_transform; KHR_materials_clearcoat.
#include "planish/files/gltf/normal_texture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "planish/core/json.h"
#include "planish/core/unit_vector.h"
#include "planish/files/gltf/json_values.h"

namespace planish {
namespace {

using nlohmann::json;

constexpr int kMirroredRepeat = 33648, kRepeat = 10497;

// Of a texel outside of an image, the one inside that stands for it.
int wrapped(std::int64_t texel, int size, int wrap) {
  if (wrap == kClampToEdge) return static_cast<int>(std::clamp<std::int64_t>(texel, 0, size - 1));
  const std::int64_t period = wrap == kMirroredRepeat ? 2 * std::int64_t{size} : size;
  const std::int64_t inside = ((texel % period) + period) % period;
  return static_cast<int>(inside < size ? inside : period - 1 - inside);
}

const json& normal_texture_of(const json& lists, const json& material) {
  return json_at(lists, "textures", json_at(json_at(material, "normalTexture"), "index"));
}

}  // namespace

std::int64_t normal_image(const json& lists, const json& material) {
  const json& source = json_at(normal_texture_of(lists, material), "source");
  return source.is_number_integer() ? source.get<std::int64_t>() : -1;
}

NormalTexture::NormalTexture(RgbImage image, const json& lists, const json& material)
    : image_(std::move(image)), wraps_{kRepeat, kRepeat} {
  const json& info = json_at(material, "normalTexture");
  scale_ = number_at(json_at(info, "scale"), 1);
  const json& moved = json_at(json_at(info, "extensions"), "KHR_texture_transform");
  rotation_ = number_at(json_at(moved, "rotation"), 0);
  const JsonNumbers offset = values_of(json_at(moved, "offset"), {0, 0});
  const JsonNumbers stretch = values_of(json_at(moved, "scale"), {1, 1});
  offset_ = {offset[0], offset[1]};
  stretch_ = {stretch[0], stretch[1]};
  const json& sampler =
      json_at(lists, "samplers", json_at(normal_texture_of(lists, material), "sampler"));
  wraps_[0] = static_cast<int>(number_at(json_at(sampler, "wrapS"), kRepeat));
  wraps_[1] = static_cast<int>(number_at(json_at(sampler, "wrapT"), kRepeat));
}

glm::dvec3 NormalTexture::at(const glm::dvec2& uv) const {
  const glm::dvec2 given(uv.x * stretch_.x, (1 - uv.y) * stretch_.y);
  const double c = std::cos(rotation_), s = std::sin(rotation_);
  const glm::dvec2 place(c * given.x + s * given.y + offset_.x,
                         c * given.y - s * given.x + offset_.y);
  // Farther, texels of a texture that repeats are told apart no more.
  constexpr double kFarthest = 1e15;
  const auto texels_of = [&](double coordinate, int size) {
    return std::clamp(coordinate * size - 0.5, -kFarthest, kFarthest);
  };
  const double x = texels_of(place.x, image_.width), y = texels_of(place.y, image_.height);
  const double left = std::floor(x), top = std::floor(y);
  glm::dvec3 sum(0.0);
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double weight =
          (i == 0 ? 1 - (x - left) : x - left) * (j == 0 ? 1 - (y - top) : y - top);
      const std::uint8_t* texel =
          image_.at(wrapped(static_cast<std::int64_t>(left) + i, image_.width, wraps_[0]),
                    wrapped(static_cast<std::int64_t>(top) + j, image_.height, wraps_[1]));
      sum += weight * (glm::dvec3(texel[0], texel[1], texel[2]) / 127.5 - 1.0);
    }
  return unit_or_zero({scale_ * sum.x, scale_ * sum.y, sum.z});
}

void set_normal_texture(json& lists, json& material, std::int64_t image, int set) {
  json& textures = lists["textures"];
  json texture{{"index", textures.size()}};
  if (set > 0) texture["texCoord"] = set;
  textures.push_back({{"source", image}});
  material["normalTexture"] = texture;
  if (const auto extensions = material.find("extensions"); extensions != material.end())
    if (const auto coat = extensions->find("KHR_materials_clearcoat"); coat != extensions->end())
      coat->emplace("clearcoatNormalTexture", texture);
}

}  // namespace planish
