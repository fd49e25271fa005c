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

/// A part of a mesh with one material: primitives that differ in their vertices only.
struct AssetGroup {
  std::int64_t primitive = 0;  ///< the first of them, in the mesh
  int uv_sets = 0;             ///< of texture coordinates
  int tangent_set = -1;        ///< of those, whose tangents it has; -1: none
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
};

/// How far a morph target takes texture coordinates, as the file has them.
struct AssetUvMoves {
  std::string name;                ///< "target/0/TEXCOORD_0"
  std::vector<glm::dvec2> values;  ///< as many as PolygonMesh::uvs
};

/// How far a joint takes a vertex along.
struct JointWeight {
  std::int32_t joint;
  float weight;
  friend bool operator==(const JointWeight&, const JointWeight&) = default;
};

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
  /// Bytes of a vertex that a file has for all this, uncompressed.
  [[nodiscard]] std::uint64_t bytes_of_vertex() const {
    constexpr std::uint64_t kUv = 8, kJoints = 8 + 16, kTarget = 12 + 12, kTangent = 16;
    std::uint64_t bytes = kUv * (further_uvs.size() + uv_moves.size()) + kTarget * targets.size() +
                          kJoints * static_cast<std::uint64_t>(joint_sets);
    for (const AssetArray& array : arrays) bytes += 4 * static_cast<std::uint64_t>(array.width);
    if (has_tangents()) bytes += kTangent;
    return bytes;
  }
  [[nodiscard]] bool has_tangents() const {
    return std::ranges::any_of(groups,
                               [](const AssetGroup& group) { return group.tangent_set >= 0; });
  }
  [[nodiscard]] bool moves() const { return !first_influence.empty() || !targets.empty(); }
  /// Whether anything but the first texture coordinates goes by their indices.
  [[nodiscard]] bool rides_on_uvs() const {
    return !further_uvs.empty() || !uv_moves.empty() ||
           std::ranges::any_of(arrays, &AssetArray::of_corners);
  }
};

}  // namespace planish
