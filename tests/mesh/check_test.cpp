#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/sound_topology.h"

namespace planish::test {
namespace {

// Of meshes without a problem at once, not by the way that lists problems one by one.
TEST(SoundTopology, IsThatOfMeshesWithoutProblemsAlone) {
  for (const std::int32_t corners : {3, 12, 13, 40}) {
    PolygonMesh mesh = polygon(corners);
    EXPECT_TRUE(sound_topology(mesh)) << corners;
    mesh.face_vertices[2] = mesh.face_vertices[0];
    EXPECT_FALSE(sound_topology(mesh)) << corners << ", one twice";
  }
  for (const PolygonMesh& mesh : {tetrahedron(), cube(), torus(5, 4)}) {
    const auto topology = sound_topology(mesh);
    ASSERT_TRUE(topology);
    EXPECT_EQ(topology->corner_count(), std::ssize(mesh.face_vertices));
  }
}

// Two triangles and one large face around vertex 12, which that face passes twice: one fan.
TEST(SoundTopology, NoFaceNamesAVertexTwiceWhereAllElseIsSound) {
  const std::vector<std::int32_t> twice{12, 2, 5, 6, 7, 8, 1, 12, 4, 9, 10, 11, 0, 3};
  const PolygonMesh mesh = mesh_of(13, {{12, 1, 2}, twice, {12, 3, 4}});
  EXPECT_TRUE(MeshTopology::if_manifold(mesh));
  EXPECT_FALSE(sound_topology(mesh));
}

// Two faces of the same vertices with another between them around the lowest of these.
TEST(SoundTopology, NoTwoFacesHaveTheSameVertices) {
  const PolygonMesh mesh = mesh_of(6, {{4, 1, 2, 3, 0}, {4, 3, 2, 0, 1}, {4, 0, 2, 5}});
  EXPECT_TRUE(MeshTopology::if_manifold(mesh));
  EXPECT_FALSE(sound_topology(mesh));
}

}  // namespace
}  // namespace planish::test

