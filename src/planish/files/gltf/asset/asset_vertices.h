#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

/// A primitive on faces that a group has already, as of a decal: a further material on them.
struct AssetLayer {
  std::int64_t primitive = 0;  ///< in the mesh
  int depth = 0;               ///< 1: on the group itself, 2: on layers of depth 1 ...
  int uv_sets = 0;             ///< of texture coordinates
  int first_uv_set = 0;        ///< that of the mesh which is its TEXCOORD_0
  int tangent_set = -1;        ///< of the mesh's, whose tangents it has; -1: none
};

/// A part of a mesh with one material: primitives that differ in their vertices only.
struct AssetGroup {
  std::int64_t primitive = 0;  ///< the first of them, in the mesh
  int uv_sets = 0;             ///< of texture coordinates
  int tangent_set = -1;        ///< of those, whose tangents it has; -1: none
  std::vector<AssetLayer> layers{};

  /// Sets of the mesh up to the last that it or a layer has.
  [[nodiscard]] int mesh_uv_sets() const {
    int sets = uv_sets;
    for (const AssetLayer& layer : layers)
      if (layer.uv_sets > 0) sets = std::max(sets, layer.first_uv_set + layer.uv_sets);
    return sets;
  }
  [[nodiscard]] const AssetLayer* layer(int depth) const {
    const auto found = std::ranges::find(layers, depth, &AssetLayer::depth);
    return found == layers.end() ? nullptr : &*found;
  }
  /// Sets that the layer of a depth has, or with 0 the group itself.
  [[nodiscard]] int uv_sets_at(int depth) const {
    if (depth == 0) return uv_sets;
    const AssetLayer* const found = layer(depth);
    return found == nullptr ? 0 : found->uv_sets;
  }
  /// The set whose tangents the layer of a depth has, or with 0 the group itself; -1: none.
  [[nodiscard]] int tangent_set_at(int depth) const {
    if (depth == 0) return tangent_set;
    const AssetLayer* const found = layer(depth);
    return found == nullptr ? -1 : found->tangent_set;
  }
};

/// Numbers of each vertex, on the surface as colours are; where vertices at one place differ, of
/// each corner instead, where texture coordinates are.
struct AssetArray {
  std::string name;  ///< "COLOR_1", "_TEMPERATURE", "target/0/COLOR_0"
  int width = 1;
  std::vector<float> values;  ///< `width` for each vertex
  /// Numbers of things ("_FEATURE_ID_0"): between vertices there is the nearest one's.
  bool is_of_things = false;
  bool is_integer = false;  ///< without a sign, below 2^16
  /// `width` for each of PolygonMesh::uvs instead, whose indices corners have.
  bool of_corners = false;
  int layer = 0;  ///< depth of the layers that have it; 0: groups have it

  /// What a primitive without the array has, and the fourth number of a colour of three.
  [[nodiscard]] float missing() const { return name.starts_with("COLOR_") ? 1.0f : 0.0f; }
};

/// How far a morph target takes texture coordinates, as the file has them.
struct AssetUvMoves {
  std::string name;                ///< "target/0/TEXCOORD_0"
  int set = 0;                     ///< of texture coordinates
  std::vector<glm::dvec2> values;  ///< as many as PolygonMesh::uvs
  int layer = 0;                   ///< as of AssetArray
};

/// How far a joint takes a vertex along.
struct JointWeight {
  std::int32_t joint;
  float weight;
  friend bool operator==(const JointWeight&, const JointWeight&) = default;
};

/// "layer/2/COLOR_0" of layers of depth 2; of groups, which have depth 0, the name itself.
[[nodiscard]] inline std::string layer_name(int depth, const std::string& attribute) {
  return depth == 0 ? attribute : "layer/" + std::to_string(depth) + "/" + attribute;
}

/// What a mesh of an asset has besides a PolygonMesh, by the vertices and groups of that.
struct AssetVertices {
  std::vector<AssetGroup> groups;
  /// TEXCOORD_1, TEXCOORD_2 ...: as many as PolygonMesh::uvs, whose indices they have.
  std::vector<std::vector<glm::dvec2>> further_uvs;
  std::vector<AssetUvMoves> uv_moves;
  std::vector<AssetArray> arrays;
  /// Joints of vertex v: [first_influence[v], first_influence[v + 1]); empty: there are none.
  std::vector<std::int64_t> first_influence;
  std::vector<JointWeight> influences;
  int joint_sets = 0;  ///< of four each: JOINTS_0, JOINTS_1 ...
  /// By morph target: how far it takes each vertex.
  std::vector<std::vector<glm::dvec3>> targets;
  std::vector<Warning> warnings;  ///< of what else of the file is not here

  [[nodiscard]] std::span<const JointWeight> influences_of(std::int64_t vertex) const {
    const auto first = static_cast<std::size_t>(first_influence[vertex]);
    return std::span(influences)
        .subspan(first, static_cast<std::size_t>(first_influence[vertex + 1]) - first);
  }
  [[nodiscard]] bool has_tangents() const { return tangent_count() > 0; }
  /// Arrays of tangents: of groups, and of layers of each depth.
  [[nodiscard]] int tangent_count() const {
    int count = 0;
    for (int depth = 0; depth <= layer_depth(); ++depth) count += has_tangents(depth) ? 1 : 0;
    return count;
  }
  /// Of groups, or of layers of a depth.
  [[nodiscard]] bool has_tangents(int depth) const {
    return std::ranges::any_of(
        groups, [&](const AssetGroup& group) { return group.tangent_set_at(depth) >= 0; });
  }
  /// Of the layers on others; 0: there are none.
  [[nodiscard]] int layer_depth() const {
    int depth = 0;
    for (const AssetGroup& group : groups)
      for (const AssetLayer& layer : group.layers) depth = std::max(depth, layer.depth);
    return depth;
  }
  [[nodiscard]] bool moves() const { return !first_influence.empty() || !targets.empty(); }
  /// Whether anything but the first texture coordinates goes by their indices.
  [[nodiscard]] bool rides_on_uvs() const {
    return !further_uvs.empty() || !uv_moves.empty() ||
           std::ranges::any_of(arrays, &AssetArray::of_corners);
  }
};

}  // namespace planish
