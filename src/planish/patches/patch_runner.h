#pragma once

#include <cstdint>
#include <span>

#include "planish/core/raw_vector.h"
#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_numbering.h"
#include "planish/patches/patch_plan.h"
#include "planish/patches/point_rows.h"

namespace planish {

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

}  // namespace planish
