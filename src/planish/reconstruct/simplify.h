#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/triangles.h"
#include "planish/reconstruct/ordered_points.h"
#include "planish/reconstruct/witnessed_mesh.h"

namespace planish {

enum class Spacing {
  Adaptive,  ///< as few vertices as the tolerance allows: flat parts get large triangles
  Even,      ///< neighbouring edges of similar length and no small angles: more vertices
};

struct SimplifyOptions {
  double tolerance = 0;              ///< a length, above 0
  std::int64_t target_vertices = 0;  ///< stop there; 0: go as far as the tolerance allows
  Spacing spacing = Spacing::Adaptive;
  double least_angle = -1;        ///< degrees, 0 to 45; below 0: by spacing
  std::int32_t max_valence = -1;  ///< at least 6; below 0: by spacing
  Callbacks callbacks;
};

/// The limits that stand for "by spacing".
[[nodiscard]] double default_least_angle(Spacing spacing);
[[nodiscard]] std::int32_t default_max_valence(Spacing spacing);

struct SimplifiedMesh {
  std::vector<Triangle> triangles;  ///< corners are indices of the given positions
  std::int64_t vertex_count = 0;
  std::int64_t collapse_count = 0, flip_count = 0, move_count = 0;
  std::int64_t strayed_count = 0;  ///< points that were beyond the tolerance to begin with
};

/// Removes vertices from an oriented manifold so that every position, vertex of the given mesh or
/// not, stays within the tolerance of the mesh; those beyond it at first are counted and left out.
/// Vertices stay where they are; components, genus and boundary loops are kept; no new triangle
/// has an angle below the limit, unless those it replaces were worse.
/// Throws Error{InvalidArgument} for the options, Error{Cancelled}.
[[nodiscard]] SimplifiedMesh simplify(std::span<const glm::dvec3> positions,
                                      std::span<const Triangle> triangles,
                                      const SimplifyOptions& options);

/// The same for a mesh through some of many points, whose carriers are known: those without one are
/// left out.
[[nodiscard]] SimplifiedMesh simplify(const OrderedPoints& points, WitnessedMesh mesh,
                                      const SimplifyOptions& options);

}  // namespace planish
