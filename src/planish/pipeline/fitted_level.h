#pragma once

#include <memory>
#include <string_view>

#include "planish/backend/backend.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/write_fitted_surface.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// A level of a fitted mesh's surface, which is made as it is read; what it is made of stands
/// beside it.
struct FittedLevel {
  std::unique_ptr<const DooSabinSurface> doo_sabin;
  std::unique_ptr<const SurfaceMesh> whole;
  std::unique_ptr<SurfaceBlocks> blocks;
};

/// `fitted` must outlive it. Throws as evaluate().
[[nodiscard]] FittedLevel fitted_level(const FittedMesh& fitted, Backend& backend,
                                       const SurfaceFileOptions& options);

/// What is said of it in a glTF. `name`: of mesh and node.
[[nodiscard]] GltfOptions gltf_options_of(const FittedMesh& fitted, std::string_view name,
                                          const SurfaceFileOptions& options);

}  // namespace planish
