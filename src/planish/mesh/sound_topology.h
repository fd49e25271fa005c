#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "planish/mesh/check.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

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
