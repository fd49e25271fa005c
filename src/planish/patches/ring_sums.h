#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_class.h"

namespace planish {

/// How patches take rings, sectors and faces from kSummedRing on: by each of their points, or by
/// sums, which Doo and Sabin's weights allow.
enum class RingColumns { Points, Sums };

/// Faces around a vertex, and corners of a face, that are taken by points: time and memory are
/// their square. A second and some 1.5 GB for one such vertex amid a boundary.
inline constexpr std::int32_t kLargestByPoints = 1024;

/// How they are taken with these weights. Throws Error{UnusableMesh} for the first vertex or face
/// with more than kLargestByPoints where that is by points. `vertices`: their numbers in messages;
/// none: the topology's.
[[nodiscard]] RingColumns ring_columns(const MeshTopology& topology, Weights weights,
                                       std::span<const std::int32_t> vertices = {});

/// A large ring or sector of faces around a vertex, or of corners around a face. All that its rule
/// needs of it are a mean M and two vectors U, W that turn with the place i, at angle a_i:
///
///   X'_i = X_i / 4 + 3/4 M + (cos a_i U + sin a_i W) / 4
///
/// Around a vertex or face M, U and W are the mean and the first Fourier pair of its points. In a
/// sector that the curve through its vertex bounds M is the vertex, U the curve's direction, W the
/// points' way from it. At corner vertices, whose points shrink to V, it is V / 2 + M / 4 instead
/// of 3/4 M, and in convex and reflex sectors M is V. See sector_rules.cpp, whose rules these are.
struct LargeRing {
  PatchKind kind = PatchKind::Smooth;  ///< Dart: of the whole ring
  std::int32_t start = 0;              ///< the corner at place 0; they follow counter-clockwise
  std::int32_t size = 0;
  /// The place in the state of M, M + cos a_i U + sin a_i W and M + cos a_i W - sin a_i U of
  /// corner 0, behind which are those of the others.
  std::int32_t first_sum = 0;

  [[nodiscard]] bool is_sector() const {
    return kind != PatchKind::Smooth && kind != PatchKind::Cone && kind != PatchKind::Dart;
  }
  [[nodiscard]] std::int32_t sum_count() const { return 3 * size; }
};

/// a_0, and what lies between two places.
struct RingAngles {
  double first, step;
};
[[nodiscard]] RingAngles ring_angles(PatchKind kind, std::int32_t size);

/// Weights of a ring's points in M, U and W: one row a point, which are its faces' points, of a
/// sector also its two curve points and, at a corner vertex, the vertex itself. Columns sum to 1, 0
/// and 0.
[[nodiscard]] std::vector<glm::dvec3> ring_weights(const LargeRing& ring);

/// Writes the ring's sums, of its points in that order.
void write_ring_sums(const LargeRing& ring, std::span<const glm::dvec3> points, glm::dvec3* sums);

/// The weights of a ring's points in one of its sums, by its place behind `first_sum`.
[[nodiscard]] std::vector<double> sum_weights(const LargeRing& ring, std::int32_t sum);

}  // namespace planish
