#include "planish/job/job_surface.h"

#include <utility>

#include "planish/limit/adaptive_blocks.h"
#include "planish/surface/evaluate.h"

namespace planish {

JobLevel::JobLevel(std::unique_ptr<const SurfaceMesh> whole, const PolygonMesh& mesh)
    : made_whole_(std::move(whole)), blocks_(blocks_of(*made_whole_, mesh)) {}

void JobLevel::keep(const glm::dvec3& origin, QuadVisit visit) {
  kept_ =
      keep_rows(*blocks_, {.origin = origin, .visit = std::move(visit), .callbacks = callbacks_});
}

JobLevel::JobLevel(std::unique_ptr<const AdaptiveSurface> adaptive, const LimitSurface& lies_on)
    : adaptive_(std::move(adaptive)),
      blocks_(std::make_unique<AdaptiveBlocks>(*adaptive_, lies_on)) {}

const SurfaceMesh& JobLevel::whole() {
  if (adaptive_) return adaptive_->mesh;
  if (made_whole_) return *made_whole_;
  if (!collected_) collected_ = std::make_unique<const SurfaceMesh>(collect(blocks(), callbacks_));
  return *collected_;
}

JobSurface::JobSurface(const FittedMesh& fitted, Backend& backend, Callbacks callbacks)
    : fitted_(fitted), backend_(backend), options_(fitted.evaluate_options()) {
  options_.callbacks = std::move(callbacks);
}

JobLevel JobSurface::level(int level) {
  options_.level = level;
  if (options_.scheme != Scheme::DooSabin) {
    return {std::make_unique<const SurfaceMesh>(
                evaluate(fitted_.mesh, fitted_.fit, backend_, options_)),
            fitted_.mesh};
  }
  (void)made_doo_sabin();
  auto* const evaluator = dynamic_cast<PatchEvaluator*>(&backend_);
  return JobLevel(doo_sabin_->level(level, options_.memory_limit_bytes, evaluator),
                  options_.callbacks);
}

std::shared_ptr<const DooSabinSurface> JobSurface::made_doo_sabin() {
  if (!doo_sabin_ && options_.scheme == Scheme::DooSabin)
    doo_sabin_ = fitted_surface(fitted_.mesh, fitted_.fit, options_);
  return doo_sabin_;
}

const LimitSurface& JobSurface::limit() {
  (void)made_doo_sabin();
  if (!limit_) limit_ = std::make_unique<const LimitSurface>(doo_sabin_);
  return *limit_;
}

JobLevel JobSurface::adaptive(const Fineness& fineness) {
  return {std::make_unique<const AdaptiveSurface>(
              tessellate(limit(), {.chord_error = fineness.chord_error,
                                   .angle = fineness.angle,
                                   .diagonal = fitted_.fit.placement.diagonal,
                                   .callbacks = options_.callbacks})),
          limit()};
}

}  // namespace planish
