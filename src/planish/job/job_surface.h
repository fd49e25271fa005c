#pragma once

#include <memory>

#include "planish/backend/backend.h"
#include "planish/job/job_input.h"
#include "planish/job/output_plan.h"
#include "planish/limit/adaptive_tessellation.h"
#include "planish/limit/limit_surface.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// One level of a job's surface.
class JobLevel {
 public:
  /// Made piece by piece, as often as it is asked for.
  explicit JobLevel(std::unique_ptr<SurfaceBlocks> blocks, Callbacks callbacks)
      : blocks_(std::move(blocks)), callbacks_(std::move(callbacks)) {}
  /// As fine as it has to be.
  JobLevel(std::unique_ptr<const AdaptiveSurface> adaptive, const LimitSurface& lies_on);
  /// Of the schemes that make it whole; `mesh` is what was fitted.
  JobLevel(std::unique_ptr<const SurfaceMesh> whole, const PolygonMesh& mesh);

  [[nodiscard]] int level() const { return blocks().info().level; }
  [[nodiscard]] const SurfaceBlocks& blocks() const { return kept_ ? *kept_ : *blocks_; }
  [[nodiscard]] bool is_whole() const { return made_whole_ != nullptr || adaptive_ != nullptr; }
  /// Makes rows and quads once for all who read them from now on: see KeepOptions.
  void keep(const glm::dvec3& origin, QuadVisit visit);
  [[nodiscard]] bool is_kept() const { return kept_ != nullptr; }
  /// All of it in memory, for those who need neighbours; collected when first asked for.
  [[nodiscard]] const SurfaceMesh& whole();
  /// Frees what whole() collected, unless that is all that there is.
  void let_go() { collected_.reset(); }

 private:
  std::unique_ptr<const AdaptiveSurface> adaptive_;
  std::unique_ptr<const SurfaceMesh> made_whole_, collected_;
  std::unique_ptr<SurfaceBlocks> blocks_, kept_;  // kept_ reads blocks_
  Callbacks callbacks_;
};

/// The surface of a fitted mesh; what its levels share is made once.
class JobSurface {
 public:
  /// All of it must outlive the surface.
  JobSurface(const FittedMesh& fitted, Backend& backend, Callbacks callbacks);

  /// Throws as evaluate(). The surface must outlive its levels.
  [[nodiscard]] JobLevel level(int level);
  /// Throws as tessellate().
  [[nodiscard]] JobLevel adaptive(const Fineness& fineness);
  /// Throws as level(). Of Doo-Sabin surfaces.
  [[nodiscard]] const LimitSurface& limit();
  /// What the levels so far were taken from; null before the first, and with other schemes.
  [[nodiscard]] const DooSabinSurface* doo_sabin() const { return doo_sabin_.get(); }
  /// The same, made now where no level was; null with other schemes.
  [[nodiscard]] std::shared_ptr<const DooSabinSurface> made_doo_sabin();

 private:
  const FittedMesh& fitted_;
  Backend& backend_;
  EvaluateOptions options_;
  std::shared_ptr<const DooSabinSurface> doo_sabin_;  // made with the first level
  std::unique_ptr<const LimitSurface> limit_;         // made when first asked for
};

}  // namespace planish
