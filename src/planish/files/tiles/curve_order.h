#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "planish/core/raw_vector.h"

namespace planish {

/// A box in which points are placed on the curve: a cube at its lower corner.
struct CurveBox {
  glm::dvec3 lower{0.0};
  double side = 0;  ///< 0: all points coincide
};

/// Cells along each side of the cube.
inline constexpr std::uint32_t kCurveBits = 21;

[[nodiscard]] CurveBox curve_box(std::span<const glm::dvec3> points);

/// The place of a cell on Hilbert's curve through a cube of 2^21 cells a side, 63 bits: cells that
/// follow one another share a face. Coordinates must be below 2^21.
/// Source: J. Skilling, "Programming the Hilbert curve", 2004.
[[nodiscard]] std::uint64_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// The key of a point's cell; points beside the box count as on its sides.
[[nodiscard]] std::uint64_t hilbert_key(const glm::dvec3& point, const CurveBox& box);

/// The numbers of all points by their places on the curve, those of one cell ascending: a total
/// order, the same for every number of threads. Takes 16 bytes a point on the way.
[[nodiscard]] RawVector<std::int32_t> curve_order(std::span<const glm::dvec3> points);

}  // namespace planish
