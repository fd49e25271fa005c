#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "files/read_bytes.h"
#include "planish/files/readers.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

using testing::ElementsAre;

MeshFile off_of(std::string_view text) { return read_off(test::file_of(text, "a.off")); }

TEST(ReadOff, KeepsPolygonsOfAnySize) {
  const MeshFile file = off_of(
      "OFF\n# planish weights=averaged\n4 2 0\n0 0 0\n1 0 0  # right\n\n1 1 0.1\n0 1 0\n"
      "4 0 1 2 3\n3 2 1 0\n");
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 4, 7));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 3, 2, 1, 0));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(1, 1, 0.1));
  EXPECT_THAT(file.header, ElementsAre("planish weights=averaged"));
  EXPECT_EQ(file.format, FileFormat::Off);
}

TEST(ReadOff, TakesLinesOfAnyLengthBehindAPosition) {
  for (const char* keyword : {"COFF", "NOFF", "STCNOFF", "CNOFF", "OFF", "  OFF # hello"}) {
    const MeshFile file = off_of(std::string(keyword) +
                                 "\n3 1 3\n0 0 0 255 0 0\n1 0 0 0 0 1\n0 1 0 1\n3 0 1 2 255 0 0\n");
    EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2)) << keyword;
  }
}

TEST(ReadOff, ReadsColoursAndTextureCoordinatesOfVertices) {
  const MeshFile bytes = off_of(
      "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 128 0 51 0.25 0.75\n1 0 0 0 0 1 0 0 0 255 1 0\n"
      "0 1 0 0 0 1 x 0 0 255 0 nan\n3 2 1 0 1 0 0\n");
  EXPECT_EQ(bytes.mesh.colors[0].r, 1);
  EXPECT_FLOAT_EQ(bytes.mesh.colors[0].g, 0.21586050f);
  EXPECT_FLOAT_EQ(bytes.mesh.colors[0].a, 0.2f);
  EXPECT_EQ(bytes.mesh.colors[2], glm::vec4(1.0f));
  EXPECT_EQ(bytes.mesh.uvs[0], glm::dvec2(0.25, 0.75));
  EXPECT_THAT(bytes.mesh.face_uvs, ElementsAre(-1, 1, 0));
  EXPECT_THAT(test::codes_of(bytes.warnings),
              ElementsAre("missing-texture-coordinates", "missing-colors", "ignored-colors"));
  const MeshFile shares =
      off_of("COFF\n3 1 0\n0 0 0 1 0.50196078 0\n1 0 0 0 0 0\n0 1 0 0 0 0 0.5\n3 0 1 2\n");
  EXPECT_FLOAT_EQ(shares.mesh.colors[0].g, 0.21586050f);
  EXPECT_EQ(shares.mesh.colors[2].a, 0.5f);
  EXPECT_TRUE(shares.warnings.empty());
}

TEST(ReadOff, ReadsFacesThatGoOverLines) {
  for (const char* body : {"0 0 0\n1 0 0\n1 1 0\n4 0\n1\n2 1\n", "0 0 0 1\n0 0 1 1 0 4 0 1 2 1"}) {
    const MeshFile file = off_of(std::string("OFF\n3 1 0\n") + body);
    EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 1)) << body;
    EXPECT_EQ(file.mesh.positions[2], glm::dvec3(1, 1, 0)) << body;
    EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("wrapped-lines")) << body;
  }
}

