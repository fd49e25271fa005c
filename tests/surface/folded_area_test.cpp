#include "planish/surface/folded_area.h"

#include <gtest/gtest.h>

#include <array>

#include "planish/backend/cpu_backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish {
namespace {

TEST(FoldedArea, IsZeroOnAConvexSurface) {
  const PolygonMesh mesh = test::icosphere(1);
  for (int level = 0; level <= 2; ++level) {
    EXPECT_EQ(folded_area(evaluate(mesh, *make_cpu_backend(), {.level = level}), mesh), 0.0);
  }
}

TEST(FoldedArea, SharesAFacesAreaAmongItsCorners) {
  // Two squares of area 1 and 3; one corner of the larger is turned over.
  PolygonMesh input;
  input.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {4, 0, 0}, {4, 1, 0}};
  input.add_face(std::array{0, 1, 2, 3});
  input.add_face(std::array{1, 4, 5, 2});
  SurfaceMesh surface;
  surface.level = 0;
  surface.positions = input.positions;
  surface.face_offsets = input.face_offsets;
  surface.face_vertices = input.face_vertices;
  surface.normals.assign(6, glm::vec3(0, 0, 1));
  surface.normals[4] = glm::vec3(0, 0, -1);
  EXPECT_DOUBLE_EQ(folded_area(surface, input), 0.75 / 4.0);
}

}  // namespace
}  // namespace planish
