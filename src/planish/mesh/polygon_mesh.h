#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

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

/// Polygons of any size, counter-clockwise seen from outside.
struct PolygonMesh {
  std::vector<glm::dvec3> positions;
  std::vector<std::int32_t> face_offsets{
      0};  ///< face_count + 1; face f is [offsets[f], offsets[f+1])
  std::vector<std::int32_t> face_vertices;  ///< vertex indices of all faces, one after another
  std::vector<CreaseEdge> creases;
  std::vector<CornerVertex> corners;

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
