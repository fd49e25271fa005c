#include "planish/job/step_output.h"

#include "planish/job/digest.h"

namespace planish {

WrittenOutput write_step_output(const PlannedOutput& planned, const std::filesystem::path& target,
                                const LimitSurface* limit, const FittedMesh& fitted,
                                const StepSettings& settings, const SurfaceOutputOptions& options) {
  WrittenDigest digest(options.digests);
  const StepFileOptions step{.settings = settings,
                             .name = options.gltf.name,
                             .shown = planned.path,
                             .materials = options.gltf.materials,
                             .observe = digest.observer(),
                             .callbacks = options.gltf.callbacks};
  const StepFigures figures = limit != nullptr ? write_fitted_step(target, fitted, *limit, step)
                                               : write_fitted_step(target, fitted, step);
  WrittenOutput written;
  written.path = planned.path.string();
  written.bytes = figures.byte_count;
  written.sha256 = digest.finish();
  written.vertices = figures.vertices;
  written.faces = figures.faces;
  written.as_written_error = figures.largest_distance / options.diagonal;
  written.step = figures;
  return written;
}

}  // namespace planish
