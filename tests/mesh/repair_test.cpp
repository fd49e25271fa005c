#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <set>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/mend/repair.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> codes(const RepairedMesh& repaired) {
  std::vector<std::string> result;
  for (const Warning& change : repaired.changes) result.push_back(change.code);
  return result;
}

// Usable, with every vertex where its source is.
void expect_sound(const PolygonMesh& input, const RepairedMesh& repaired) {
  for (const MeshProblem& problem : check(repaired.mesh)) ADD_FAILURE() << problem.message;
  ASSERT_EQ(repaired.source_vertices.size(), repaired.mesh.positions.size());
  ASSERT_EQ(repaired.source_faces.size(), static_cast<std::size_t>(repaired.mesh.face_count()));
  for (std::size_t v = 0; v < repaired.source_vertices.size(); ++v) {
    EXPECT_EQ(repaired.mesh.positions[v], input.positions[repaired.source_vertices[v]]);
    if (v < input.positions.size()) {
      EXPECT_EQ(repaired.source_vertices[v], static_cast<std::int32_t>(v));
    }
  }
}

TEST(Repair, LeavesASoundMeshAsItIs) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1, 10}};
  const RepairedMesh repaired = repair(mesh);
  EXPECT_EQ(repaired.mesh.face_vertices, mesh.face_vertices);
  EXPECT_EQ(repaired.mesh.creases.size(), 1u);
  EXPECT_THAT(repaired.changes, IsEmpty());
  EXPECT_THAT(repaired.changed_faces, IsEmpty());
}

TEST(Repair, RemovesRepeatedCornersAndDropsWhatIsNoFace) {
  PolygonMesh mesh = test::mesh_of(5, {{0, 1, 1, 2}, {2, 1, 3}, {0, 0, 1}, {0, 2, 4, 2}});
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_THAT(repaired.mesh.face_vertices, ElementsAre(0, 1, 2, 2, 1, 3));
  EXPECT_THAT(repaired.source_faces, ElementsAre(0, 1));
  EXPECT_THAT(repaired.changed_faces, ElementsAre(0, 2, 3));
  EXPECT_THAT(codes(repaired), ElementsAre("degenerate-faces"));
  EXPECT_EQ(repaired.changes[0].count, 3);
}

// A square of 4 by 4 with a square hole of 2 by 2, its outline joined to the hole's by a bridge
// that runs forth and back; beside it a face at the bridge's end.
TEST(Repair, CutsKeyholedPolygons) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {1, 1, 0},
                    {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {2, -2, 0}};
  mesh.add_face(std::array{0, 1, 2, 3, 0, 4, 5, 6, 7, 4});
  mesh.add_face(std::array{1, 0, 8});
  mesh.uvs.resize(13);
  for (int c = 0; c < 13; ++c) mesh.face_uvs.push_back(c);
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_THAT(codes(repaired), ElementsAre("keyholed-faces"));
  EXPECT_EQ(repaired.changes[0].count, 1);
  EXPECT_THAT(repaired.changed_faces, ElementsAre(0));
  ASSERT_EQ(repaired.mesh.face_count(), 9);
  double area = 0;
  for (int f = 0; f < 8; ++f) {
    EXPECT_EQ(repaired.source_faces[f], 0);
    const glm::dvec3 own = area_vector(repaired.mesh.positions, repaired.mesh.face(f));
    EXPECT_GT(own.z, 0.0);
    area += own.z;
  }
  EXPECT_DOUBLE_EQ(area, 4 * 4 - 2 * 2);
  // Corners keep what rides on them.
  for (int c = 0; c < 24; ++c) {
    EXPECT_EQ(mesh.face_vertices[repaired.mesh.face_uvs[c]], repaired.mesh.face_vertices[c]);
  }
}

TEST(Repair, DropsPolygonsThatCrossThemselves) {
  PolygonMesh mesh = test::tetrahedron();
  mesh.positions.insert(mesh.positions.end(),
                        {{10, 0, 0}, {11, 0, 0}, {10, 1, 0}, {11, 1, 0}, {10.2, 0.1, 0}});
  mesh.add_face(std::array{4, 7, 6, 5, 8, 4, 5});
  expect_sound(mesh, repair(mesh));
}

TEST(Repair, DropsDuplicates) {
  PolygonMesh mesh = test::tetrahedron();
  mesh.add_face(std::vector{2, 1, 0});
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_EQ(repaired.mesh.face_count(), 4);
  EXPECT_THAT(repaired.changed_faces, ElementsAre(4));
}

TEST(Repair, TurnsTheMinorityRound) {
  PolygonMesh mesh = test::cube();
  std::reverse(mesh.face_vertices.begin() + 4, mesh.face_vertices.begin() + 8);
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_THAT(repaired.changed_faces, ElementsAre(1));
  EXPECT_THAT(codes(repaired), ElementsAre("turned-faces"));
  const PolygonMesh cube = test::cube();
  const auto turned = repaired.mesh.face(1);
  const auto original = cube.face(1);
  const auto start = std::find(original.begin(), original.end(), turned[0]) - original.begin();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(turned[i], original[(start + i) % 4]);
}

