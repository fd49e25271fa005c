// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Triangles through the points, chosen greedily from their Delaunay triangulation. Interpolates:
/// corners are the points themselves, and a point that fits nowhere is named by no triangle. The
/// mesh may have holes. Throws Error{UnusableMesh} for fewer than three points or points on a
/// line, Error{Cancelled}.
[[nodiscard]] std::vector<Triangle> mesh_by_advancing_front(std::span<const glm::dvec3> points,
                                                            const Callbacks& callbacks = {});

using TakeTriangles = std::function<void(std::vector<Triangle>)>;

/// The same, with `take` called before the triangulation's memory is given back, which takes a
/// twentieth of the time: who ends then need not wait for it.
void advance_front(std::span<const glm::dvec3> points, const TakeTriangles& take,
                   const Callbacks& callbacks = {});

}  // namespace planish
