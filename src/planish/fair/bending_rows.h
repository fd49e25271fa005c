#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// The bending of a net of level 1, linearised in one height per control point along the normal of
/// its vertex: the sum of all squares of (value + coefficients . heights). Everything per place,
/// which is an index into the ring arrays of the topology. Heights of control points that must stay
/// (around crease and corner vertices) have zero coefficients. In single precision: values and
/// coefficients are of the order of 1 in the units of `height_units`.
struct BendingRows {
  /// The two lines through one control point: from the next corner of its face through it to the
  /// one after it around the vertex, and from the previous corner through it to the one before.
  struct Row {
    float next, own1, after, value1;
    float previous, own2, before, value2;
  };
  std::vector<Row> rows;
  std::vector<std::int32_t> next, previous;  ///< places of the corners beside in the face
  std::vector<double> height_units;          ///< per vertex: length of one unit of height
};

/// `offsets`: the state of level 1 relative to the given points; `normals`: unit, per vertex.
/// No row stands for a line one of whose two parts is too short to measure bending on.
[[nodiscard]] BendingRows make_bending_rows(const FairTopology& topology,
                                            std::span<const glm::dvec3> given,
                                            std::span<const glm::dvec3> normals,
                                            std::span<const glm::dvec3> offsets);

}  // namespace planish
