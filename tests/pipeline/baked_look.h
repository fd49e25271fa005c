#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "files/gltf/parsed_gltf.h"
#include "planish/files/images.h"

namespace planish::test {

inline double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  const double cosine = glm::dot(a, b) / std::sqrt(glm::dot(a, a) * glm::dot(b, b));
  return glm::degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
}

/// A primitive of a GLB as a renderer shows it, with its normal texture: see glTF 2.0,
/// section 3.9.3.
class BakedLook {
 public:
  struct Place {
    glm::dvec3 position{0.0}, shown{0.0}, interpolated{0.0}, texel{0.0};
    double sign = 0;
  };

  explicit BakedLook(const tinygltf::Model& model, std::size_t mesh = 0, std::size_t primitive = 0)
      : model_(model), primitive_(model.meshes.at(mesh).primitives.at(primitive)) {
    const tinygltf::Material& material =
        model.materials.at(static_cast<std::size_t>(primitive_.material));
    const auto texture = static_cast<std::size_t>(material.normalTexture.index);
    const auto set = std::to_string(material.normalTexture.texCoord);
    const auto image = static_cast<std::size_t>(model.textures.at(texture).source);
    const auto& view =
        model.bufferViews.at(static_cast<std::size_t>(model.images.at(image).bufferView));
    const auto* bytes =
        reinterpret_cast<const std::byte*>(model.buffers.at(0).data.data()) + view.byteOffset;
    image_ = read_image({bytes, view.byteLength}).value();
    positions_ = floats("POSITION", 3), normals_ = floats("NORMAL", 3);
    tangents_ = floats("TANGENT", 4), uvs_ = floats("TEXCOORD_" + set, 2);
    const auto& accessor = model.accessors.at(static_cast<std::size_t>(primitive_.indices));
    const auto& indices = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    const bool is_short = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    for (std::size_t i = 0; i < accessor.count; ++i) {
      std::uint32_t index = 0;
      std::memcpy(&index,
                  model.buffers.at(0).data.data() + indices.byteOffset + i * (is_short ? 2 : 4),
                  is_short ? 2 : 4);
      indices_.push_back(index);
    }
  }

  [[nodiscard]] const RgbImage& image() const { return image_; }
  [[nodiscard]] std::size_t triangle_count() const { return indices_.size() / 3; }
  [[nodiscard]] const std::vector<float>& tangents() const { return tangents_; }

  /// What triangle t shows at a place of it, with the mean of `box` x `box` texels for one.
  [[nodiscard]] Place at(std::size_t t, const glm::dvec3& weights, int box = 1) const {
    Place place;
    glm::dvec3 tangent(0.0);
    glm::dvec2 uv(0.0);
    for (int k = 0; k < 3; ++k) {
      const std::size_t v = indices_[3 * t + static_cast<std::size_t>(k)];
      for (int axis = 0; axis < 3; ++axis) {
        const auto of = [&](const std::vector<float>& rows, std::size_t width) {
          return weights[k] * rows[width * v + static_cast<std::size_t>(axis)];
        };
        place.position[axis] += of(positions_, 3);
        place.interpolated[axis] += of(normals_, 3);
        tangent[axis] += of(tangents_, 4);
        if (axis < 2) uv[axis] += of(uvs_, 2);
      }
      place.sign += weights[k] * tangents_[4 * v + 3];
    }
    place.texel = texel_at(uv, box);
    const glm::dvec3 bitangent =
        (place.sign < 0 ? -1.0 : 1.0) * glm::cross(place.interpolated, tangent);
    place.shown = glm::normalize(place.texel.x * tangent + place.texel.y * bitangent +
                                 place.texel.z * place.interpolated);
    place.interpolated = glm::normalize(place.interpolated);
    return place;
  }
  /// At texture coordinates whose v runs upwards, on the triangle that is there and is next to a
  /// point; empty: there is none.
  [[nodiscard]] std::optional<Place> at(const glm::dvec2& uv, const glm::dvec3& near,
                                        int box = 1) const {
    std::optional<Place> best;
    for (std::size_t t = 0; t < triangle_count(); ++t) {
      std::array<glm::dvec2, 3> c;
      for (std::size_t k = 0; k < 3; ++k)
        c[k] = {uvs_[2 * indices_[3 * t + k]], 1 - uvs_[2 * indices_[3 * t + k] + 1]};
      const auto twice = [](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
        return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
      };
      const glm::dvec3 weights =
          glm::dvec3(twice(c[1], c[2], uv), twice(c[2], c[0], uv), twice(c[0], c[1], uv)) /
          twice(c[0], c[1], c[2]);
      constexpr double kRounding = 1e-6;
      if (!(std::min({weights.x, weights.y, weights.z}) >= -kRounding)) continue;
      const Place place = at(t, weights, box);
      if (!best || glm::length(place.position - near) < glm::length(best->position - near))
        best = place;
    }
    return best;
  }

 private:
  [[nodiscard]] std::vector<float> floats(const std::string& name, std::size_t width) const {
    const auto& accessor =
        model_.accessors.at(static_cast<std::size_t>(primitive_.attributes.at(name)));
    const auto& view = model_.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT) << name;
    std::vector<float> values(width * accessor.count);
    std::memcpy(values.data(),
                model_.buffers.at(0).data.data() + view.byteOffset + accessor.byteOffset,
                sizeof(float) * values.size());
    return values;
  }

  // Bilinear, by glTF's coordinates; the texture repeats.
  [[nodiscard]] glm::dvec3 texel_at(const glm::dvec2& uv, int box) const {
    const int width = image_.width / box, height = image_.height / box;
    const double x = uv.x * width - 0.5, y = uv.y * height - 0.5;
    glm::dvec3 sum(0.0);
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const int left = static_cast<int>(std::floor(x)) + i,
                  top = static_cast<int>(std::floor(y)) + j;
        const double weight = (i == 0 ? 1 - (x - std::floor(x)) : x - std::floor(x)) *
                              (j == 0 ? 1 - (y - std::floor(y)) : y - std::floor(y));
        for (int dy = 0; dy < box; ++dy)
          for (int dx = 0; dx < box; ++dx) {
            const std::uint8_t* rgb =
                image_.at((left + width) % width * box + dx, (top + height) % height * box + dy);
            sum += weight / (box * box) * (glm::dvec3(rgb[0], rgb[1], rgb[2]) / 127.5 - 1.0);
          }
      }
    return sum;
  }

  const tinygltf::Model& model_;
  const tinygltf::Primitive& primitive_;
  RgbImage image_;
  std::vector<float> positions_, normals_, tangents_, uvs_;
  std::vector<std::uint32_t> indices_;
};

}  // namespace planish::test