// The specification's layout, and what a program writes that takes the machine's own numbers.
TEST(ReadOff, FindsTheLayoutOfABinaryFileByItsCounts) {
  for (const std::endian order : {std::endian::big, std::endian::little}) {
    const bool is_usual = order == std::endian::big;
    std::string bytes = "COFF BINARY\n";
    for (const int count : {3, 1, 0}) test::append<std::int32_t>(bytes, count, order);
    for (int i = 0; i < 3; ++i)
      for (const float value : {i * 1.0f, 2.0f, 3.0f, 1.0f, 0.0f, 0.0f, 1.0f})
        test::append<float>(bytes, value, order);
    for (const int value : {3, 2, 1, 0}) test::append<std::int32_t>(bytes, value, order);
    if (is_usual) test::append<std::int32_t>(bytes, 0, order);
    const MeshFile file = off_of(bytes);
    EXPECT_THAT(file.mesh.face_vertices, ElementsAre(2, 1, 0));
    EXPECT_EQ(file.mesh.positions[2], glm::dvec3(2, 2, 3));
    EXPECT_EQ(file.mesh.colors[1], glm::vec4(1, 0, 0, 1));
    EXPECT_EQ(file.warnings.size(), is_usual ? 0u : 1u);
    bytes.pop_back();
    test::expect_refused("a.off", {{bytes, testing::_}});
  }
  std::string absurd = "OFF BINARY\n";
  for (const int count : {1 << 29, 1, 0})
    test::append<std::int32_t>(absurd, count, std::endian::little);
  test::expect_refused("a.off",
                       {{absurd,
                         "1: count 32 behind the keyword does not fit 12 bytes, nor does it in the "
                         "other byte order"}});
}

TEST(ReadOff, AcceptsTheCountsBehindTheKeyword) {
  for (const char* start : {"OFF 3 1 0\n", "OFF3 1 0\n", "OFF\r\n3 1\r\n"})
    EXPECT_EQ(off_of(std::string(start) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2").mesh.face_count(), 1);
}

TEST(ReadOff, RefusesWrongFiles) {
  test::expect_refused(
      "a.off",
      {{"", "1: the file is empty"},
       {"3 1 0\n", "1: `3` stands in the place of OFF"},
       {"4OFF\n",
        "1: `4OFF`: only three-dimensional OFF with the prefixes ST, C and N can be read"},
       {"OFF\n", "1: the file ends before its counts"},
       {"OFF\n3 x 0\n", "2: count `x` is no integer from 0"},
       {"OFF\n-3 1 0\n", "2: count `-3` is no integer from 0"},
       {"OFF\n3\n", "2: count `` is no integer from 0"},
       {"OFF\n1000000000 0 0\n0 0 0\n",
        "2: header promises 1000000000 vertices, but only 6 bytes follow"},
       {"OFF\n1 9000000000000000000 0\n0 0 0\n",
        "2: header promises 9000000000000000000 faces, but only 6 bytes follow"},
       {"OFF\n1 0 0\n0 nan 0\n", "3: vertex coordinate `nan` is no finite number"},
       {"OFF\n1 0 0\n0 0     \n", "3: vertex coordinate `` is no finite number"},
       {"OFF\n2 0 0\n0 0 0     \n", "3: the file ends at vertex 1 of 2"},
       {"OFF\n1 1 0\n0 0 0\n3 0 1 0\n", "4: face names vertex 1 of 1"},
       {"OFF\n1 1 0\n0 0 0\n3 0 -1 0\n", "4: face names vertex -1 of 1"},
       {"OFF\n1 1 0\n0 0 0\n3 0 a 0\n", "4: face corner `a` is no integer"},
       {"OFF\n1 1 0\n0 0 0\n3 0 0\n", "4: face has 2 corners of 3"},
       {"OFF\n1 1 0\n0 0 0\n-3 0 0\n", "4: face size `-3` is no integer from 0"},
       {"OFF\n1 2 0\n0 0 0\n3 0 0 0\n", "4: the file ends at face 1 of 2"},
       {"OFF\n1 0 0\n0 0 0\n3 0 0 0\n", "4: more follows after the last face"},
       {"OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n4 0\n1\n2\n", "6: face has 1 corner of 4"},
       {"OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n4 0\n1\n2\n1\n1\n", "6: face has 1 corner of 4"}});
}

using test::append;

MeshFile stl_of(std::string_view text) { return read_stl(test::file_of(text, "a.stl")); }

std::string binary_stl(const std::vector<std::array<glm::vec3, 3>>& triangles) {
  std::string bytes(80, 's');
  bytes.replace(0, 6, "solid ");  // many writers of binary files do this
  append<std::uint32_t>(bytes, static_cast<std::uint32_t>(triangles.size()));
  for (const auto& triangle : triangles) {
    bytes.append(12, '\0');
    for (const glm::vec3& corner : triangle)
      for (int axis = 0; axis < 3; ++axis) append<float>(bytes, corner[axis]);
    append<std::uint16_t>(bytes, 0);
  }
  return bytes;
}

std::string facet(std::string_view vertices) {
  return "facet normal 0 0 1\n outer loop\n" + std::string(vertices) + " endloop\nendfacet\n";
}

TEST(ReadStl, WeldsABinaryFileByExactPosition) {
  const MeshFile file = stl_of(binary_stl({{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}},
                                           {{{-0.0f, 0, -0.0f}, {1, 1, 0}, {0, 1, 0}}},
                                           {{{0, 0, 1e-30f}, {1, 1, 1}, {0, 1, 1}}}}));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3, 4, 5, 6));
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 3, 6, 9));
  EXPECT_EQ(file.mesh.positions[3], glm::dvec3(0, 1, 0));
  EXPECT_EQ(file.welded_vertex_count, 2);
  EXPECT_EQ(file.format, FileFormat::Stl);
}

