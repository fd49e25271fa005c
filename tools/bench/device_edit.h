#pragma once

#include <string>
#include <vector>

#include "bench/group.h"
#include "bench/options.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::bench {

/// Moves of a torus' vertices by recorded edits of an embedding host on the best Vulkan device,
/// beside a warm solve and evaluation of all; nothing without one.
[[nodiscard]] std::vector<Row> bench_device_edits(const Options& options, const PolygonMesh& mesh,
                                                  const std::string& size);

}  // namespace planish::bench
