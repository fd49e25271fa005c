#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_halo.h"
#include "planish/fair/fair_topology.h"

namespace planish {

/// Elements whose level-1 limit normal is turned away from the mesh's.
struct FoldCount {
  std::int64_t edges = 0, faces = 0;
  std::int32_t rounds = 0;  ///< that changed something before
};

/// Halves the polygons of control points around the vertices of folded edges and faces, about the
/// vertex, so that interpolation is untouched; at most three rounds. At an edge whose own geometry
/// folds no size helps, so that more rounds do not.
/// `offsets`: the state of level 1 relative to the given points, changed in place; `face_normals`:
/// unit, one per face. `halvings`, one per vertex, is increased by what was done. Returns what is
/// still folded. `halo`: where the mesh is a part; counts are those of all.
FoldCount repair_folds(const FairTopology& topology, std::span<const glm::dvec3> given,
                       std::span<const glm::dvec3> face_normals, std::span<glm::dvec3> offsets,
                       std::span<std::uint8_t> halvings, FairHalo* halo = nullptr);

[[nodiscard]] inline FoldCount sum_of_parts(FairHalo* halo, const FoldCount& count) {
  return {sum_of_parts(halo, count.edges), sum_of_parts(halo, count.faces), count.rounds};
}

/// The halving alone, as an earlier repair decided it.
void halve_polygons(const FairTopology& topology, std::span<const std::uint8_t> halvings,
                    std::span<glm::dvec3> offsets);

/// Counts what is folded and changes nothing.
[[nodiscard]] FoldCount count_folds(const FairTopology& topology, std::span<const glm::dvec3> given,
                                    std::span<const glm::dvec3> face_normals,
                                    std::span<const glm::dvec3> offsets);

}  // namespace planish
