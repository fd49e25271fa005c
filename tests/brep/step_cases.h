#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "brep/step_file.h"
#include "limit/limit_case.h"
#include "planish/brep/brep.h"
#include "planish/brep/write_step.h"

namespace planish::test {

inline std::string scratch(const std::string& name) {
  return (std::filesystem::path(testing::TempDir()) / name).string();
}

inline std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline StepFile written(const LimitCase& c, const Brep& brep, const std::string& path) {
  write_step(path, brep, {.name = "part", .diagonal = c.surface->placement().diagonal});
  return StepFile(path);
}

inline PolygonMesh creased_cube(bool all_around) {
  PolygonMesh mesh = cube();
  // Of the cube's faces those at z = 1 have all edges sharp, or all faces have.
  for (std::int32_t a = 0; a < 8; ++a)
    for (const std::int32_t bit : {1, 2, 4})
      if ((a & bit) == 0 && (all_around || ((a & 4) != 0 && bit != 4)))
        mesh.creases.push_back({a, a | bit});
  return mesh;
}

inline std::vector<NamedMesh> step_meshes() {
  std::vector<NamedMesh> meshes = limit_meshes();
  meshes.push_back({"single triangle", single_polygon(3)});
  meshes.push_back({"300-gon drum", prism(300)});
  meshes.push_back({"hub of 100", bipyramid(100)});
  meshes.push_back({"valence 2", cube_with_split_edges()});
  meshes.push_back({"torus", torus(12, 8, 3, 1)});
  meshes.push_back({"small torus", torus(3, 3, 3, 1)});
  return meshes;
}

}  // namespace planish::test
