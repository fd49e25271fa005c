#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_plan.h"

namespace planish {

/// Limit points of vertices, faces and edges that patches make along, in any order: their rows,
/// positions in model coordinates and normals.
class PointRows {
 public:
  /// Drops all and takes room for so many.
  void reset(std::size_t capacity) {
    rows_.resize(capacity);
    positions_.resize(capacity);
    normals_.resize(capacity);
    count_ = 0;
  }
  /// There must be room. A point without values gets them later.
  void add(std::int32_t row) { rows_[count_++] = row; }
  void add(std::int32_t row, const double* position, const float* normal) {
    rows_[count_] = row;
    positions_[count_] = {position[0], position[1], position[2]};
    normals_[count_++] = {normal[0], normal[1], normal[2]};
  }

  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] std::span<const std::int32_t> rows() const { return {rows_.data(), count_}; }
  [[nodiscard]] std::span<glm::dvec3> positions() { return {positions_.data(), count_}; }
  [[nodiscard]] std::span<glm::vec3> normals() { return {normals_.data(), count_}; }

 private:
  RawVector<std::int32_t> rows_;
  RawVector<glm::dvec3> positions_;
  RawVector<glm::vec3> normals_;
  std::size_t count_ = 0;
};

class PatchBatches;

/// Evaluates patches: each is gathered into a batch of its class, which runs as soon as it is full,
/// its indices still in the nearest cache. Safe to use from many threads; all of it must outlive
/// the runner.
class PatchRunner {
 public:
  PatchRunner(const PatchMesh& mesh, const PatchNumbering& numbering, const PatchClasses& classes,
              const PatchPlanner& planner, PatchKernel kernel);

  /// Whether corners can make the rows of vertices, faces and edges along: at level 2, of quads.
  [[nodiscard]] bool makes_points() const;

  // All return whether a normal came out zero.
  /// All rows of a tile, whose first one is the output's first; of one of corners in `points` those
  /// of the vertices, faces and edges that its corners stand for: see
  /// PatchNumbering::item_corner().
  bool run_tile(const PatchTile& tile, const PatchOutput& output, const double* state,
                PointRows* points = nullptr) const;
  /// All samples of some corners, in the order of PatchSamples one corner after another; points as
  /// above.
  bool run_grids(std::span<const std::int32_t> corners, const PatchOutput& output,
                 const double* state, PointRows* points = nullptr) const;
  /// Rows of vertices, faces, edges and further sectors, anyhow.
  bool run_points(std::span<const std::int32_t> rows, const PatchOutput& output,
                  const double* state) const;
  /// What a plan lists.
  bool run_plan(const PatchPlan& plan, const PatchOutput& output, const double* state) const;

 private:
  template <bool kQuads>
  void add_corner(std::int32_t corner, std::int32_t target, PatchBatches& run) const;
  template <bool kQuads>
  void add_point(PatchNumbering::Part part, std::int64_t item, std::int32_t target,
                 PatchBatches& run) const;
  template <bool kQuads>
  void add_tile(const PatchTile& tile, PatchBatches& run) const;
  static RawVector<std::int32_t>& further_points();
  static void begin_points(std::int64_t corner_count, PointRows* points);
  bool finish_points(const PatchOutput& output, const double* state, PointRows* points) const;
  void add_place(const PatchPlace& place, std::int32_t target, PatchBatches& run) const;
  // Whether tiles of that part need no plan: not those with two sides of a cut or hidden faces.
  [[nodiscard]] bool runs_at_once(PatchNumbering::Part part) const;
  static PatchPlan& empty_plan();

  const PatchMesh& mesh_;
  const MeshTopology& topology_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
  const PatchPlanner& planner_;
  PatchKernel kernel_;
  bool quads_ = false;  // every face has four corners
};

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

/// What a backend also is that evaluates patches on its device. For the others there is
/// PatchSurface::rows().
class PatchEvaluator {
 public:
  virtual ~PatchEvaluator() = default;

  struct Row {
    glm::vec3 position;  ///< in the coordinates of the state
    glm::vec3 normal;    ///< zero where tangents are parallel
  };

  /// All rows of a surface with these points of level 1, in the device's precision. Throws
  /// Error{OutOfMemory}, naming the limit, and Error{DeviceLost}.
  virtual void evaluate_patches(const PatchSurface& surface, std::span<const glm::dvec3> state,
                                std::span<Row> rows) = 0;
};

}  // namespace planish
