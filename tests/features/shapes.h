#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// A shape whose sharp edges are known: those between places for which `is_sharp` holds.
struct FeatureCase {
  std::string name;
  PolygonMesh mesh;
  std::function<bool(const glm::dvec3& a, const glm::dvec3& b)> is_sharp;
};

using Outline2 = std::vector<glm::dvec2>;

/// A polygon of n corners on an ellipse.
[[nodiscard]] Outline2 ellipse(int n, double a, double b);

/// The body over an outline from z = 0 to `height`, the upper outline scaled by `taper`.
[[nodiscard]] PolygonMesh extruded(const Outline2& outline, double height, double taper = 1);
/// The same with a hole of `inner`, which has as many corners.
[[nodiscard]] PolygonMesh hollow(const Outline2& outer, const Outline2& inner, double height);

/// Each face in triangles from its first corner; of concave ones ears are cut off.
[[nodiscard]] PolygonMesh in_fans(const PolygonMesh& mesh);
/// Each face in triangles by ears that are drawn by lot.
[[nodiscard]] PolygonMesh cut_by_lot(const PolygonMesh& mesh, std::uint32_t seed);

/// Families that the constants were looked at with, and such as were held out.
[[nodiscard]] std::vector<FeatureCase> tuned_cases();
[[nodiscard]] std::vector<FeatureCase> held_out_cases();

/// Turned, about an axis that goes with nothing.
[[nodiscard]] PolygonMesh turned(PolygonMesh mesh);

}  // namespace planish::test
