#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "planish/distributed/mesh_slice.h"

namespace planish {

/// Vertices of one block: the unit of work, and of what ranks own. 3.7 % more faces as ghosts.
inline constexpr std::int64_t kBlockVertices = 65536;

/// The vertices along the Hilbert curve of their box. A vertex's number is its place; ties go by
/// the number in the file, so that the order is the same for every rank count.
struct CurveOrder {
  Layout layout;                        ///< of numbers; ranks are cut between blocks
  std::vector<std::int64_t> file_ids;   ///< of this rank's run: numbers in the file
  std::vector<glm::dvec3> positions;    ///< of this rank's run
  std::vector<glm::vec4> colors;        ///< of this rank's run, where the mesh has some
  std::vector<std::int64_t> number_of;  ///< of this rank's slice of the file
};

/// Takes the slice's positions and colours. Sample sort: no rank ever holds more than about its
/// share.
[[nodiscard]] CurveOrder order_along_curve(const Ranks& ranks, MeshSlice& slice,
                                           std::int64_t block_vertices = kBlockVertices);

}  // namespace planish
