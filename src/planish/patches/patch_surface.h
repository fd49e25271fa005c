#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/range.h"
#include "planish/mesh/placement.h"
#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_numbering.h"
#include "planish/patches/patch_plan.h"
#include "planish/patches/patch_runner.h"
#include "planish/patches/patch_templates.h"

namespace planish {

struct PatchSurfaceOptions {
  int level = 2;  ///< 0: limit points of the vertices
  Weights weights = Weights::DooSabin;
  std::span<const std::uint8_t> hidden;  ///< one flag a face, or nothing; must outlive the surface
  std::span<const std::int32_t> corner_uvs;  ///< whose seams cut rows, too; see PatchNumbering
  PatchInstructions instructions = best_instructions();
};

/// Where rows are written, in model coordinates, each as long as the range of rows or empty.
struct PatchTarget {
  std::span<glm::dvec3> positions;
  std::span<glm::vec3> stored;  ///< positions - origin, rounded once
  std::span<glm::vec3> normals;
  glm::dvec3 origin{0.0};
};

/// Where a kernel writes; `offset` is the target's row of its row 0.
[[nodiscard]] PatchOutput output_at(const Placement& placement, const PatchTarget& target,
                                    std::ptrdiff_t offset);

/// Rows whose tangents are parallel: their normals are those of the facets around them.
struct DegenerateRows {
  std::int64_t count = 0, first = -1;
  void add(const DegenerateRows& other) {
    if (other.count > 0 && (count == 0 || other.first < first)) first = other.first;
    count += other.count;
  }
};

/// Everything that a Doo-Sabin surface of one level depends on besides its control points of level
/// 1, for any rows of it. Safe to use from many threads; results do not depend on their number, on
/// how rows are asked for, nor on the processor. `mesh` and what it refers to must outlive it.
class PatchSurface {
 public:
  PatchSurface(const PatchMesh& mesh, const PatchSurfaceOptions& options);

  [[nodiscard]] const PatchMesh& mesh() const { return mesh_; }
  [[nodiscard]] const PatchNumbering& numbering() const { return numbering_; }
  [[nodiscard]] const PatchClasses& classes() const { return classes_; }
  [[nodiscard]] const PatchPlanner& planner() const { return planner_; }
  /// Ranges of rows that are cheapest together, ascending.
  [[nodiscard]] std::span<const PatchTile> tiles() const { return tiles_; }

  /// Evaluates a range of rows, on the calling thread. `state`: the points of level 1 in
  /// coordinates of `placement`, with the sums of large rings where the mesh has them
  /// (PatchMesh::point_count()).
  DegenerateRows rows(std::span<const glm::dvec3> state, const Placement& placement, RowRange range,
                      const PatchTarget& target) const;
  /// Rows that are named in ascending order, none twice: the same bits, at the cost of all rows of
  /// the corners that they lie in. The target has a place for each.
  DegenerateRows rows_at(std::span<const glm::dvec3> state, const Placement& placement,
                         std::span<const std::int32_t> rows, const PatchTarget& target) const;

  /// All samples of some visible corners, one corner after another, each in the order of
  /// PatchSamples. Returns the degenerate ones of their own samples. With `points`, where
  /// makes_points(), and positions and normals the target: also the rows of vertices, faces and
  /// edges that these corners stand for (PatchNumbering::item_corner()), the same bits as rows().
  DegenerateRows grids(std::span<const glm::dvec3> state, const Placement& placement,
                       std::span<const std::int32_t> corners, const PatchTarget& target,
                       PointRows* points = nullptr) const;
  /// The same of the corners from `first` on, but their own samples only: to their rows. The target
  /// holds positions and normals of the rows from the first corner's on.
  DegenerateRows owned(std::span<const glm::dvec3> state, const Placement& placement,
                       std::int32_t first, std::int32_t corner_count, const PatchTarget& target,
                       PointRows& points) const;
  /// Whether corners can make those rows along.
  [[nodiscard]] bool makes_points() const { return runner_.makes_points(); }

  /// Some rows of vertices, faces, edges and their further sectors, in any order: as rows() gives
  /// them. Returns the degenerate ones, as often as they come.
  DegenerateRows points(std::span<const glm::dvec3> state, const Placement& placement,
                        std::span<const std::int32_t> rows, const PatchTarget& target) const;

 private:
  class RowEvaluator;

  DegenerateRows run_tile(std::size_t index, const PatchOutput& output, const double* state,
                          const Placement& placement, RowRange wanted) const;
  DegenerateRows normal_of(std::span<const glm::dvec3> state, const Placement& placement,
                           std::int32_t row, glm::vec3& normal) const;
  DegenerateRows mend(std::span<const glm::dvec3> state, const Placement& placement,
                      PointRows* points) const;
  DegenerateRows run_part(std::size_t index, std::span<const glm::dvec3> state,
                          const Placement& placement, RowRange wanted,
                          const PatchTarget& target) const;

  const PatchMesh& mesh_;
  PatchNumbering numbering_;
  PatchClasses classes_;
  PatchPlanner planner_;
  PatchRunner runner_;
  std::vector<PatchTile> tiles_;
};

}  // namespace planish