// By one face already, and whichever comes first.
TEST(Repair, TurnsOneFaceOfThree) {
  for (const std::int32_t face : {0, 1, 2}) {
    PolygonMesh mesh = test::mesh_of(8, {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}});
    std::reverse(mesh.face_vertices.begin() + 4 * face, mesh.face_vertices.begin() + 4 * face + 4);
    EXPECT_THAT(repair(mesh).changed_faces, ElementsAre(face));
  }
}

TEST(Repair, SeparatesThreeSheetsAlongTheirEdges) {
  // Three quads around the line 0-1-2, two quads long: all three become corners.
  const PolygonMesh mesh = test::mesh_of(
      12, {{0, 1, 4, 3}, {1, 2, 5, 4}, {1, 0, 6, 7}, {2, 1, 7, 8}, {0, 1, 10, 9}, {1, 2, 11, 10}});
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_EQ(repaired.mesh.vertex_count(), 12 + 2 * 3);
  EXPECT_THAT(codes(repaired), ElementsAre("non-manifold-edges"));
  EXPECT_EQ(repaired.changes[0].count, 2);
  std::multiset<std::int32_t> corners;
  for (const CornerVertex& corner : repaired.mesh.corners) {
    corners.insert(repaired.source_vertices[corner.vertex]);
  }
  EXPECT_THAT(corners, ElementsAre(0, 0, 0, 1, 1, 1, 2, 2, 2));
}

TEST(Repair, GivesEachFanAVertex) {
  PolygonMesh mesh = test::mesh_of(5, {{0, 1, 2}, {0, 3, 4}});
  mesh.corners = {{0, 10}};
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_THAT(repaired.mesh.face_vertices, ElementsAre(0, 1, 2, 5, 3, 4));
  EXPECT_THAT(codes(repaired), ElementsAre("non-manifold-vertices"));
  EXPECT_THAT(repaired.changed_faces, ElementsAre(1));
  ASSERT_EQ(repaired.mesh.corners.size(), 2u) << "the copy keeps the tag";
  EXPECT_EQ(repaired.mesh.corners[1].vertex, 5);
}

TEST(Repair, CutsAMoebiusStrip) {
  constexpr int kQuads = 5;
  PolygonMesh mesh = test::mesh_of(2 * kQuads, {});
  for (int i = 0; i < kQuads; ++i) {
    const int a = 2 * i, b = 2 * i + 1;
    const bool last = i + 1 == kQuads;
    mesh.add_face(std::vector{a, b, last ? 0 : b + 2, last ? 1 : a + 2});
  }
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_EQ(repaired.mesh.face_count(), kQuads);
  EXPECT_EQ(repaired.mesh.vertex_count(), 2 * kQuads + 2);
}

TEST(Repair, KeepsAttributesWithTheirCornersFacesAndVertices) {
  // A repeated corner, a face to drop, one to turn, a fan to copy.
  PolygonMesh mesh = test::mesh_of(6, {{0, 1, 1, 2}, {3, 3, 4}, {1, 2, 3}, {0, 4, 5}});
  for (int c = 0; c < 13; ++c) {
    mesh.uvs.emplace_back(c, -c);
    mesh.face_uvs.push_back(c);
  }
  for (int v = 0; v < 6; ++v) mesh.colors.emplace_back(0.1 * v, 0, 0, 1);
  mesh.attributes = {{"pair", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, 2}};
  mesh.groups = {{"a", ""}, {"b", ""}, {"c", ""}, {"d", ""}};
  mesh.face_groups = {0, 1, 2, 3};
  mesh.hole_faces = {2};
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_THAT(repaired.mesh.face_groups, ElementsAre(0, 2, 3));
  EXPECT_THAT(repaired.mesh.hole_faces, ElementsAre(1));
  ASSERT_EQ(repaired.mesh.face_uvs.size(), repaired.mesh.face_vertices.size());
  for (std::size_t c = 0; c < repaired.mesh.face_uvs.size(); ++c) {
    const std::int32_t source = repaired.mesh.face_uvs[c];  // texture coordinate c sits at corner c
    EXPECT_EQ(mesh.face_vertices[source], repaired.source_vertices[repaired.mesh.face_vertices[c]]);
  }
  for (std::size_t v = 0; v < repaired.mesh.colors.size(); ++v) {
    const std::int32_t source = repaired.source_vertices[v];
    EXPECT_EQ(repaired.mesh.colors[v], mesh.colors[source]);
    EXPECT_EQ(repaired.mesh.attributes[0].four(v, 0), glm::vec4(2 * source, 2 * source + 1, 0, 0));
  }
  EXPECT_EQ(repaired.mesh.vertex_count(), 7);
}

