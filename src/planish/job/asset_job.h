#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/job/job_input.h"
#include "planish/job/staged_files.h"

namespace planish {

/// Why a glTF's scene becomes one mesh: the reason, empty where the settings say so; nothing: it
/// stays an asset.
[[nodiscard]] std::optional<std::string> reason_to_merge(const Job& job,
                                                         const std::vector<PlannedOutput>& outputs);

/// For jobs that keep no asset: throws Error{InvalidArgument} where a file is to have several
/// levels of detail.
void require_asset_for_lods(const std::vector<PlannedOutput>& outputs);

/// The asset that a job's input is, where the job keeps it: a glTF with triangles all of whose
/// outputs are glTF surfaces. Warns "merged-asset" where that alone is missing. Null: the scene
/// becomes one mesh. Throws Error{UnreadableInput}, as require_asset_for_lods().
[[nodiscard]] std::unique_ptr<const GltfAsset> kept_asset(const Job& job,
                                                          const std::vector<PlannedOutput>& outputs,
                                                          const InputFile& file, JobReport& report,
                                                          const JobContext& context);

/// Runs a step of a mesh of the asset, by its number. False, with the warning "kept-mesh", for one
/// of several that no surface can be made of: it stays as it is.
[[nodiscard]] bool try_mesh(const GltfAsset& asset, std::int64_t number,
                            const std::function<void(const Warning&)>& warn,
                            const std::function<void()>& step);

/// Throws Error{UnusableMesh} where surfaces of none are left.
void require_any(const GltfAsset& asset, std::size_t count);

/// An asset on its way to its files. `file` holds its bytes.
struct AssetJob {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const InputFile& file;
  const GltfAsset& asset;
  JobReport& report;
  StagedFiles& staged;
};

struct AssetResult {
  std::vector<std::byte> stdout_bytes;
  std::vector<FittedMesh> fitted;
};

/// Fits every mesh of the asset by itself, in its own coordinates, and writes the asset with their
/// surfaces. A mesh of several that no surface can be made of stays as it is, with the warning
/// "kept-mesh". The report of one mesh is the job's; those of several stand in JobReport::meshes.
/// Throws planish::Error.
[[nodiscard]] AssetResult run_asset(const AssetJob& work);

}  // namespace planish
