#include "planish/mend/repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Every face with vertices of its own, each moved by up to `distance` along each axis.
PolygonMesh torn(const PolygonMesh& mesh, double distance, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> offset(-distance, distance);
  PolygonMesh result;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<std::int32_t> corners;
    for (const std::int32_t v : mesh.face(f)) {
      corners.push_back(result.vertex_count());
      result.positions.push_back(mesh.positions[v] +
                                 glm::dvec3(offset(random), offset(random), offset(random)));
    }
    result.add_face(corners);
  }
  return result;
}

// The rule word for word, every vertex against all that stay.
std::vector<std::int32_t> stays_by_search(const PolygonMesh& mesh, double fraction) {
  const double reach = fraction * placement_of(mesh).diagonal;
  std::vector<std::int32_t> stays, target(mesh.positions.size());
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    std::int32_t best = -1;
    for (const std::int32_t other : stays) {
      const double distance = glm::distance(mesh.positions[other], mesh.positions[v]);
      if (distance > reach) continue;
      if (best < 0 || distance < glm::distance(mesh.positions[best], mesh.positions[v]))
        best = other;
    }
    target[v] = best < 0 ? v : best;
    if (best < 0) stays.push_back(v);
  }
  return target;
}

TEST(WeldVertices, JoinsATornCube) {
  WeldedMesh welded = weld_vertices(torn(test::cube(), 1e-4, 1), 1e-3);
  EXPECT_EQ(welded.welded_count, 24 - 8);
  EXPECT_EQ(welded.mesh.vertex_count(), 8);
  EXPECT_THAT(check(welded.mesh), IsEmpty());
  // Too little: nothing meets.
  welded = weld_vertices(torn(test::cube(), 1e-4, 1), 1e-6);
  EXPECT_EQ(welded.welded_count, 0);
  EXPECT_EQ(welded.mesh.vertex_count(), 24);
  EXPECT_THAT(welded.source_vertices, IsEmpty());
}

TEST(WeldVertices, TakesTheNearestVertexThatStays) {
  std::mt19937 random(3);
  for (const double fraction : {1e-12, 1e-3, 0.02, 0.0999}) {
    PolygonMesh mesh;
    for (int i = 0; i < 1500; ++i) {
      mesh.positions.emplace_back(random() % 1000 * 1e-3, random() % 1000 * 1e-3,
                                  random() % 7 * 0.05);
      if (i % 3 == 2) mesh.add_face(std::array{i - 2, i - 1, i});
    }
    const std::vector<std::int32_t> expected = stays_by_search(mesh, fraction);
    const PolygonMesh before = mesh;
    const WeldedMesh welded = weld_vertices(std::move(mesh), fraction);
    for (std::size_t c = 0; c < before.face_vertices.size(); ++c) {
      const std::int32_t vertex = welded.mesh.face_vertices[c];
      const std::int32_t source =
          welded.source_vertices.empty() ? vertex : welded.source_vertices[vertex];
      ASSERT_EQ(source, expected[before.face_vertices[c]]) << fraction;
      EXPECT_EQ(welded.mesh.positions[vertex], before.positions[source]);
    }
  }
}

TEST(WeldVertices, WithinNothingAsksForEqualPositions) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, -0.0}, {1, 1, 0}, {0, 1, 1e-300}};
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{3, 4, 5});
  const WeldedMesh welded = weld_vertices(std::move(mesh), 0);
  EXPECT_EQ(welded.welded_count, 1);
  EXPECT_THAT(welded.mesh.face_vertices, ElementsAre(0, 1, 2, 1, 3, 4));
  EXPECT_THAT(welded.source_vertices, ElementsAre(0, 1, 2, 4, 5));
}

TEST(WeldVertices, CarriesTagsAndColoursAndLeavesDegenerateFacesToRepair) {
  PolygonMesh mesh = test::mesh_of(4, {{0, 1, 2, 3}});
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1e-5, 0}, {0, 1, 0}, {0, 0, 1e-5}, {9, 9, 9}};
  mesh.add_face(std::array{4, 3, 2});
  mesh.add_face(std::array{1, 2, 0});
  for (int v = 0; v < 6; ++v) mesh.colors.emplace_back(0.1 * v, 0, 0, 1);
  mesh.attributes = {{"pair", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, 2}};
  mesh.creases = {{1, 2, 10}, {4, 3, 10}, {0, 99, 10}};
  mesh.corners = {{3, 10}, {4, 10}};
  const WeldedMesh welded = weld_vertices(std::move(mesh), 1e-4);
  EXPECT_EQ(welded.welded_count, 2);
  EXPECT_THAT(welded.source_vertices, ElementsAre(0, 1, 3, 5)) << "unused vertices stay";
  EXPECT_THAT(welded.mesh.face_vertices, ElementsAre(0, 1, 1, 2, 0, 2, 1, 1, 1, 0));
  ASSERT_EQ(welded.mesh.creases.size(), 2u) << "the edge without length is none";
  EXPECT_EQ(welded.mesh.creases[0].v0, 0);
  EXPECT_EQ(welded.mesh.creases[0].v1, 2);
  EXPECT_EQ(welded.mesh.creases[1].v1, 99) << "still unknown";
  EXPECT_EQ(welded.mesh.corners[0].vertex, 2);
  EXPECT_EQ(welded.mesh.corners[1].vertex, 0);
  EXPECT_EQ(welded.mesh.colors[2], glm::vec4(0.3f, 0, 0, 1));
  EXPECT_THAT(welded.mesh.attributes[0].values, ElementsAre(0, 1, 2, 3, 6, 7, 10, 11));
  const RepairedMesh repaired = repair(welded.mesh);
  EXPECT_THAT(check(repaired.mesh), IsEmpty());
  EXPECT_EQ(repaired.mesh.face_count(), 1) << "of three one is degenerate and one a duplicate";
}

TEST(WeldVertices, LeavesUnusableMeshesToCheck) {
  PolygonMesh mesh = test::cube();
  mesh.face_vertices[3] = 77;
  EXPECT_EQ(weld_vertices(PolygonMesh(mesh), 0.05).welded_count, 0);
  mesh = test::cube();
  mesh.positions[2].x = std::nan("");
  EXPECT_EQ(weld_vertices(PolygonMesh(mesh), 0.05).welded_count, 0);
  EXPECT_EQ(weld_vertices(test::mesh_of(0, {}), 0.05).welded_count, 0);
}

TEST(WeldVertices, RefusesOtherFractions) {
  for (const double fraction :
       {-1e-6, 0.1, 1.0, 1e-13, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((void)weld_vertices(test::cube(), fraction), Error) << fraction;
  }
}

TEST(WeldShortEdges, LeavesWhatWouldHaveNoFace) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}};
  mesh.add_face(std::array{0, 1, 2});
  EXPECT_EQ(weld_short_edges(PolygonMesh(mesh)).welded_count, 0);
  mesh.positions.emplace_back(0, 1, 0);
  mesh.add_face(std::array{1, 3, 2});
  const WeldedMesh welded = weld_short_edges(PolygonMesh(mesh));
  EXPECT_EQ(welded.welded_count, 1);
  EXPECT_EQ(welded.first_welded, 1);
  EXPECT_THAT(welded.source_vertices, ElementsAre(0, 2, 3));
}

}  // namespace
}  // namespace planish
