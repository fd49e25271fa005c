#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/triangles.h"

namespace planish {

/// Which connected parts of a mesh stay.
struct ComponentRule {
  /// Auto: those of at least a fiftieth of the largest one's triangles.
  enum class Keep { Auto, Largest, All, AtLeast } keep = Keep::Auto;
  std::int64_t least_faces = 0;  ///< of Keep::AtLeast
};

struct TriangleRepairOptions {
  std::int32_t longest_filled_loop = 16;  ///< edges of a hole; 0 fills none, at most 1000
  ComponentRule components;
  Callbacks callbacks;
};

/// An oriented manifold, with or without boundary, and what was done to get it.
struct RepairedTriangles {
  std::vector<Triangle> triangles;
  std::int64_t dropped_triangle_count = 0;  ///< repeated, bridging, or against manifold
  std::int64_t filled_loop_count = 0;
  std::int64_t dropped_component_count = 0;
};

/// Makes triangles with any winding an oriented manifold: drops what prevents it and
/// open_bridges(), keeps the asked components, fills short boundary loops with the flattest patch
/// (largest dihedral angle, then area, at its least), and turns every component outwards (by its
/// volume; an open one by the volume over its centroid; one without volume as its first triangle
/// is). Corners must be different indices of `positions`. Throws Error{InvalidArgument} for the
/// options, Error{Cancelled}.
[[nodiscard]] RepairedTriangles repair_triangles(std::span<const glm::dvec3> positions,
                                                 std::vector<Triangle> triangles,
                                                 const TriangleRepairOptions& options = {});

}  // namespace planish
