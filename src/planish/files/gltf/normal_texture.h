#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "planish/core/json_fwd.h"
#include "planish/files/image/read_image.h"

namespace planish {

/// The image of a material's normal texture, by its number; -1: it has none, or none but in a
/// format of an extension. `lists`: a document, or GltfMaterials::lists.
[[nodiscard]] std::int64_t normal_image(const nlohmann::json& lists,
                                        const nlohmann::json& material);

/// A material's normal texture, to be read at any place: with its scale, KHR_texture_transform, and
/// how its sampler wraps; between texels it is linear.
class NormalTexture {
 public:
  /// `material` has one.
  NormalTexture(RgbImage image, const nlohmann::json& lists, const nlohmann::json& material);

  /// x to the right, y upwards, z outwards; unit. `uv`: v runs upwards.
  [[nodiscard]] glm::dvec3 at(const glm::dvec2& uv) const;

 private:
  RgbImage image_;
  double scale_ = 1, rotation_ = 0;
  glm::dvec2 offset_{0.0}, stretch_{1.0};
  std::array<int, 2> wraps_;
};

/// Gives a material the normal texture of an image, in its coordinates of that set, in the place of
/// what it has; and to a clear coat that has none of its own. The texture is added to `lists`.
void set_normal_texture(nlohmann::json& lists, nlohmann::json& material, std::int64_t image,
                        int set);

}  // namespace planish
