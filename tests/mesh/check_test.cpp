#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/sound_topology.h"
#include "support/calls.h"

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
using testing::ElementsAreArray;
using testing::HasSubstr;

std::vector<std::string> messages(const PolygonMesh& mesh) {
  std::vector<std::string> result;
  for (const MeshProblem& problem : check(mesh))
    result.push_back(std::string(name_of(problem.kind)) + " " + std::to_string(problem.element) +
                     ": " + problem.message);
  return result;
}

PolygonMesh cube_with(const std::function<void(PolygonMesh&)>& change) {
  PolygonMesh mesh = cube();
  change(mesh);
  return mesh;
}

PolygonMesh with_offsets(std::vector<std::int32_t> offsets) {
  PolygonMesh mesh = mesh_of(4, {{0, 1, 2}, {0, 2, 3}});
  mesh.face_offsets = std::move(offsets);
  return mesh;
}

PolygonMesh fan(std::int32_t faces) {
  PolygonMesh mesh;
  mesh.positions.resize(faces + 1, glm::dvec3(0.0));
  mesh.positions[0].x = 1;
  for (std::int32_t i = 0; i < faces; ++i)
    mesh.add_face(std::vector{0, 1 + i, 1 + (i + 1) % faces});
  return mesh;
}

// It has one edge more than faces.
PolygonMesh open_fan(std::int32_t faces) {
  PolygonMesh mesh = fan(faces + 1);
  mesh.face_offsets.pop_back();
  mesh.face_vertices.resize(mesh.face_offsets.back());
  return mesh;
}

// Beside another problem check() looks at one element after another.
PolygonMesh with_unknown_corner(PolygonMesh mesh) {
  mesh.corners = {{-1}};
  return mesh;
}

