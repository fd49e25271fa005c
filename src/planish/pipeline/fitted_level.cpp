#include "planish/pipeline/fitted_level.h"

#include <cstdint>
#include <string>

#include "planish/files/file_materials.h"
#include "planish/mesh/statistics.h"
#include "planish/patches/patch_evaluator.h"

namespace planish {

FittedLevel fitted_level(const FittedMesh& fitted, Backend& backend,
                         const SurfaceFileOptions& options) {
  EvaluateOptions how = fitted.evaluate_options(options.level);
  how.callbacks = options.callbacks;
  require_level(options.level);
  FittedLevel made;
  if (fitted.options.scheme != Scheme::DooSabin) {
    made.whole =
        std::make_unique<const SurfaceMesh>(evaluate(fitted.mesh, fitted.fit, backend, how));
    made.blocks = blocks_of(*made.whole, fitted.mesh);
    return made;
  }
  options.callbacks.report("evaluate", 0);
  made.doo_sabin = fitted_surface(fitted.mesh, fitted.fit, how);
  made.blocks = made.doo_sabin->level(options.level, 0, dynamic_cast<PatchEvaluator*>(&backend));
  return made;
}

GltfOptions gltf_options_of(const FittedMesh& fitted, std::string_view name,
                            const SurfaceFileOptions& options) {
  GltfOptions gltf;
  gltf.name = std::string(name);
  gltf.double_sided = statistics(*fitted.fit.prepared).boundary_loop_count > 0;
  gltf.z_up = options.z_up;
  gltf.origin = storage_origin(fitted.fit.placement);
  gltf.extras = fit_extras(fitted.options, fitted.creases(), fitted.fit.interpolation);
  gltf.extras.emplace_back("level", std::int64_t{options.level});
  if (options.materials != nullptr) gltf.materials = &options.materials->gltf;
  gltf.callbacks = options.callbacks;
  return gltf;
}

}  // namespace planish
