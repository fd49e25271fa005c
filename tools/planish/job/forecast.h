#pragma once

#include <cstdint>
#include <vector>

#include "job/job.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/prepared_mesh.h"

namespace planish::command {

/// What a job will take, told from its mesh before work.
struct Forecast {
  std::vector<std::uint64_t> output_bytes;  ///< one per planned output; a .gltf counts its .bin
  std::uint64_t peak_bytes = 0;             ///< of host memory; an upper estimate
  double seconds = 0;                       ///< roughly, on this machine's threads
};

/// Sizes as output_bytes() has them.
[[nodiscard]] Forecast forecast_of(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                   const Settings& settings,
                                   const std::vector<PlannedOutput>& outputs);

/// Throws Error{OutOfMemory} where the levels asked for need more than the machine has free, naming
/// the need and the highest level that fits.
void require_memory_for(const PolygonMesh& mesh, const PreparedMesh& prepared,
                        const Settings& settings, const std::vector<PlannedOutput>& outputs);

}  // namespace planish::command
