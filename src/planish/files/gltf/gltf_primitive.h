#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <string_view>

#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_nodes.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/json_place.h"

namespace planish {

/// The accessors of a primitive. Every member throws Error{UnreadableInput}.
class SourcePrimitive {
 public:
  /// `primitive` must have positions, and must live longer.
  SourcePrimitive(const JsonPlace& root, const JsonPlace& primitive, GltfSource& source);

  [[nodiscard]] const GltfAccessor& positions() const { return *positions_; }
  [[nodiscard]] std::optional<GltfAccessor> indices() const;
  /// Empty where there is none; else as many elements as positions.
  [[nodiscard]] std::optional<GltfAccessor> attribute(std::string_view name,
                                                      GltfAccessor::Use use) const;

  /// A vertex in the world.
  [[nodiscard]] glm::dvec3 position(std::int64_t vertex, const GltfInstance& instance) const;
  /// An element of the attribute COLOR_0.
  [[nodiscard]] glm::vec4 color(const GltfAccessor& colors, std::int64_t vertex) const;

 private:

  const JsonPlace& root_;
  const JsonPlace& place_;
  GltfSource& source_;
  std::optional<GltfAccessor> positions_;
};

/// A normal in the world, of any length.
[[nodiscard]] glm::dvec3 placed_normal(const glm::dvec3& normal, const GltfInstance& instance);

}  // namespace planish
