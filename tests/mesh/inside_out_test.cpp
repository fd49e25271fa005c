#include "planish/mesh/mesh_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/mesh/statistics.h"

namespace planish {
namespace {

using test::cube;

PolygonMesh turned_over(const PolygonMesh& mesh) {
  PolygonMesh result;
  result.positions = mesh.positions;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<std::int32_t> face(mesh.face(f).begin(), mesh.face(f).end());
    std::ranges::reverse(face);
    result.add_face(face);
  }
  return result;
}

PolygonMesh placed(PolygonMesh mesh, double size, const glm::dvec3& at) {
  for (glm::dvec3& p : mesh.positions) p = size * p + at;
  return mesh;
}

PolygonMesh together(const std::vector<PolygonMesh>& parts) {
  PolygonMesh result;
  for (const PolygonMesh& part : parts) {
    const std::int32_t first = result.vertex_count();
    result.positions.insert(result.positions.end(), part.positions.begin(), part.positions.end());
    for (std::int32_t f = 0; f < part.face_count(); ++f) {
      std::vector<std::int32_t> face;
      for (const std::int32_t v : part.face(f)) face.push_back(v + first);
      result.add_face(face);
    }
  }
  return result;
}

InsideOutParts inside_out_of(const PolygonMesh& mesh) {
  return inside_out_parts(mesh, MeshTopology(mesh), statistics(mesh).component_count);
}

TEST(InsideOutParts, AreClosedAndLookInward) {
  EXPECT_EQ(inside_out_of(cube()).count, 0);
  const InsideOutParts one = inside_out_of(turned_over(cube()));
  EXPECT_EQ(one.count, 1);
  EXPECT_EQ(one.first_face, 0);
  PolygonMesh open;
  open.positions = cube().positions;
  for (std::int32_t f = 1; f < cube().face_count(); ++f) open.add_face(turned_over(cube()).face(f));
  EXPECT_EQ(inside_out_of(open).count, 0) << "which side of a sheet is outside nobody knows";
  PolygonMesh flat = turned_over(cube());
  for (glm::dvec3& p : flat.positions) p.z = 0.1 * p.x + 1e-8 * p.z;
  EXPECT_EQ(inside_out_of(flat).count, 0) << "no room inside";
}

// Far from the origin, where the volumes of single faces are large.
TEST(InsideOutParts, AreToldFromOthersAndFromTheirVoids) {
  const glm::dvec3 far(1e6, -2e6, 3e6);
  const PolygonMesh hollow =
      together({placed(cube(), 10, far), placed(turned_over(cube()), 1, far + glm::dvec3(2.0))});
  EXPECT_EQ(inside_out_of(hollow).count, 0);
  const PolygonMesh mixed = together({hollow, placed(turned_over(cube()), 1, far - glm::dvec3(5.0)),
                                      placed(turned_over(cube()), 1, far + glm::dvec3(50.0))});
  const InsideOutParts found = inside_out_of(mixed);
  EXPECT_EQ(found.count, 2);
  EXPECT_EQ(found.first_face, 12);
}

// A void has more parts beginning before it than are asked: it may lie in any.
TEST(InsideOutParts, StayOpenAmongVeryMany) {
  std::vector<PolygonMesh> parts{placed(cube(), 1000, glm::dvec3(0.0))};
  for (int i = 0; i < 300; ++i)
    parts.push_back(placed(cube(), 0.1, glm::dvec3(1 + 0.2 * i, 2000, 0)));
  parts.push_back(placed(turned_over(cube()), 1, glm::dvec3(100, 1, 1)));
  EXPECT_EQ(inside_out_of(together(parts)).count, 0);
}

}  // namespace
}  // namespace planish
