#include "planish/mend/faults.h"

#include <gmock/gmock.h>

#include <array>

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Two quads beside each other, and one above the first; a vertex has a coordinate.
PolygonMesh three_quads() {
  PolygonMesh mesh;
  for (const auto& [x, y] :
       {std::array{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {2, 1}, {0, 2}, {1, 2}})
    mesh.positions.emplace_back(x, y, 0);
  mesh.add_face(std::array{0, 1, 4, 3});
  mesh.add_face(std::array{1, 2, 5, 4});
  mesh.add_face(std::array{3, 4, 7, 6});
  mesh.face_uvs = mesh.face_vertices;
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  return mesh;
}

TEST(MirroredCharts, AreCutAlongTheirAxis) {
  PolygonMesh mesh = three_quads();
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
  EXPECT_EQ(mesh.face_uvs, mesh.face_vertices);
  // The second one as the first.
  for (const int v : {2, 5}) mesh.uvs[static_cast<std::size_t>(v)].x = 0;
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), ElementsAre(1, 4));
  EXPECT_THAT(mesh.face_uvs, ElementsAre(0, 1, 4, 3, 8, 2, 5, 9, 3, 4, 7, 6));
  EXPECT_EQ(mesh.uvs[8], mesh.uvs[1]);
  EXPECT_EQ(mesh.uvs[9], mesh.uvs[4]);
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
}

// By another set, whose indices are those of the first.
TEST(MirroredCharts, OfASetAreCutInAll) {
  PolygonMesh mesh = three_quads();
  std::vector<glm::dvec2> further = mesh.uvs;
  for (const int v : {6, 7}) further[static_cast<std::size_t>(v)].y = 0;
  EXPECT_THAT(cut_mirrored_charts(mesh, further), ElementsAre(3, 4));
  EXPECT_EQ(mesh.uvs[8], mesh.uvs[3]);
  EXPECT_EQ(mesh.uvs.size(), 10U);
}

TEST(MirroredCharts, FacesWithoutCoordinatesOrAreaCutNothing) {
  PolygonMesh mesh = three_quads();
  for (const int v : {2, 5}) mesh.uvs[static_cast<std::size_t>(v)].x = 0;
  mesh.face_uvs[5] = -1;
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
  mesh = three_quads();
  for (const int v : {2, 5}) mesh.uvs[static_cast<std::size_t>(v)].x = 1;
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
  mesh.face_uvs.clear(), mesh.uvs.clear();
  EXPECT_THAT(cut_mirrored_charts(mesh, mesh.uvs), IsEmpty());
}

}  // namespace
}  // namespace planish
