#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_repair.h"

namespace planish {

/// How often a vertex is cured at most: its polygon is then a 256th of what fits beside its faces.
/// With smaller ones no measured mesh folded less, and close to them the surface is smooth in name
/// only.
inline constexpr int kMostCures = 5;

/// What the cure works on. `face_normals` and `normals`, one per vertex, are unit; `offsets`: the
/// state of level 1 relative to the given points, changed in place.
struct CureInput {
  const FairTopology& topology;
  std::span<const glm::dvec3> given, face_normals, normals;
  std::span<glm::dvec3> offsets;
  /// Per vertex where not empty: what stands in for the perpendicular polygon (hub_ellipse.h).
  std::span<const glm::vec4> ellipses{};
  FairHalo* halo = nullptr;  ///< where the mesh is a part; counts are those of all
};

/// After the last repair: cures folds at edges, faces and vertices that no halving cures. Vertices
/// at a limit normal that is turned too far from a face that it belongs to get perpendicular
/// polygons (perpendicular_polygon.h), and where that does not do a quarter of them, in at most
/// three rounds. Smooth and dart vertices only. `cures`, one per vertex, is increased by the rounds
/// that changed it; `leans` (plane_lean.h) are chosen where the first one does. Returns what is
/// still turned over by more than a right angle from one of its faces.
FoldCount cure_folds(const CureInput& input, std::span<std::uint8_t> cures,
                     std::span<glm::vec2> leans);

/// The same polygons, as an earlier cure decided them; leans that are wanted and were not chosen
/// then are now.
FoldCount repeat_cure(const CureInput& input, std::span<const std::uint8_t> cures,
                      std::span<glm::vec2> leans);

}  // namespace planish
