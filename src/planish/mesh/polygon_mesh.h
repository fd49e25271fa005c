#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/mesh/vertex_attribute.h"

namespace planish {

/// Sharpness at and above which an edge or vertex is infinitely sharp, as in OpenSubdiv.
inline constexpr float kInfiniteSharpness = 10.0f;

/// A tagged edge between two adjacent vertices.
struct CreaseEdge {
  std::int32_t v0, v1;
  float sharpness = kInfiniteSharpness;
};

/// A tagged vertex.
struct CornerVertex {
  std::int32_t vertex;
  float sharpness = kInfiniteSharpness;
};

/// A part of the mesh that a file names.
struct FaceGroup {
  std::string name;      ///< of the group or object; may be empty
  std::string material;  ///< may be empty
};

/// Polygons of any size, counter-clockwise seen from outside.
struct PolygonMesh {
  std::vector<glm::dvec3> positions;
  /// face_count + 1; the corners of face f are [offsets[f], offsets[f+1]).
  std::vector<std::int32_t> face_offsets{0};
  std::vector<std::int32_t> face_vertices;  ///< vertex indices of all faces, one after another
  std::vector<CreaseEdge> creases;
  std::vector<CornerVertex> corners;

  // What rides on the mesh and is refined with it. Each may be empty: none.
  std::vector<glm::dvec2> uvs;         ///< texture coordinates, which face_uvs names
  std::vector<std::int32_t> face_uvs;  ///< one per corner, as face_vertices; -1: none there
  std::vector<glm::vec4> colors;       ///< linear RGBA, 0 to 1, one per vertex
  std::vector<VertexAttribute> attributes;
  std::vector<FaceGroup> groups;
  std::vector<std::int32_t> face_groups;  ///< one per face: its group
  std::vector<std::int32_t> hole_faces;   ///< faces that shape the surface but are no part of it

  [[nodiscard]] std::int32_t vertex_count() const {
    return static_cast<std::int32_t>(positions.size());
  }
  [[nodiscard]] std::int32_t face_count() const {
    return static_cast<std::int32_t>(face_offsets.size()) - 1;
  }
  [[nodiscard]] std::int32_t face_size(std::int32_t face) const {
    return face_offsets[face + 1] - face_offsets[face];
  }
  [[nodiscard]] std::span<const std::int32_t> face(std::int32_t index) const {
    return {face_vertices.data() + face_offsets[index], static_cast<std::size_t>(face_size(index))};
  }
  void add_face(std::span<const std::int32_t> vertices) {
    face_vertices.insert(face_vertices.end(), vertices.begin(), vertices.end());
    face_offsets.push_back(static_cast<std::int32_t>(face_vertices.size()));
  }
};

}  // namespace planish
