#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scene.h"

namespace planish::viewer {

/// Pairs of the points that Solve::control_points() has, each edge of their mesh once: those of the
/// scene's mesh, of whose vertices `used` are rows, or with the fair method those of the mesh of
/// level 1.
[[nodiscard]] std::vector<std::uint32_t> cage_edges(const Scene& scene,
                                                    std::span<const std::int32_t> used);

}  // namespace planish::viewer
