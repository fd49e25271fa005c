#include "planish/reconstruct/choose_by_noise.h"

#include <algorithm>
#include <string>

namespace planish {
namespace {

constexpr double kDefaultTolerance = 1e-4;
// Noise in spacings, up to which one round of smoothing does, and above which two do not.
constexpr double kLightSpacings = 0.08, kHeavySpacings = 0.3;

// How often points are moved before they are meshed, unless that is asked for.
std::int32_t smooth_rounds_for(const Reconstruction& result) {
  const double spacings = result.noise / result.spacing;
  return spacings > kHeavySpacings ? 4 : spacings > kLightSpacings ? 2 : 1;
}

}  // namespace

void choose_by_noise(const ReconstructOptions& options, Reconstruction& result) {
  const double noise = std::max(result.noise / result.diagonal, 0.0);
  const double asked = options.tolerance.value_or(kDefaultTolerance);
  // At tolerance 0 every point is to be a vertex, as it is.
  const bool is_noisy = noise > kDefaultTolerance && asked > 0;
  result.smooth_rounds = options.smooth_rounds.value_or(is_noisy ? smooth_rounds_for(result) : 0);
  result.tolerance = options.tolerance.value_or(is_noisy ? noise : kDefaultTolerance);
  const double sensible = (result.smooth_rounds > 0 ? 0.5 : 1.0) * noise;  // half is left
  if (is_noisy && asked < sensible && options.tolerance)
    options.callbacks.warn({.code = "tolerance-below-noise",
                            .message = "the points scatter by more than --tolerance-mesh, so that "
                                       "vertices are spent on their noise; " +
                                       std::to_string(sensible) + " would leave fewer"});
}

}  // namespace planish
