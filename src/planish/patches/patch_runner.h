#pragma once

#include <cstdint>
#include <span>

#include "planish/patches/patch_kernel.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_numbering.h"
#include "planish/patches/patch_plan.h"

namespace planish {

/// Evaluates patches without a plan of them: each is gathered into a batch of its class, which runs
/// as soon as it is full, its indices still in the nearest cache. The same bits as with plans. Safe
/// to use from many threads; all of it must outlive the runner.
class PatchRunner {
 public:
  PatchRunner(const PatchMesh& mesh, const PatchNumbering& numbering, const PatchClasses& classes,
              PatchKernel kernel);

  /// Whether tiles of that part are run here: not those with two sides of a cut or hidden faces.
  [[nodiscard]] bool runs(PatchNumbering::Part part) const;

  // All return whether a normal came out zero.
  /// All rows of a tile, whose first one is the output's first.
  bool run_tile(const PatchTile& tile, const PatchOutput& output, const double* state) const;
  /// All samples of some corners, in the order of PatchSamples one corner after another.
  bool run_grids(std::span<const std::int32_t> corners, const PatchOutput& output,
                 const double* state) const;
  /// Rows of vertices, faces, edges and further sectors, anyhow.
  bool run_points(std::span<const std::int32_t> rows, const PatchOutput& output,
                  const double* state) const;

 private:
  class Run;
  template <bool kQuads>
  void add_corner(std::int32_t corner, std::int32_t target, Run& run) const;
  template <bool kQuads>
  void add_point(PatchNumbering::Part part, std::int64_t item, std::int32_t target, Run& run) const;
  template <bool kQuads>
  void add_tile(const PatchTile& tile, Run& run) const;
  void add_place(const PatchPlace& place, std::int32_t target, Run& run) const;

  const PatchMesh& mesh_;
  const MeshTopology& topology_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
  PatchKernel kernel_;
  bool quads_ = false;  // every face has four corners
};

}  // namespace planish
