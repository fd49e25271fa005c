#pragma once

#include <filesystem>

#include "planish/backend/backend.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/pipeline/fit_file.h"

namespace planish {

/// What fit_file() does with a glTF that stays one: each mesh is fitted as `how` says, and the
/// asset is written with their surfaces, at each of the options' levels. `how` has the callbacks.
/// Throws as fit_file().
FileFit fit_asset(const GltfAsset& asset, const std::filesystem::path& output,
                  const MeshFitOptions& how, Backend& backend, const FitFileOptions& options);

}  // namespace planish
