#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// Outlines of flat parts as they are drawn finely, counter-clockwise.
using Outline = std::vector<glm::dvec2>;

/// A square of side 2 whose corners are arcs of `radius` and `steps` edges.
[[nodiscard]] Outline rounded_square(int steps, double radius);
/// Two half circles of `steps` edges, 2 * `length` apart.
[[nodiscard]] Outline slot(int steps, double length);
/// The middle and an arc of `degrees` in `steps` edges.
[[nodiscard]] Outline pie_slice(int steps, double degrees);
/// A circle of `corners` whose radius carries eight harmonics drawn from `seed`.
[[nodiscard]] Outline cam(int corners, std::uint32_t seed);
/// `teeth` teeth of a fifth of the radius, each of whose arcs has `steps` edges.
[[nodiscard]] Outline gear_outline(int teeth, int steps);

/// The prism of height 2 over an outline: face 0 is the upper cap, 1 the lower one; vertex i of the
/// upper rim is corner i.
[[nodiscard]] PolygonMesh prism_over(const Outline& outline);
/// Its rims made sharp.
[[nodiscard]] PolygonMesh with_sharp_rims(PolygonMesh prism);

}  // namespace planish::test
