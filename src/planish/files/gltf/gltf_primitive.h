#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/files/gltf/draco_stream.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_nodes.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/json_place.h"

namespace planish {

/// JOINTS_n and WEIGHTS_n of a primitive.
struct JointSet {
  JsonPlace place;
  GltfAccessor joints, weights;
};

/// The accessors of a primitive, whether its bytes lie plain or are packed by Draco. Where there
/// are both, the plain ones are read. Every member throws Error{UnreadableInput}.
class SourcePrimitive {
 public:
  /// Unpacks what is packed; `primitive` must have positions, and must live longer.
  SourcePrimitive(const JsonPlace& root, const JsonPlace& primitive, GltfSource& source);

  [[nodiscard]] const GltfAccessor& positions() const { return *positions_; }
  [[nodiscard]] std::optional<GltfAccessor> indices() const;
  /// Empty where there is none; else as many elements as positions.
  [[nodiscard]] std::optional<GltfAccessor> attribute(std::string_view name,
                                                      GltfAccessor::Use use) const;

  /// The accessor of a morph target's attribute: one element for each position.
  [[nodiscard]] GltfAccessor target(const JsonPlace& place, GltfAccessor::Use use) const;

  /// JOINTS_0 and WEIGHTS_0, JOINTS_1 and WEIGHTS_1 ...: four of each, for each position.
  [[nodiscard]] std::vector<JointSet> joint_sets() const;

  /// A vertex in the world.
  [[nodiscard]] glm::dvec3 position(std::int64_t vertex, const GltfInstance& instance) const;
  /// An element of the attribute COLOR_0.
  [[nodiscard]] glm::vec4 color(const GltfAccessor& colors, std::int64_t vertex) const;

 private:
  void unpack();
  [[nodiscard]] GltfAccessor accessor(const JsonPlace& place, std::string_view name,
                                      GltfAccessor::Use use) const;

  const JsonPlace& root_;
  const JsonPlace& place_;
  GltfSource& source_;
  std::optional<DracoMesh> unpacked_;
  std::map<std::string, std::int64_t, std::less<>> identifiers_;  // of packed attributes
  std::optional<GltfAccessor> positions_;
};

/// Appends the joints of a vertex that have a weight, in the order of the file. Throws
/// Error{UnreadableInput}.
void append_influences(std::span<const JointSet> sets, std::int64_t vertex,
                       std::vector<JointWeight>& to);

/// What joints make of a vertex: a mean of joint_matrices() by its weights. One without any has the
/// first joint. Throws Error{UnreadableInput}.
[[nodiscard]] glm::dmat4 posed(std::span<const JointSet> sets, std::int64_t vertex,
                               std::span<const glm::dmat4> joints);

/// A normal in the world, of any length.
[[nodiscard]] glm::dvec3 placed_normal(const glm::dvec3& normal, const GltfInstance& instance);

}  // namespace planish