TEST(Check, NamesEveryProblem) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto all_at_one_place = [](PolygonMesh& mesh) {
    for (glm::dvec3& position : mesh.positions) position = {3, 0.5, -1};
    mesh.positions.emplace_back(9, 9, 9);
  };
  const std::string none =
      "no-faces -1: the mesh has no faces; give it some, or save its vertices as points (.xyz, "
      ".ply)";
  const auto fans = [](int count) {
    return "non-manifold-vertex 0: vertex 0 joins " + std::to_string(count) +
           " separate fans of faces; split it";
  };
  const std::string steep =
      "valence-too-high 0: vertex 0 has 65536 edges, at most 65535 can be refined";
  const std::string unknown =
      "unknown-corner-vertex 0: corner 0 names vertex -1, which no face uses";
  const struct {
    std::string name;
    PolygonMesh mesh;
    std::vector<std::string> problems;
  } cases[] = {
      {"tetrahedron", tetrahedron(), {}},
      {"grid", grid(3, 2), {}},
      {"torus", torus(3, 3), {}},
      {"unused vertex", cube_with([](auto& m) { m.positions.emplace_back(9, 9, 9); }), {}},
      {"nothing", {}, {none}},
      {"no offsets", cube_with([](auto& m) { m.face_offsets.clear(); }), {none}},
      {"no extent but for a vertex without faces",
       cube_with(all_at_one_place),
       {"no-extent -1: all vertices of the faces are at (3, 0.5, -1): there is no surface to "
        "make"}},
      {"some extent",
       cube_with([&](auto& m) {
         all_at_one_place(m);
         m.positions[4].z = -2;
       }),
       {}},
      {"positions",
       cube_with([](auto& m) {
         m.positions[2].y = std::nan("");
         m.positions[5].z = -kInfinity;
         m.positions[6].x = 1e151;
         m.positions[7].x = -kMaxCoordinate;
       }),
       {"non-finite-position 2: vertex 2 is at (0, nan, 0)",
        "non-finite-position 5: vertex 5 is at (1, 0, -inf)",
        "non-finite-position 6: vertex 6 is at (1e+151, 1, 1), beyond 1e150"}},
      {"vertices",
       mesh_of(4, {{0, 1, 2}, {2, 1, 4}, {-1, 2, 3}}),
       {"index-out-of-range 1: face 1 names vertex 4 of 4",
        "index-out-of-range 2: face 2 names vertex -1 of 4"}},
      {"offsets beyond the corners",
       with_offsets({0, 7, 6}),
       {"index-out-of-range 0: face 0 spans corners 0 to 7 of 6",
        "index-out-of-range 1: face 1 spans corners 7 to 6 of 6"}},
      {"offsets that end early",
       with_offsets({0, 3}),
       {"index-out-of-range 0: face 0 spans corners 0 to 3 of 6"}},
      {"offsets far off",
       with_offsets({-2147483647, 2147483647}),
       {"index-out-of-range 0: face 0 spans corners -2147483647 to 2147483647 of 6"}},
      {"small faces",
       mesh_of(4, {{0, 1, 2}, {2, 1}, {}}),
       {"face-too-small 1: face 1 has 2 corners, at least 3 are needed",
        "face-too-small 2: face 2 has 0 corners, at least 3 are needed"}},
      {"repeated corner",
       mesh_of(4, {{0, 1, 2}, {3, 0, 2, 0}}),
       {"repeated-corner 1: face 1 names vertex 0 twice"}},
      {"duplicates",
       mesh_of(6, {{0, 1, 2}, {3, 4, 5}, {2, 1, 0}, {1, 2, 0}}),
       {"duplicate-face 2: face 2 has the same vertices as face 0",
        "duplicate-face 3: face 3 has the same vertices as face 0"}},
      // 7^2 + 24^2 = 20^2 + 15^2, the sum by which candidates are found.
      {"no duplicates of equal signatures", mesh_of(25, {{0, 7, 24}, {0, 20, 15}}), {fans(2)}},
      {"winding",
       mesh_of(4, {{0, 1, 2}, {1, 2, 3}}),
       {"inconsistent-winding 1: face 1 runs along edge 1-2 in the same direction as face 0; turn "
        "one of them round"}},
      {"edge of three faces",
       mesh_of(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}),
       {"non-manifold-edge 2: edge 0-1 has 3 faces, at most 2 are possible; among them face 0 and "
        "face 2"}},
      {"closed fans",
       mesh_of(7, {{0, 2, 1},
                   {0, 1, 3},
                   {1, 2, 3},
                   {2, 0, 3},
                   {0, 5, 4},
                   {0, 4, 6},
                   {4, 5, 6},
                   {5, 0, 6}}),
       {fans(2)}},
      {"fans on a boundary", mesh_of(7, {{0, 1, 2}, {0, 3, 4}, {0, 5, 6}}), {fans(3)}},
      {"creases",
       cube_with([](auto& m) {
         m.creases = {{0, 1}, {1, 0}, {0, 3}, {0, 8}, {-1, 2}, {2, 2}};
       }),
       {"unknown-crease-edge 2: crease 2 names 0-3, which is no edge of the mesh",
        "unknown-crease-edge 3: crease 3 names 0-8, which is no edge of the mesh",
        "unknown-crease-edge 4: crease 4 names -1-2, which is no edge of the mesh",
        "unknown-crease-edge 5: crease 5 names 2-2, which is no edge of the mesh"}},
      {"corners",
       cube_with([](auto& m) {
         m.positions.emplace_back(9, 9, 9);
         m.corners = {{7}, {8}, {9}, {-1}};
       }),
       {"unknown-corner-vertex 1: corner 1 names vertex 8, which no face uses",
        "unknown-corner-vertex 2: corner 2 names vertex 9, which no face uses",
        "unknown-corner-vertex 3: corner 3 names vertex -1, which no face uses"}},
      {"sharpness",
       cube_with([&](auto& m) {
         m.creases = {{0, 1, -1}, {0, 1, nan}, {0, 1, std::numeric_limits<float>::infinity()}};
         m.corners = {{3, nan}};
       }),
       {"unknown-crease-edge 1: crease 1 has sharpness nan; a number from 0 is wanted, 10 is "
        "infinite",
        "unknown-corner-vertex 0: corner 0 has sharpness nan; a number from 0 is wanted, 10 is "
        "infinite"}},
      {"numbers of attributes",
       cube_with([](auto& m) {
         m.colors.resize(7);
         m.uvs.resize(1);
         m.face_uvs.resize(25);
         m.groups.resize(1);
         m.face_groups.resize(1);
       }),
       {"wrong-attribute-count -1: 25 corners of the texture where 24 are needed, or none",
        "wrong-attribute-count -1: 7 colours where 8 are needed, or none",
        "wrong-attribute-count -1: 1 groups of faces where 6 are needed, or none"}},
      {"attributes that exist",
       cube_with([](auto& m) {
         m.uvs.resize(4);
         m.face_uvs.assign(24, -1);
         m.groups.resize(2);
         m.face_groups.assign(6, 1);
         m.hole_faces = {0, 5, 5};
       }),
       {}},
      {"attributes that do not",
       cube_with([](auto& m) {
         m.uvs.resize(4);
         m.face_uvs.assign(24, -1);
         m.face_uvs[3] = 4;
         m.face_uvs[23] = -2;
         m.groups.resize(2);
         m.face_groups = {-1, 1, 1, 1, 1, 2};
         m.hole_faces = {6, 5, -1};
       }),
       {"unknown-texture-coordinate 3: the texture coordinate of corner 3 has number 4 of 4",
        "unknown-texture-coordinate 23: the texture coordinate of corner 23 has number -2 of 4",
        "unknown-group 0: the group of face 0 has number -1 of 2",
        "unknown-group 5: the group of face 5 has number 2 of 2",
        "unknown-hole 0: hole 0 is face 6 of 6", "unknown-hole 2: hole 2 is face -1 of 6"}},
      {"highest valence", fan(65535), {}},
      {"highest valence beside another problem", with_unknown_corner(fan(65535)), {unknown}},
      {"valence", fan(65536), {steep}},
      {"valence beside another problem", with_unknown_corner(fan(65536)), {unknown, steep}},
      {"valence of an open fan", open_fan(65535), {steep}},
      {"largest face", polygon(65535), {}},
      {"large face",
       polygon(65536),
       {"valence-too-high 0: face 0 has 65536 corners, at most 65535 can be refined"}},
  };
  for (const auto& row : cases) {
    SCOPED_TRACE(row.name);
    EXPECT_THAT(messages(row.mesh), ElementsAreArray(row.problems));
  }
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

std::string refusal(const PolygonMesh& mesh) {
  return test::message_of(ErrorCode::UnusableMesh, [&] { require_usable(mesh, "bad.obj"); });
}

TEST(RequireUsable, SaysWhatRepairMends) {
  EXPECT_THAT(refusal(mesh_of(4, {{0, 1, 2}, {0, 1, 3}})), HasSubstr("repair() mends"));
  // Beside what nothing mends.
  EXPECT_THAT(refusal(mesh_of(4, {{0, 1, 2}, {0, 1, 3}, {0, 1, 9}})),
              testing::Not(HasSubstr("repair()")));
}

TEST(RequireUsable, NamesTheFirstTenOfMany) {
  PolygonMesh mesh = mesh_of(3, {});
  for (std::int32_t i = 0; i < 12; ++i) mesh.add_face(std::vector{0, 1, 3 + i});
  EXPECT_THAT(refusal(mesh),
              testing::AllOf(testing::StartsWith("bad.obj: 12 problems, the first 10 being:\n"
                                                 "  face 0 names vertex 3 of 3\n"
                                                 "  face 1 names vertex 4 of 3\n"),
                             testing::EndsWith("\n  face 9 names vertex 12 of 3")));
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
