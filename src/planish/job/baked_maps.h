#pragma once

#include <memory>
#include <span>
#include <vector>

#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/job/job.h"
#include "planish/job/job_outputs.h"
#include "planish/job/job_surface.h"
#include "planish/job/output_plan.h"
#include "planish/job/report.h"
#include "planish/pipeline/baked_gltf.h"

namespace planish {

/// Surfaces of a job that bakes are of level 0, where nobody named one. Throws
/// Error{InvalidArgument} for other levels.
void settle_bake(Job& job);

/// Refuses outputs that hold no baked map with Error{InvalidArgument}.
void require_bakeable(const std::vector<PlannedOutput>& outputs);

/// The maps of a job's surface, of which `low` is level 0; null where it wants none.
[[nodiscard]] std::unique_ptr<const BakedSurface> baked_surface(const FittedJob& work,
                                                                JobSurface& all,
                                                                const JobLevel& low,
                                                                const GltfOptions& gltf);

/// The same of a mesh of an asset.
[[nodiscard]] std::unique_ptr<const BakedAssetMesh> baked_mesh(const FittedJob& work,
                                                               const GltfAsset& asset,
                                                               const AssetMesh& mesh,
                                                               JobSurface& all, const JobLevel& low,
                                                               const AssetAttributes& attributes);

/// Notes them in the report of an output. `mesh`: its name, of an asset.
void note_maps(std::span<const BakedMap> maps, const std::string& mesh, int size,
               WrittenOutput& written);

}  // namespace planish
