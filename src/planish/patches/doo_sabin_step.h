#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/subdivision.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/patches/patch_mesh.h"

namespace planish {

/// Rows over the columns of a class, one after another.
using PatchRowsOfWeights = std::vector<double>;

/// The rings around V, E1, F and E2 of a class (around V alone for a limit point), in the class's
/// columns as numbers.
class PatchRings {
 public:
  using UseRow = std::function<void(std::span<const double> row)>;

  explicit PatchRings(const PatchClass& patch);

  /// Weights of the limit point and of the tangents du and dv, whose cross product is the outward
  /// normal's direction: three rows. Corner 0 to 3: V, E1, F, E2.
  [[nodiscard]] PatchRowsOfWeights limit(int corner) const;

  /// The class of quarter 0 to 3 of the patch (at V, E1, F, E2), turned so that the quarter's
  /// corner is its V.
  [[nodiscard]] PatchClass quarter_class(int quarter) const;
  /// That class's points after one step: use(row) for each in the order of its columns. All of them
  /// together are the square of a face's corners.
  void visit_quarter_points(int quarter, const FaceWeights& weights, const UseRow& use) const;
  /// The first of them, of the ring around the quarter's corner, and those behind.
  void visit_ring_points(int quarter, const FaceWeights& weights, const UseRow& use) const;
  void visit_further_points(int quarter, const FaceWeights& weights, const UseRow& use) const;
  /// The columns around the quarter's corner, in the order of its ring points, where it is smooth
  /// and not by sums; else none.
  [[nodiscard]] std::span<const std::int32_t> ring_columns(int quarter) const;

 private:
  class RowMaker;

  // A ring by its sums: their columns, mean first, and those of points.
  struct Summed {
    std::int32_t own, next, previous, sums;
    std::int32_t vertex;  // what it shrinks to instead of keeping its mean, or -1
    double cosine, sine;  // of the angle between two of its points
  };

  PatchClass class_;
  std::array<std::optional<Summed>, 4> summed_;  // corners 0 and 2; these have no ring in rings_
  std::array<VertexRing, 4> rings_;
  std::array<PatchKind, 4> kinds_;
  std::array<std::int32_t, 4> own_;  // the patch's own face's place in each ring
  std::array<bool, 4> sharp_;        // edge j runs from corner j to corner j + 1
};

/// The state of level 1 of a cage's surface, see Subdivision: one Doo-Sabin step, on all threads.
/// `points` are the cage's, one per vertex of the mesh; the state is in their coordinates.
[[nodiscard]] RawVector<glm::dvec3> first_step(const PatchMesh& mesh, Weights weights,
                                               std::span<const glm::dvec3> points);

/// The same, to the bit, of the points that some faces have: their corners and the ends of their
/// sharp edges. `state` holds all of it; sums of large rings stay, see update_sums_at().
void update_first_step(const PatchMesh& mesh, const FaceWeights& weights,
                       std::span<const glm::dvec3> points, std::span<const std::int32_t> faces,
                       std::span<glm::dvec3> state);

}  // namespace planish
