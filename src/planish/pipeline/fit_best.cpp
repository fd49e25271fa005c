#include "planish/pipeline/fit_best.h"

#include <cstdio>
#include <utility>

#include "planish/mesh/convex_faces.h"
#include "planish/mesh/cusp_corners.h"

namespace planish {

namespace {

constexpr double kFoldedArea = 1e-5;
constexpr double kClearlyBetter = 0.9;

SurfaceQuality measured(const PolygonMesh& mesh, const Fit& fit, Backend& backend,
                        const FitOptions& options) {
  EvaluateOptions evaluation;
  evaluation.level = 1;
  evaluation.weights = options.weights;
  evaluation.sharp = options.sharp;
  evaluation.callbacks = options.callbacks;
  return surface_quality(evaluate(mesh, fit, backend, evaluation), mesh);
}

std::string reason_of(const BestFit& best) {
  char text[200];
  if (best.method == InterpolationMethod::Progressive) {
    std::snprintf(text, sizeof text,
                  "progressive: it does not fold, and its normals are off by %.3g degrees rms, "
                  "fair's by %.3g",
                  best.progressive.rms_normal_deviation, best.fair.rms_normal_deviation);
  } else if (best.progressive.folded_area_elsewhere >= kFoldedArea) {
    std::snprintf(text, sizeof text, "fair: progressive folds %.2g %% of the area, fair %.2g %%",
                  100 * best.progressive.folded_area_elsewhere,
                  100 * best.fair.folded_area_elsewhere);
  } else {
    std::snprintf(text, sizeof text,
                  "fair: its normals are off by %.3g degrees rms, progressive's by %.3g, not "
                  "clearly less",
                  best.fair.rms_normal_deviation, best.progressive.rms_normal_deviation);
  }
  return text;
}

}  // namespace

BestFit fit_best(const PolygonMesh& mesh, Backend& backend, const FitOptions& options) {
  FitOptions progressive = options, fair = options;
  progressive.method = InterpolationMethod::Progressive;
  fair.method = InterpolationMethod::Fair;
  BestFit best;
  best.mesh = with_cusp_corners(with_convex_faces(mesh).mesh);
  best.fit = fit(best.mesh, backend, fair);
  best.fair = measured(best.mesh, best.fit, backend, fair);
  best.method = InterpolationMethod::Fair;
  Fit other = fit(mesh, backend, progressive);
  best.progressive = measured(mesh, other, backend, progressive);
  const bool sound = best.progressive.folded_area_elsewhere < kFoldedArea;
  const bool clearly_better =
      best.progressive.rms_normal_deviation < kClearlyBetter * best.fair.rms_normal_deviation;
  if (sound && clearly_better && other.interpolation.converged) {
    best.method = InterpolationMethod::Progressive;
    best.mesh = mesh;
    best.fit = std::move(other);
  }
  best.reason = reason_of(best);
  return best;
}

}  // namespace planish
