#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::testing {

/// Random meshes, four times: closed, with creases, open with creases, and that with holes.
[[nodiscard]] inline std::vector<test::NamedMesh> random_kinds() {
  std::vector<test::NamedMesh> meshes;
  for (std::uint32_t seed = 1; seed < 5; ++seed) {
    const std::string name = std::to_string(seed);
    meshes.push_back({"closed " + name, test::random_closed_mesh(seed)});
    meshes.push_back(
        {"creases " + name, test::with_random_creases(test::random_closed_mesh(seed), 0.2, seed)});
    meshes.push_back(
        {"open " + name, test::with_random_creases(test::random_open_mesh(seed), 0.1, seed)});
    PolygonMesh holed = meshes.back().mesh;
    holed.hole_faces = {2, 5, holed.face_count() - 1};
    meshes.push_back({"holes " + name, holed});
  }
  return meshes;
}

/// As a device is given them. (GCC 12 at -O2 leaves out a conversion to float and back that does
/// not pass through memory.)
[[nodiscard]] inline std::vector<glm::dvec3> through_floats(const std::vector<glm::dvec3>& points) {
  const std::vector<glm::vec3> floats(points.begin(), points.end());
  return {floats.begin(), floats.end()};
}

}  // namespace planish::testing