namespace planish {
namespace {

using Kind = MeshProblemKind;
using test::cube;
using test::grid;
using test::mesh_of;
using test::polygon;
using test::tetrahedron;
using test::torus;
using testing::ElementsAre;
using testing::IsEmpty;

std::vector<std::string> messages(const PolygonMesh& mesh) {
  std::vector<std::string> result;
  for (const MeshProblem& problem : check(mesh))
    result.push_back(std::string(name_of(problem.kind)) + " " + std::to_string(problem.element) +
                     ": " + problem.message);
  return result;
}

TEST(Check, PassesClosedAndOpenMeshes) {
  EXPECT_THAT(messages(tetrahedron()), IsEmpty());
  EXPECT_THAT(messages(cube()), IsEmpty());
  EXPECT_THAT(messages(grid(3, 2)), IsEmpty());
  EXPECT_THAT(messages(torus(3, 3)), IsEmpty());
}

TEST(Check, PassesUnusedVertices) {
  PolygonMesh mesh = cube();
  mesh.positions.emplace_back(9, 9, 9);
  EXPECT_THAT(messages(mesh), IsEmpty());
}

TEST(Check, NoFaces) {
  const std::string none =
      "no-faces -1: the mesh has no faces; give it some, or save its vertices as points (.xyz, "
      ".ply)";
  EXPECT_THAT(messages(PolygonMesh{}), ElementsAre(none));
  PolygonMesh no_offsets = cube();
  no_offsets.face_offsets.clear();
  EXPECT_THAT(messages(no_offsets), ElementsAre(none));
}

// Vertices that no face names do not count.
TEST(Check, NoExtent) {
  PolygonMesh mesh = cube();
  for (glm::dvec3& position : mesh.positions) position = {3, 0.5, -1};
  mesh.positions.emplace_back(9, 9, 9);
  EXPECT_THAT(messages(mesh),
              ElementsAre("no-extent -1: all vertices of the faces are at (3, 0.5, -1): there is "
                          "no surface to make"));
  mesh.positions[4].z = -2;
  EXPECT_THAT(messages(mesh), IsEmpty());
}

TEST(Check, NonFinitePosition) {
  PolygonMesh mesh = cube();
  mesh.positions[2].y = std::numeric_limits<double>::quiet_NaN();
  mesh.positions[5].z = -std::numeric_limits<double>::infinity();
  mesh.positions[6].x = 1e151;
  mesh.positions[7].x = -kMaxCoordinate;
  EXPECT_THAT(messages(mesh),
              ElementsAre("non-finite-position 2: vertex 2 is at (0, nan, 0)",
                          "non-finite-position 5: vertex 5 is at (1, 0, -inf)",
                          "non-finite-position 6: vertex 6 is at (1e+151, 1, 1), beyond 1e150"));
}

TEST(Check, IndexOutOfRange) {
  EXPECT_THAT(messages(mesh_of(4, {{0, 1, 2}, {2, 1, 4}, {-1, 2, 3}})),
              ElementsAre("index-out-of-range 1: face 1 names vertex 4 of 4",
                          "index-out-of-range 2: face 2 names vertex -1 of 4"));
}

TEST(Check, OffsetsThatLeaveTheCorners) {
  PolygonMesh mesh = mesh_of(4, {{0, 1, 2}, {0, 2, 3}});
  mesh.face_offsets = {0, 7, 6};
  EXPECT_THAT(messages(mesh),
              ElementsAre("index-out-of-range 0: face 0 spans corners 0 to 7 of 6",
                          "index-out-of-range 1: face 1 spans corners 7 to 6 of 6"));
  mesh.face_offsets = {0, 3};
  EXPECT_THAT(messages(mesh),
              ElementsAre("index-out-of-range 0: face 0 spans corners 0 to 3 of 6"));
  mesh.face_offsets = {-2147483647, 2147483647};
  EXPECT_THAT(messages(mesh), ElementsAre("index-out-of-range 0: face 0 spans corners -2147483647 "
                                          "to 2147483647 of 6"));
}

TEST(Check, FaceTooSmall) {
  EXPECT_THAT(messages(mesh_of(4, {{0, 1, 2}, {2, 1}, {}})),
              ElementsAre("face-too-small 1: face 1 has 2 corners, at least 3 are needed",
                          "face-too-small 2: face 2 has 0 corners, at least 3 are needed"));
}

TEST(Check, RepeatedCorner) {
  EXPECT_THAT(messages(mesh_of(4, {{0, 1, 2}, {3, 0, 2, 0}})),
              ElementsAre("repeated-corner 1: face 1 names vertex 0 twice"));
}

TEST(Check, DuplicateFace) {
  EXPECT_THAT(messages(mesh_of(6, {{0, 1, 2}, {3, 4, 5}, {2, 1, 0}, {1, 2, 0}})),
              ElementsAre("duplicate-face 2: face 2 has the same vertices as face 0",
                          "duplicate-face 3: face 3 has the same vertices as face 0"));
}

TEST(Check, FacesWithEqualSignaturesAreNoDuplicates) {
  // 7^2 + 24^2 = 20^2 + 15^2, the sum by which candidates are found.
  EXPECT_THAT(messages(mesh_of(25, {{0, 7, 24}, {0, 20, 15}})),
              ElementsAre("non-manifold-vertex 0: vertex 0 joins 2 separate fans of faces; split "
                          "it"));
}

TEST(Check, InconsistentWinding) {
  EXPECT_THAT(
      messages(mesh_of(4, {{0, 1, 2}, {1, 2, 3}})),
      ElementsAre("inconsistent-winding 1: face 1 runs along edge 1-2 in the same direction "
                  "as face 0; turn one of them round"));
}

TEST(Check, NonManifoldEdge) {
  EXPECT_THAT(
      messages(mesh_of(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})),
      ElementsAre("non-manifold-edge 2: edge 0-1 has 3 faces, at most 2 are possible; among "
                  "them face 0 and face 2"));
}

TEST(Check, NonManifoldVertexBetweenClosedFans) {
  PolygonMesh mesh = tetrahedron();
  for (int i = 0; i < 3; ++i) mesh.positions.emplace_back(-1 - i, i * i, 0);
  for (const std::vector<std::int32_t>& face :
       {std::vector<std::int32_t>{0, 5, 4}, {0, 4, 6}, {4, 5, 6}, {5, 0, 6}})
    mesh.add_face(face);
  EXPECT_THAT(messages(mesh),
              ElementsAre("non-manifold-vertex 0: vertex 0 joins 2 separate fans of faces; split "
                          "it"));
}

TEST(Check, NonManifoldVertexOnABoundary) {
  EXPECT_THAT(messages(mesh_of(7, {{0, 1, 2}, {0, 3, 4}, {0, 5, 6}})),
              ElementsAre("non-manifold-vertex 0: vertex 0 joins 3 separate fans of faces; split "
                          "it"));
}

TEST(Check, UnknownCreaseEdge) {
  PolygonMesh mesh = cube();
  mesh.creases = {{0, 1}, {1, 0}, {0, 3}, {0, 8}, {-1, 2}, {2, 2}};
  EXPECT_THAT(
      messages(mesh),
      ElementsAre("unknown-crease-edge 2: crease 2 names 0-3, which is no edge of the mesh",
                  "unknown-crease-edge 3: crease 3 names 0-8, which is no edge of the mesh",
                  "unknown-crease-edge 4: crease 4 names -1-2, which is no edge of the mesh",
                  "unknown-crease-edge 5: crease 5 names 2-2, which is no edge of the "
                  "mesh"));
}

TEST(Check, UnknownCornerVertex) {
  PolygonMesh mesh = cube();
  mesh.positions.emplace_back(9, 9, 9);
  mesh.corners = {{7}, {8}, {9}, {-1}};
  EXPECT_THAT(messages(mesh),
              ElementsAre("unknown-corner-vertex 1: corner 1 names vertex 8, which no face uses",
                          "unknown-corner-vertex 2: corner 2 names vertex 9, which no face uses",
                          "unknown-corner-vertex 3: corner 3 names vertex -1, which no face uses"));
}

TEST(Check, NanSharpness) {
  PolygonMesh mesh = cube();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  mesh.creases = {{0, 1, -1}, {0, 1, nan}, {0, 1, std::numeric_limits<float>::infinity()}};
  mesh.corners = {{3, nan}};
  EXPECT_THAT(messages(mesh),
              ElementsAre("unknown-crease-edge 1: crease 1 has sharpness nan; a number from 0 is "
                          "wanted, 10 is infinite",
                          "unknown-corner-vertex 0: corner 0 has sharpness nan; a number from 0 is "
                          "wanted, 10 is infinite"));
}

TEST(Check, AttributesOfTheWrongNumber) {
  PolygonMesh mesh = cube();
  mesh.colors.resize(7);
  mesh.uvs.resize(1);
  mesh.face_uvs.resize(25);
  mesh.groups.resize(1);
  mesh.face_groups.resize(1);
  EXPECT_THAT(
      messages(mesh),
      ElementsAre(
          "wrong-attribute-count -1: 25 corners of the texture where 24 are needed, or none",
          "wrong-attribute-count -1: 7 colours where 8 are needed, or none",
          "wrong-attribute-count -1: 1 groups of faces where 6 are needed, or none"));
}

TEST(Check, AttributesThatDoNotExist) {
  PolygonMesh mesh = cube();
  mesh.uvs.resize(4);
  mesh.face_uvs.assign(24, -1);
  mesh.groups.resize(2);
  mesh.face_groups.assign(6, 1);
  mesh.hole_faces = {0, 5, 5};
  EXPECT_THAT(messages(mesh), IsEmpty());
  mesh.face_uvs[3] = 4;
  mesh.face_uvs[23] = -2;
  mesh.face_groups[0] = -1;
  mesh.face_groups[5] = 2;
  mesh.hole_faces = {6, 5, -1};
  EXPECT_THAT(
      messages(mesh),
      ElementsAre(
          "unknown-texture-coordinate 3: the texture coordinate of corner 3 has number 4 of 4",
          "unknown-texture-coordinate 23: the texture coordinate of corner 23 has number -2 of 4",
          "unknown-group 0: the group of face 0 has number -1 of 2",
          "unknown-group 5: the group of face 5 has number 2 of 2",
          "unknown-hole 0: hole 0 is face 6 of 6", "unknown-hole 2: hole 2 is face -1 of 6"));
}

// Beside another problem, which makes check() look at one element after another.
TEST(Check, TheHighestValenceIsNoProblem) {
  for (const std::int32_t valence : {65535, 65536}) {
    PolygonMesh mesh;
    mesh.positions.resize(valence + 1, glm::dvec3(0.0));
    mesh.positions[0].x = 1;
    for (std::int32_t i = 0; i < valence; ++i)
      mesh.add_face(std::vector{0, 1 + i, 1 + (i + 1) % valence});
    mesh.corners = {{-1}};
    EXPECT_EQ(check(mesh).size(), valence == 65535 ? 1u : 2u);
  }
}

PolygonMesh fan(std::int32_t faces) {
  PolygonMesh mesh;
  mesh.positions.resize(faces + 1, glm::dvec3(0.0));
  mesh.positions[0].x = 1;
  for (std::int32_t i = 0; i < faces; ++i)
    mesh.add_face(std::vector{0, 1 + i, 1 + (i + 1) % faces});
  return mesh;
}

TEST(Check, ValenceTooHighAtAVertex) {
  EXPECT_THAT(messages(fan(65535)), IsEmpty());
  EXPECT_THAT(messages(fan(65536)),
              ElementsAre("valence-too-high 0: vertex 0 has 65536 edges, at most 65535 can be "
                          "refined"));
  // Counted one by one only where the mesh has another problem.
  PolygonMesh other = fan(65535);
  other.corners = {{-1}};
  EXPECT_THAT(messages(other), ElementsAre(testing::StartsWith("unknown-corner-vertex 0")));
  // An open fan has one edge more than faces.
  PolygonMesh open = fan(65536);
  open.face_offsets.pop_back();
  open.face_vertices.resize(open.face_offsets.back());
  EXPECT_THAT(messages(open),
              ElementsAre("valence-too-high 0: vertex 0 has 65536 edges, at most 65535 can be "
                          "refined"));
}

TEST(Check, ValenceTooHighOfAFace) {
  EXPECT_THAT(messages(polygon(65536)),
              ElementsAre("valence-too-high 0: face 0 has 65536 corners, at most 65535 can be "
                          "refined"));
}

// Whoever makes limit masks of it asks for their size.
TEST(Check, FacesMayHaveAsManyCornersAsCanBeRefined) {
  EXPECT_THAT(messages(polygon(65535)), IsEmpty());
}

TEST(Check, OrdersByKindThenElement) {
  PolygonMesh mesh = mesh_of(5, {{0, 1}, {0, 1, 9}, {2, 2, 3}, {0, 2, 8}});
  mesh.positions[4].x = std::numeric_limits<double>::infinity();
  std::vector<std::pair<Kind, std::int64_t>> found;
  for (const MeshProblem& problem : check(mesh)) found.emplace_back(problem.kind, problem.element);
  EXPECT_THAT(
      found, ElementsAre(std::pair(Kind::NonFinitePosition, 4), std::pair(Kind::IndexOutOfRange, 1),
                         std::pair(Kind::IndexOutOfRange, 3), std::pair(Kind::FaceTooSmall, 0),
                         std::pair(Kind::RepeatedCorner, 2)));
}

TEST(Check, SurvivesGarbage) {
  std::mt19937 random(7);
  for (int round = 0; round < 3000; ++round) {
    PolygonMesh mesh;
    // Narrow ranges make meshes that pass the early checks and reach the later ones.
    const std::int32_t range = round % 3 == 0 ? 2147483647 : 3 + static_cast<int>(random() % 9);
    const auto number = [&] {
      return std::uniform_int_distribution<std::int32_t>(round % 3 == 2 ? 0 : -1, range)(random);
    };
    mesh.positions.resize(random() % 12, glm::dvec3(number()));
    mesh.face_vertices.resize(random() % 40);
    for (auto& vertex : mesh.face_vertices) vertex = number();
    if (round % 2 == 0) {
      for (unsigned i = random() % 9; i > 0; --i) mesh.face_offsets.push_back(number());
    } else {
      for (std::int32_t end = 3; end <= static_cast<int>(mesh.face_vertices.size()); end += 3)
        mesh.face_offsets.push_back(end);
      mesh.face_vertices.resize(mesh.face_offsets.back());
    }
    for (unsigned i = random() % 4; i > 0; --i) mesh.creases.push_back({number(), number()});
    for (unsigned i = random() % 4; i > 0; --i) mesh.corners.push_back({number()});
    for (unsigned i = random() % 4; i > 0; --i) mesh.hole_faces.push_back(number());
    mesh.uvs.resize(random() % 4);
    mesh.groups.resize(random() % 4);
    mesh.colors.resize(random() % 3 == 0 ? random() % 12 : 0);
    mesh.face_uvs.resize(random() % 3 == 0 ? random() % 40 : 0, number());
    mesh.face_groups.resize(random() % 3 == 0 ? random() % 9 : 0, number());
    for (const MeshProblem& problem : check(mesh)) EXPECT_FALSE(problem.message.empty());
  }
}

TEST(RequireUsable, NamesTheFileAndTheProblem) {
  EXPECT_NO_THROW(require_usable(cube(), "cube.obj"));
  try {
    require_usable(mesh_of(3, {{0, 1, 3}}), "bad.obj");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnusableMesh);
    EXPECT_EQ(error.element(), 0);
    EXPECT_STREQ(error.what(), "bad.obj: face 0 names vertex 3 of 3");
  }
}