TEST(Repair, DropsTagsAndHolesThatNameNothing) {
  PolygonMesh mesh = test::cube();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.positions.emplace_back(9, 9, 9);
  mesh.hole_faces = {6, 2, -1};
  mesh.creases = {{0, 7, 10}, {0, 1, nan}, {0, 2, 3}};
  mesh.corners = {{8, 10}, {1, nan}, {2, 4}};
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  EXPECT_THAT(codes(repaired), ElementsAre("unknown-tags", "unknown-holes"));
  EXPECT_EQ(repaired.changes[0].count, 4);
  EXPECT_EQ(repaired.changes[1].count, 2);
  EXPECT_THAT(repaired.mesh.hole_faces, ElementsAre(2));
  ASSERT_EQ(repaired.mesh.creases.size(), 1u);
  EXPECT_EQ(repaired.mesh.creases[0].sharpness, 3);
  ASSERT_EQ(repaired.mesh.corners.size(), 1u);
  EXPECT_EQ(repaired.mesh.corners[0].vertex, 2);
}

// Two tetrahedra that share a vertex, and two sheets that cross at an edge: copies have the tags
// that hold, which of several are the sharpest and the last at a vertex, the last at an edge.
TEST(Repair, GivesCopiesTheTagsThatHold) {
  PolygonMesh mesh = test::mesh_of(6, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {1, 0, 5}});
  mesh.creases = {{0, 1, 2}, {1, 0, 7}};
  mesh.corners = {{0, 10}, {1, 3}, {0, 4}, {1, 5}};
  const RepairedMesh repaired = repair(mesh);
  expect_sound(mesh, repaired);
  ASSERT_EQ(repaired.mesh.vertex_count(), 12);  // each sheet has its own ends of the edge
  for (std::int32_t v = 6; v < 12; ++v) {
    std::vector<float> tags;
    for (const CornerVertex& corner : repaired.mesh.corners)
      if (corner.vertex == v) tags.push_back(corner.sharpness);
    if (repaired.source_vertices[v] == 0) {
      EXPECT_THAT(tags, ElementsAre(10, 4)) << v;
    } else {
      EXPECT_THAT(tags, ElementsAre(5)) << v;
    }
  }
  EXPECT_EQ(repaired.mesh.creases.size(), 4u);
  for (const CreaseEdge& crease : repaired.mesh.creases) EXPECT_EQ(crease.sharpness, 7);
}

// 10^5 copies of one vertex, 10^5 tags of it, of another and of none, and as many creases: work in
// proportion to the product of any two would take a hundred times the processor's time that the
// same mesh takes without tags.
TEST(Repair, TakesLinearTimeForTags) {
  constexpr std::int32_t kMany = 100'000;
  PolygonMesh mesh;
  mesh.positions.resize(2 * kMany + 1);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.positions[v] = {double(v % 512), double(v / 512), double(v % 3)};
  for (std::int32_t i = 0; i < kMany; ++i) mesh.add_face(std::array{0, 2 * i + 1, 2 * i + 2});
  const auto clocks_of = [&] {
    const std::clock_t begin = std::clock();
    const RepairedMesh repaired = repair(mesh);
    EXPECT_EQ(repaired.mesh.vertex_count(), 3 * kMany);
    return std::clock() - begin;
  };
  const std::clock_t bare = clocks_of();
  for (std::int32_t i = 0; i < kMany; ++i) {
    mesh.corners.insert(mesh.corners.end(), {{0, 3}, {-1, 3}, {i + 1, 3}});
    mesh.creases.insert(mesh.creases.end(),
                        {{2 * i + 1, 2 * i + 2}, {0, -1}, {0, 1}, {2 * i + 1, 2 * i + 3}});
  }
  EXPECT_LT(clocks_of(), 20 * bare + CLOCKS_PER_SEC / 2);
}

TEST(Repair, RefusesWhatNoRepairCanSupply) {
  PolygonMesh mesh = test::cube();
  mesh.face_vertices[5] = 99;
  EXPECT_THROW((void)repair(mesh), Error);
  EXPECT_THROW((void)repair(test::mesh_of(3, {{0, 0, 1}})), Error);
}

TEST(Repair, MakesAnySoupUsable) {
  std::mt19937 random(20);
  for (int round = 0; round < 3000; ++round) {
    const int vertices = 4 + static_cast<int>(random() % 8);
    PolygonMesh mesh = test::mesh_of(vertices, {{0, 1, 2}});
    for (int f = static_cast<int>(random() % 14); f > 0; --f) {
      std::vector<std::int32_t> face(3 + random() % 3);
      for (auto& v : face) v = static_cast<std::int32_t>(random() % vertices);
      mesh.add_face(face);
    }
    const auto edge = mesh.face(static_cast<std::int32_t>(random() % mesh.face_count()));
    mesh.creases = {{edge[0], edge[1], 10}};
    mesh.corners = {{edge[2], 10}};
    const RepairedMesh repaired = repair(mesh);
    expect_sound(mesh, repaired);
    if (HasFailure()) FAIL() << "round " << round;
  }
}

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