TEST(ReadStl, ReadsText) {
  const MeshFile file = stl_of(
      "Solid a b\n" + facet("vertex 0 0 0\nvertex 1 0 0\nVERTEX 0.1 1e0 0\n") +
      facet("vertex 0 0 0\nvertex .1 1 0\nvertex 0 0 1\n") + "endsolid\nsolid b\nendsolid b\n");
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(0.1, 1, 0));
  EXPECT_EQ(file.welded_vertex_count, 2);
}

TEST(ReadStl, LeavesOutTrianglesWithoutArea) {
  const MeshFile file = stl_of(
      binary_stl({{{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}}, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2));
  EXPECT_EQ(file.dropped_element_count, 1);
  EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("degenerate-triangles"));
  EXPECT_EQ(file.warnings[0].message, "1 triangle without area was left out");
}

TEST(ReadStl, WeldsManyPositionsInTheOrderOfTheFile) {
  std::vector<std::array<glm::vec3, 3>> triangles;
  for (int i = 0; i < 5000; ++i) {
    const auto x = static_cast<float>(i);
    triangles.push_back({{{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}}});
  }
  const MeshFile file = stl_of(binary_stl(triangles));
  ASSERT_EQ(file.mesh.vertex_count(), 10001);
  EXPECT_EQ(file.welded_vertex_count, 4999);
  for (int i = 0; i < 5000; ++i)
    for (int corner = 0; corner < 3; ++corner)
      EXPECT_EQ(file.mesh.positions[file.mesh.face(i)[corner]], glm::dvec3(triangles[i][corner]));
}

TEST(ReadStl, RefusesWrongBinaries) {
  // Its header says `solid`, but an empty mesh would hide the loss.
  const std::string sound = binary_stl({{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}});
  const std::string cut = sound.substr(0, 133);
  std::string none = sound;
  none[80] = 0;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  test::expect_refused(
      "a.stl",
      {{cut, " header promises 1 triangles in 134 bytes, but the file has 133"},
       {"x" + cut.substr(1), " header promises 1 triangles in 134 bytes, but the file has 133"},
       {sound + "x", " header promises 1 triangles in 134 bytes, but the file has 135"},
       {none,
        " header promises 0 triangles in 84 bytes, but the file has 134, which 1 triangles need"},
       {"facet", " neither begins with `solid` nor has a binary header of 84 bytes"},
       {binary_stl({{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}, {{{0, 0, 0}, {nan, 0, 0}, {}}}}),
        " triangle 1 has the coordinate nan"}});
}

