#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "planish/backend/backend.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/pipeline/fit_file.h"
#include "planish/pipeline/fit_mesh.h"
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

/// Of the time of a job, when its meshes are fitted and the rows of these levels are to be made: a
/// level takes as its faces do.
[[nodiscard]] double share_before_rows(std::span<const int> levels);

/// `fitted` must outlive it. Throws as evaluate().
[[nodiscard]] FittedLevel fitted_level(const FittedMesh& fitted, Backend& backend,
                                       const SurfaceFileOptions& options);

/// fold_warning() of a fitted mesh whose surface of a level was made: by what was measured to
/// choose it, else of this level from 1 on.
[[nodiscard]] std::optional<Warning> fold_warning(const FittedMesh& fitted, const FittedLevel& made,
                                                  int level, const Callbacks& callbacks);

/// What is said of it in a glTF. `name`: of mesh and node.
[[nodiscard]] GltfOptions gltf_options_of(const FittedMesh& fitted, std::string_view name,
                                          const SurfaceFileOptions& options);

}  // namespace planish
