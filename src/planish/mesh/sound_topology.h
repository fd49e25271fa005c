#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The faces of a mesh or of a surface, what rides on them, and how many there are of what they
/// name: all that is needed to say whether counts and indices fit each other.
struct MeshArrays {
  std::size_t vertex_count = 0;
  std::span<const std::int32_t> face_offsets;  ///< empty: every face has four corners
  std::span<const std::int32_t> face_vertices;
  std::size_t uv_count = 0;
  std::span<const std::int32_t> face_uvs;
  std::size_t color_count = 0;
  std::span<const VertexAttribute> attributes;
  std::size_t group_count = 0;
  std::span<const std::int32_t> face_groups;
  std::span<const std::int32_t> hole_faces;
  std::span<const CreaseEdge> creases;
  std::span<const CornerVertex> corners;

  [[nodiscard]] std::size_t face_count() const {
    return face_offsets.empty() ? face_vertices.size() / 4 : face_offsets.size() - 1;
  }
};

[[nodiscard]] MeshArrays arrays_of(const PolygonMesh& mesh);

/// Whether attributes are as many as what they belong to, name what exists, and no sharpness is
/// NaN; of arrays whose offsets are sound.
[[nodiscard]] bool attributes_are_sound(const MeshArrays& arrays);

/// Appends what attributes_are_sound() finds wrong.
void list_attribute_problems(const MeshArrays& arrays, std::vector<MeshProblem>& problems);

/// The first reason why arrays cannot be walked: offsets, vertices and attributes that do not
/// exist, tags of vertices that do not. Faces may have any number of corners from `least_corners`.
[[nodiscard]] std::optional<MeshProblem> first_index_problem(const MeshArrays& arrays,
                                                             std::int32_t least_corners = 0);

/// Throws Error{code} `name: first problem`, with its element.
void require_sound_indices(const MeshArrays& arrays, std::string_view name, ErrorCode code,
                           std::int32_t least_corners = 0);

/// Most vertices, faces, face entries and table entries that are addressed.
inline constexpr std::int64_t kMaxInt32 = std::numeric_limits<std::int32_t>::max();

/// The connectivity of a mesh in which check() would find no problem, in which offsets and indices
/// may hold anything: tested on the way, on all threads. Nothing where there is a problem, and in
/// the rare cases where saying so would take more than linear time.
[[nodiscard]] std::optional<MeshTopology> sound_topology(const PolygonMesh& mesh);

/// The connectivity of a mesh that passes check(). Throws as require_usable() for others.
[[nodiscard]] MeshTopology usable_topology(const PolygonMesh& mesh, std::string_view name);

/// What check() finds, looking at one element after another on one thread.
[[nodiscard]] std::vector<MeshProblem> list_problems(const PolygonMesh& mesh);

/// Whether no coordinate is infinite, NaN or beyond kMaxCoordinate.
[[nodiscard]] bool positions_are_finite(const PolygonMesh& mesh);

}  // namespace planish
