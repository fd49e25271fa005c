#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/files/gltf/asset/asset_vertices.h"
#include "planish/job/job.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

/// What is known of a file before work. 0: as many as the surface's curvature asks for, or STEP.
struct OutputForecast {
  std::int64_t vertices = 0, faces = 0;
};

/// What a job will take, told from its mesh before work.
struct Forecast {
  std::vector<OutputForecast> outputs;  ///< one per planned output
  std::uint64_t peak_bytes = 0;         ///< of host memory; an upper estimate
  std::uint64_t making_bytes = 0;       ///< of these, what one mesh at a time takes besides
  double seconds = 0;                   ///< on this machine's threads, within a factor of three
};

/// That the mesh's faces are cut into: by their share meshes of a file share its triangles.
[[nodiscard]] double triangles_of(const PolygonMesh& mesh);

/// The mesh that files are told by: with triangles joined where they plainly are halves of quads;
/// where measurement will tell, with all of them, of which there are more.
[[nodiscard]] const ReadyFit& expected_fit(const ReadyFit& ready);

/// A mesh that is to be fitted, with what else an asset says of its vertices.
struct MeshNeed {
  const ReadyFit* ready = nullptr;  ///< which can be fitted
  const AssetVertices* vertices = nullptr;
};

/// `page_bytes` is the limit of a page's size, 0 where no page is made. Meshes of an asset are
/// fitted one after another and held until their surfaces are in the file; `asset_bytes` are the
/// asset's own.
[[nodiscard]] Forecast forecast_of(std::span<const MeshNeed> meshes, const Settings& settings,
                                   const std::vector<PlannedOutput>& outputs,
                                   std::uint64_t page_bytes, std::uint64_t asset_bytes = 0);

/// Of a job on a cloud: what it would take if their mesh went through all that are meshed at
/// first; nothing of the files. Without a peak where an output's fineness asks for the mesh.
[[nodiscard]] Forecast forecast_of_points(const PointCloud& cloud, const Settings& settings,
                                          const std::vector<PlannedOutput>& outputs,
                                          std::uint64_t page_bytes);

/// Throws Error{OutOfMemory} where the levels asked for need more than the machine has free, naming
/// the need and the highest level that fits.
void require_memory_for(std::span<const MeshNeed> meshes, const Settings& settings,
                        const std::vector<PlannedOutput>& outputs);

}  // namespace planish
