#include "planish/pipeline/fitted_level.h"

#include <cmath>
#include <cstdint>
#include <string>

#include "planish/files/file_materials.h"
#include "planish/mesh/folded_edges.h"
#include "planish/mesh/statistics.h"
#include "planish/patches/patch_evaluator.h"
#include "planish/pipeline/mesh_warnings.h"
#include "planish/surface/block_quality.h"

namespace planish {

double share_before_rows(std::span<const int> levels) {
  double rows = 0;
  for (const int level : levels) rows += 0.1 * std::ldexp(1.0, 2 * level);
  return 1 / (1 + rows);
}

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

std::optional<Warning> fold_warning(const FittedMesh& fitted, const FittedLevel& made, int level,
                                    const Callbacks& callbacks) {
  if (const SurfaceQuality* const known = fitted.chosen_quality())
    return fold_warning(fitted, *known);
  if (level < 1) return std::nullopt;
  const FoldedEdges folds = folded_edges(fitted.mesh, *fitted.fit.prepared->topology);
  return fold_warning(fitted,
                      surface_quality(*made.blocks, fitted.mesh, folds.is_beside, callbacks));
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
