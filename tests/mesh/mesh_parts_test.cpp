#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/statistics.h"

namespace planish {
namespace {

TEST(Placement, CentresAndScalesTheUsedVertices) {
  PolygonMesh mesh = test::mesh_of(0, {{0, 1, 2}});
  mesh.positions = {{1, 2, 3}, {3, 2, 3}, {3, 5, 9}, {100, 100, 100}};
  const Placement placement = placement_of(mesh);
  EXPECT_EQ(placement.centre, glm::dvec3(2, 3.5, 6));
  EXPECT_EQ(placement.diagonal, 7.0);  // 2, 3, 6: a Pythagorean quadruple
  EXPECT_EQ(placement.to_unit({3, 5, 9}), glm::dvec3(1, 1.5, 3) / 7.0);
  EXPECT_EQ(placement.to_model(glm::dvec3(0.5)), glm::dvec3(5.5, 7, 9.5));
}

TEST(Placement, CoincidingVerticesGetDiagonalOne) {
  PolygonMesh mesh = test::mesh_of(0, {{0, 1, 2}});
  mesh.positions.assign(3, {4, 5, 6});
  EXPECT_EQ(placement_of(mesh).diagonal, 1.0);
  EXPECT_EQ(placement_of(mesh).centre, glm::dvec3(4, 5, 6));
}

TEST(Placement, MeshWithoutFacesIsLeftInPlace) {
  EXPECT_EQ(placement_of(PolygonMesh{}).diagonal, 1.0);
  EXPECT_EQ(placement_of(PolygonMesh{}).centre, glm::dvec3(0.0));
}

TEST(Placement, NeitherOverflowsNorUnderflows) {
  for (const double scale : {1e150, 1e-200}) {
    PolygonMesh mesh = test::mesh_of(0, {{0, 1, 2}});
    mesh.positions = {{-scale, 0, 0}, {scale, 0, 0}, {0, scale, 0}};
    const double expected = std::sqrt(5.0) * scale;
    EXPECT_NEAR(placement_of(mesh).diagonal / expected, 1.0, 1e-15);
  }
}

using testing::ElementsAre;

PolygonMesh without_face(const PolygonMesh& mesh, std::int32_t left_out) {
  PolygonMesh result;
  result.positions = mesh.positions;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    if (f != left_out) result.add_face(mesh.face(f));
  return result;
}

PolygonMesh together(const std::vector<PolygonMesh>& parts) { return merged_meshes(parts).mesh; }

TEST(Statistics, CountWhatAMeshIsMadeOf) {
  PolygonMesh cube = test::cube();
  cube.positions.emplace_back(9, 9, 9);
  const struct {
    std::string name;
    PolygonMesh mesh;
    std::int64_t unused, edges, boundary_loops, components, genus;
    std::vector<std::int64_t> face_sizes, valences;
  } cases[] = {
      {.name = "cube with an unused vertex",
       .mesh = cube,
       .unused = 1,
       .edges = 12,
       .components = 1,
       .face_sizes = {0, 0, 0, 0, 6},
       .valences = {0, 0, 0, 8}},
      {.name = "torus",
       .mesh = test::torus(5, 4),
       .edges = 40,
       .components = 1,
       .genus = 1,
       .face_sizes = {0, 0, 0, 0, 20},
       .valences = {0, 0, 0, 0, 20}},
      {.name = "plate with a hole",
       .mesh = without_face(test::grid(3, 3), 4),
       .edges = 24,
       .boundary_loops = 2,
       .components = 1,
       .face_sizes = {0, 0, 0, 0, 8},
       .valences = {0, 0, 4, 8, 4}},
      {.name = "three components",
       .mesh = together({test::torus(4, 4), test::torus(3, 5), test::grid(2, 2)}),
       .edges = 74,
       .boundary_loops = 1,
       .components = 3,
       .genus = 2,
       .face_sizes = {0, 0, 0, 0, 35},
       .valences = {0, 0, 4, 4, 32}},
  };
  for (const auto& row : cases) {
    SCOPED_TRACE(row.name);
    const MeshStatistics facts = statistics(row.mesh);
    EXPECT_EQ(facts.vertex_count, row.mesh.vertex_count());
    EXPECT_EQ(facts.unused_vertex_count, row.unused);
    EXPECT_EQ(facts.face_count, row.mesh.face_count());
    EXPECT_EQ(facts.edge_count, row.edges);
    EXPECT_EQ(facts.boundary_loop_count, row.boundary_loops);
    EXPECT_EQ(facts.component_count, row.components);
    EXPECT_EQ(facts.genus, row.genus);
    EXPECT_EQ(facts.face_size_counts, row.face_sizes);
    EXPECT_EQ(facts.valence_counts, row.valences);
  }
}

// Two triangles along an edge, numbered so that vertices 0 and 3 have no face.
TEST(UsedVertices, AreNumberedAnewWithAllThatRidesOnThem) {
  PolygonMesh mesh;
  mesh.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {8, 8, 8}, {1, 1, 0}, {0, 1, 0}};
  mesh.add_face(std::array{1, 2, 4});
  mesh.add_face(std::array{1, 4, 5});
  mesh.creases = {{1, 4, 2}};
  mesh.corners = {{3, 1}, {5, 4}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.face_uvs = {0, 1, 2, 0, 2, 3};
  for (int v = 0; v < 6; ++v) mesh.colors.emplace_back(0.1f * static_cast<float>(v));
  mesh.attributes = {{.name = "heat", .values = {0, 1, 2, 3, 4, 5}}};
  mesh.groups = {{"one", "red"}, {"two", ""}};
  mesh.face_groups = {1, 0};
  mesh.hole_faces = {1};
  const UsedMesh used = without_unused_vertices(mesh);
  const std::vector<std::int32_t> kept{1, 2, 4, 5};
  EXPECT_EQ(used.vertices, kept);
  ASSERT_EQ(used.mesh.vertex_count(), 4);
  for (std::size_t v = 0; v < kept.size(); ++v) {
    EXPECT_EQ(used.mesh.positions[v], mesh.positions[kept[v]]);
    EXPECT_EQ(used.mesh.colors[v], mesh.colors[kept[v]]);
  }
  EXPECT_EQ(used.mesh.face_vertices, (std::vector<std::int32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(used.mesh.face_offsets, mesh.face_offsets);
  ASSERT_EQ(used.mesh.creases.size(), 1u);
  EXPECT_EQ(used.mesh.creases[0].v0, 0);
  EXPECT_EQ(used.mesh.creases[0].v1, 2);
  EXPECT_EQ(used.mesh.creases[0].sharpness, 2);
  ASSERT_EQ(used.mesh.corners.size(), 1u);  // the other's vertex is gone
  EXPECT_EQ(used.mesh.corners[0].vertex, 3);
  EXPECT_EQ(used.mesh.corners[0].sharpness, 4);
  ASSERT_EQ(used.mesh.attributes.size(), 1u);
  EXPECT_EQ(used.mesh.attributes[0].values, (std::vector<float>{1, 2, 4, 5}));
  // What rides on faces stays as it is.
  EXPECT_EQ(used.mesh.uvs, mesh.uvs);
  EXPECT_EQ(used.mesh.face_uvs, mesh.face_uvs);
  EXPECT_EQ(used.mesh.face_groups, mesh.face_groups);
  EXPECT_EQ(used.mesh.hole_faces, mesh.hole_faces);
  ASSERT_EQ(used.mesh.groups.size(), 2u);
  EXPECT_EQ(used.mesh.groups[0].name, "one");
  EXPECT_EQ(used.mesh.groups[0].material, "red");
}

TEST(MergedMeshes, AreComponentsInTheirOrder) {
  PolygonMesh cube = test::cube();
  cube.creases = {{0, 1, 2.0f}};
  cube.corners = {{7}};
  cube.hole_faces = {5};
  const PolygonMesh meshes[] = {test::torus(5, 4), cube, cube};
  const MergedMeshes merged = merged_meshes(meshes);
  EXPECT_THAT(merged.first_vertices, ElementsAre(0, 20, 28, 36));
  EXPECT_THAT(merged.first_faces, ElementsAre(0, 20, 26, 32));
  EXPECT_NO_THROW(require_usable(merged.mesh, "merged"));
  EXPECT_EQ(statistics(merged.mesh).component_count, 3);
  for (int m = 0; m < 3; ++m) {
    const std::int32_t vertex = merged.first_vertices[m], face = merged.first_faces[m];
    for (std::int32_t v = 0; v < meshes[m].vertex_count(); ++v)
      EXPECT_EQ(merged.mesh.positions[vertex + v], meshes[m].positions[v]);
    for (std::int32_t f = 0; f < meshes[m].face_count(); ++f) {
      ASSERT_EQ(merged.mesh.face_size(face + f), meshes[m].face_size(f));
      for (std::int32_t k = 0; k < meshes[m].face_size(f); ++k)
        EXPECT_EQ(merged.mesh.face(face + f)[k], meshes[m].face(f)[k] + vertex);
    }
  }
  ASSERT_EQ(merged.mesh.creases.size(), 2u);
  EXPECT_EQ(merged.mesh.creases[1].v0, 28);
  EXPECT_EQ(merged.mesh.creases[1].v1, 29);
  EXPECT_EQ(merged.mesh.creases[1].sharpness, 2.0f);
  ASSERT_EQ(merged.mesh.corners.size(), 2u);
  EXPECT_EQ(merged.mesh.corners[0].vertex, 27);
  EXPECT_THAT(merged.mesh.hole_faces, ElementsAre(25, 31));
  EXPECT_TRUE(merged.mesh.uvs.empty() && merged.mesh.colors.empty() && merged.mesh.groups.empty());
}

TEST(MergedMeshes, FillUpWhatSomeDoNotHave) {
  PolygonMesh plain = test::grid(1, 1), rich = plain;
  rich.uvs = {{0, 0}, {1, 0}, {1, 1}};
  rich.face_uvs = {0, 1, 2, -1};
  rich.colors.assign(4, glm::vec4(0.5f));
  rich.groups = {{"lid", "steel"}};
  rich.face_groups = {0};
  const PolygonMesh meshes[] = {rich, plain, rich};
  const PolygonMesh mesh = merged_meshes(meshes).mesh;
  EXPECT_EQ(mesh.uvs.size(), 6u);
  EXPECT_THAT(mesh.face_uvs, ElementsAre(0, 1, 2, -1, -1, -1, -1, -1, 3, 4, 5, -1));
  ASSERT_EQ(mesh.colors.size(), 12u);
  EXPECT_EQ(mesh.colors[3], glm::vec4(0.5f));
  EXPECT_EQ(mesh.colors[4], glm::vec4(1));
  EXPECT_EQ(mesh.colors[8], glm::vec4(0.5f));
  EXPECT_THAT(mesh.face_groups, ElementsAre(0, 1, 2));
  ASSERT_EQ(mesh.groups.size(), 3u);
  EXPECT_EQ(mesh.groups[1].name, "");
  EXPECT_EQ(mesh.groups[2].name, "lid");
  EXPECT_NO_THROW(require_usable(mesh, "merged"));
}

TEST(MergedMeshes, TooManyAreRefusedByName) {
  const PolygonMesh meshes[] = {test::cube(), test::cube()};
  EXPECT_EQ(merged_meshes(meshes, 48).mesh.vertex_count(), 16);
  try {
    static_cast<void>(merged_meshes(meshes, 47));  // corners
    FAIL() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_EQ(error.element(), 1);
    EXPECT_THAT(error.what(), testing::HasSubstr("mesh 1 would make 48"));
  }
  EXPECT_EQ(merged_meshes({}).mesh.face_count(), 0);
}

// Three unit squares in a row, then one of half the width hinged to the last and turned by an
// angle.
PolygonMesh hinged_strip(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  PolygonMesh mesh;
  for (const double y : {0.0, 1.0}) {
    for (int x = 0; x < 4; ++x) mesh.positions.emplace_back(x, y, 0);
    mesh.positions.emplace_back(3 + 0.5 * std::cos(angle), y, 0.5 * std::sin(angle));
  }
  for (int x = 0; x < 4; ++x) mesh.add_face(std::array{x, x + 1, x + 6, x + 5});
  return mesh;
}

TEST(FoldedEdges, AreThoseThatTurnByMoreThan120Degrees) {
  EXPECT_EQ(folded_edges(hinged_strip(119)).count, 0);
  EXPECT_EQ(folded_edges(hinged_strip(119)).first_face, -1);
  const FoldedEdges folds = folded_edges(hinged_strip(-121));
  EXPECT_EQ(folds.count, 1);
  EXPECT_EQ(folds.first_face, 2);
  EXPECT_NEAR(folds.area, 1.5 / 3.5, 1e-12);
  EXPECT_THAT(folds.is_beside, ElementsAre(0, 0, 1, 1));
}

TEST(FoldedEdges, FacesWithoutAreaTurnNowhere) {
  PolygonMesh mesh = hinged_strip(170);
  for (const int vertex : {4, 9}) mesh.positions[vertex] = mesh.positions[vertex - 1];
  const FoldedEdges folds = folded_edges(mesh);
  EXPECT_EQ(folds.count, 0);
  EXPECT_EQ(folds.area, 0.0);
}

TEST(FoldedEdges, AreTheSameByTheTopologyAtHand) {
  for (const PolygonMesh& mesh : {hinged_strip(119), hinged_strip(-121), hinged_strip(170)}) {
    const FoldedEdges folds = folded_edges(mesh), same = folded_edges(mesh, MeshTopology(mesh));
    EXPECT_EQ(same.count, folds.count);
    EXPECT_EQ(same.area, folds.area);
    EXPECT_EQ(same.first_face, folds.first_face);
    EXPECT_EQ(same.is_beside, folds.is_beside);
  }
}

TEST(FoldedEdges, AreNoneOnACube) { EXPECT_EQ(folded_edges(test::cube()).count, 0); }

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

InsideOutParts inside_out_of(const PolygonMesh& mesh) {
  return inside_out_parts(mesh, MeshTopology(mesh), statistics(mesh).component_count);
}

TEST(InsideOutParts, AreClosedAndLookInward) {
  EXPECT_EQ(inside_out_of(cube()).count, 0);
  const InsideOutParts one = inside_out_of(turned_over(cube()));
  EXPECT_EQ(one.count, 1);
  EXPECT_EQ(one.first_face, 0);
  EXPECT_EQ(inside_out_of(without_face(turned_over(cube()), 0)).count, 0)
      << "which side of a sheet is outside nobody knows";
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