TEST(RequireUsable, SaysWhatRepairMends) {
  const auto message_of = [](const PolygonMesh& mesh) -> std::string {
    try {
      require_usable(mesh, "bad.obj");
      return "no error";
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_THAT(message_of(mesh_of(4, {{0, 1, 2}, {0, 1, 3}})), testing::HasSubstr("repair() mends"));
  EXPECT_THAT(message_of(mesh_of(3, {{0, 1, 3}})), testing::Not(testing::HasSubstr("repair()")));
  // Beside what nothing mends.
  EXPECT_THAT(message_of(mesh_of(4, {{0, 1, 2}, {0, 1, 3}, {0, 1, 9}})),
              testing::Not(testing::HasSubstr("repair()")));
}

TEST(RequireUsable, NamesTheFirstTenOfMany) {
  PolygonMesh mesh = mesh_of(3, {});
  for (std::int32_t i = 0; i < 12; ++i) mesh.add_face(std::vector{0, 1, 3 + i});
  try {
    require_usable(mesh, "bad.obj");
    FAIL() << "no error";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_TRUE(
        message.starts_with("bad.obj: 12 problems, the first 10 being:\n  face 0 names "
                            "vertex 3 of 3\n  face 1 names vertex 4 of 3\n"))
        << message;
    EXPECT_TRUE(message.ends_with("\n  face 9 names vertex 12 of 3")) << message;
  }
}

TEST(MeshProblemNames, AreDistinct) {
  std::vector<std::string_view> names;
  for (int kind = 0; kind <= static_cast<int>(Kind::NoExtent); ++kind)
    names.push_back(name_of(static_cast<Kind>(kind)));
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
}

}  // namespace
}  // namespace planish