TEST(ReadStl, RefusesWrongText) {
  test::expect_refused(
      "a.stl",
      {{"solid\n" + facet("vertex 0 inf 0\n"), "4: vertex coordinate `inf` is no finite number"},
       {"solid\n" + facet("vertex 0 0\n"), "4: vertex coordinate `` is no finite number"},
       {"solid\n" + facet("vertex 0 0 0 0\n"), "4: vertex has a fourth value `0`"},
       {"solid\n" + facet("vertex 0 0 0\n"), "5: facet has 1 vertex, 3 are needed"},
       {"solid\nvertex 0 0 0\n", "2: `vertex` is out of place"},
       {"solid\nfacet\nvertx 0 0 0\n", "3: `vertx` is no word of STL"},
       {"solid\nfacet normal 0 0 1\nouter loop\n", "3: the file ends inside a facet"}});
}

// Of a tetrahedron whose corners each triangle has anew, a step of float32 apart.
TEST(ReadStl, JoinsCornersThatDifferByRounding) {
  constexpr float kStep = 0x1p-20f;  // at 11
  const glm::vec3 a(10, 10, 10), b(11, 10, 10), c(10, 11, 10), d(10, 10, 11);
  const glm::vec3 x(kStep, 0, 0), y(0, -kStep, 0), z(0, kStep, kStep);
  const MeshFile file = stl_of(binary_stl(
      {{{a, c, b}}, {{a + x, b + y, d}}, {{b - x, c + z, d + y}}, {{a + y, d + x, c - y}}}));
  EXPECT_EQ(file.mesh.vertex_count(), 4);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3, 2, 1, 3, 0, 3, 1));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(11, 10, 10));
  EXPECT_EQ(file.welded_vertex_count, 8);
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].code, "joined-corners");
  EXPECT_EQ(file.warnings[0].count, 8);
}

// Three steps are no rounding; what does not close an edge, or would lose a triangle, stays.
TEST(ReadStl, LeavesCornersThatDifferByMore) {
  constexpr float kStep = 0x1p-23f;  // at 1
  const glm::vec3 apart(0, 3 * kStep, 0), near(0, kStep, 0);
  const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(0.5f, 1, 0), e(0.5f, -1, 0);
  const glm::vec3 i(kStep, 0, 0), j(0, kStep, 0);
  const auto vertices_of = [](const std::vector<std::array<glm::vec3, 3>>& triangles) {
    const PolygonMesh mesh = stl_of(binary_stl(triangles)).mesh;
    EXPECT_EQ(mesh.face_count(), 2);
    return mesh.vertex_count();
  };
  EXPECT_EQ(vertices_of({{{a, b, c}}, {{b + near, a + near, e}}}), 4);
  EXPECT_EQ(vertices_of({{{a, b, c}}, {{b + apart, a + apart, e}}}), 6);
  EXPECT_EQ(vertices_of({{{a, b, c}}, {{a + near, e, glm::vec3(-1, 0, 0)}}}), 6);
  EXPECT_EQ(vertices_of({{{a, i, j}}, {{i + near, a + near, b}}}), 5);
}

TEST(ReadStl, PassesOverZerosBehindTheTriangles) {
  const std::string padded =
      binary_stl({{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}}) + std::string(7, '\0');
  const MeshFile file = read_mesh(test::bytes_of(padded), "a.stl", FileFormat::Stl);
  EXPECT_EQ(file.mesh.face_count(), 1);
  EXPECT_THAT(test::messages_of(file.warnings),
              ElementsAre("a.stl: 7 zero bytes behind the triangles, from byte 134 on, are left "
                          "out"));
}

TEST(ReadStl, TellsOfColours) {
  std::string bytes = binary_stl({{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}});
  EXPECT_TRUE(stl_of(bytes).warnings.empty());
  std::string common = bytes;
  common.replace(6, 6, "COLOR=");
  EXPECT_EQ(stl_of(common).warnings.at(0).code, "ignored-colors");
  bytes.back() = static_cast<char>(0xfc);
  EXPECT_EQ(stl_of(bytes).warnings.at(0).count, 1);
}

}  // namespace
}  // namespace planish
