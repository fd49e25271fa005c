#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/distributed/messages.h"
#include "planish/distributed/slice_attributes.h"

namespace planish {

/// A tagged edge.
struct SliceCrease {
  std::int64_t v0, v1;  ///< numbers in the file; on their way to the owners, along the curve
  float sharpness;
  std::int64_t index;  ///< among all creases, in the order of the file
  std::int64_t file_v0 = v0, file_v1 = v1;
};

/// A tagged vertex.
struct SliceCorner {
  std::int64_t vertex;  ///< as those of creases
  float sharpness;
  std::int64_t index;
  std::int64_t file_vertex = vertex;
};

/// What one rank holds of a mesh as it was read: runs of its vertices and faces in the order of the
/// file, which follow those of the rank before.
struct MeshSlice {
  Layout vertices, faces;  ///< the runs of all ranks
  std::vector<glm::dvec3> positions;
  std::vector<std::int64_t> face_offsets{0};
  std::vector<std::int64_t> face_vertices;  ///< numbers in the file, all in range
  std::vector<SliceCrease> creases;
  std::vector<SliceCorner> corners;
  std::vector<std::int64_t> holes;  ///< faces that are not shown; numbers in the file, any rank's
  SliceAttributes attributes;
  std::vector<Warning> warnings;  ///< the same on all ranks

  [[nodiscard]] std::int64_t vertex_total() const { return vertices.back(); }
  [[nodiscard]] std::int64_t face_total() const { return faces.back(); }
  [[nodiscard]] std::int64_t face_count() const {
    return static_cast<std::int64_t>(face_offsets.size()) - 1;
  }
  [[nodiscard]] std::span<const std::int64_t> face(std::int64_t index) const {
    return std::span(face_vertices)
        .subspan(face_offsets[index], face_offsets[index + 1] - face_offsets[index]);
  }
  void add_face(std::span<const std::int64_t> named) {
    face_vertices.insert(face_vertices.end(), named.begin(), named.end());
    face_offsets.push_back(static_cast<std::int64_t>(face_vertices.size()));
  }
};

}  // namespace planish
