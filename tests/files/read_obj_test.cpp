#include "planish/files/obj/read_obj.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_obj_loader.h>

#include "files/read_bytes.h"
#include "support/calls.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

MeshFile obj_of(std::string_view text) { return read_obj(test::file_of(text, "a.obj")); }

constexpr std::string_view kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

std::string with_triangle(std::string_view more) { return std::string(kTriangle).append(more); }

TEST(ReadObj, KeepsPolygonsOfAnySize) {
  const MeshFile file = obj_of(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\n"
      "f 1 2 3 4\nf 1/1 2/2/2 5//3\nf 1 2 3 4 5\nf 1 2\nf\n");
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 4, 7, 12, 14, 14));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 3, 0, 1, 4, 0, 1, 2, 3, 4, 0, 1));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(1, 1, 0));
  EXPECT_EQ(file.format, FileFormat::Obj);
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(ReadObj, CountsNegativeIndicesFromTheLastVertexBefore) {
  const MeshFile file = obj_of(with_triangle("f -3 -2 -1\nv 5 5 5\nf -1 -2 -4\n"));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 3, 2, 0));
}

TEST(ReadObj, AcceptsVerticesAfterTheFacesThatNameThem) {
  EXPECT_THAT(obj_of("f 1 2 3\n" + std::string(kTriangle)).mesh.face_vertices,
              ElementsAre(0, 1, 2));
}

TEST(ReadObj, AcceptsEveryLineEndAndContinuation) {
  for (const std::string& text :
       {std::string("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n"),
        std::string("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3"), with_triangle("f 1 2 \\\n  3\n"),
        with_triangle("f 1\\\r\n2\\\r\n3"), with_triangle("# C:\\models\\\nf 1 2 3"),
        with_triangle("\t f  1\t2 3   # the face")})
    EXPECT_THAT(obj_of(text).mesh.face_vertices, ElementsAre(0, 1, 2)) << text;
}

TEST(ReadObj, ReadsNumbersToTheLastBit) {
  const MeshFile file =
      obj_of("v 0.1 -1.7976931348623157e308 +4.9e-324 1 0.5 0.5 0.5\nv .5 5. -0\n");
  EXPECT_EQ(file.mesh.positions[0].x, 0.1);
  EXPECT_EQ(file.mesh.positions[0].y, -1.7976931348623157e308);
  EXPECT_EQ(file.mesh.positions[0].z, 4.9e-324);
  EXPECT_EQ(file.mesh.positions[1], glm::dvec3(0.5, 5, 0));
  EXPECT_TRUE(std::signbit(file.mesh.positions[1].z));
}

TEST(ReadObj, KeepsCreaseAndCornerTags) {
  const MeshFile file = obj_of(with_triangle(
      "f 1 2 3\nt crease 2/1/0 0 1 2.5\nt crease 4/1/0 0 1 1 2 3\nt crease 4/2/0 0 1 1 2 4 5\n"
      "t corner 1/1/0 2 10\nt corner 2/2/0 0 1 1.5 0\n"));
  std::vector<std::tuple<int, int, float>> creases;
  for (const CreaseEdge& crease : file.mesh.creases)
    creases.emplace_back(crease.v0, crease.v1, crease.sharpness);
  EXPECT_THAT(creases,
              ElementsAre(std::tuple(0, 1, 2.5f), std::tuple(0, 1, 3.0f), std::tuple(1, 2, 3.0f),
                          std::tuple(0, 1, 4.0f), std::tuple(1, 2, 5.0f)));
  std::vector<std::pair<int, float>> corners;
  for (const CornerVertex& corner : file.mesh.corners)
    corners.emplace_back(corner.vertex, corner.sharpness);
  EXPECT_THAT(corners, ElementsAre(std::pair(2, 10.0f), std::pair(0, 1.5f), std::pair(1, 0.0f)));
}

TEST(ReadObj, KeepsTextureCoordinatesByCorner) {
  const MeshFile file = obj_of(with_triangle(
      "vt 0.1 0.2\nvt 3\nf 1 2 3\nf 1/1 2/-1/7 3//1\nvt -1 2 5\nf 1/3 2/4 3/-3\nvt 9 8\n"));
  EXPECT_THAT(file.mesh.uvs, ElementsAre(glm::dvec2(0.1, 0.2), glm::dvec2(3, 0), glm::dvec2(-1, 2),
                                         glm::dvec2(9, 8)));
  EXPECT_THAT(file.mesh.face_uvs, ElementsAre(-1, -1, -1, 0, 1, -1, 2, 3, 0));
  // What no corner names is no attribute.
  EXPECT_THAT(obj_of(with_triangle("vt 0 0\nf 1 2 3\n")).mesh.uvs, IsEmpty());
}

TEST(ReadObj, RefusesWrongTextureCoordinatesOfStrictFiles) {
  test::expect_refused(
      "a.obj",
      {{with_triangle("vt 0 0\nf 1/1 2/1 3/2\n"), "5: face names texture coordinate 2 of 1"},
       {with_triangle("f 1/1 2/1 3/1\n"), "4: face names texture coordinate 1 of 0"},
       {with_triangle("vt 0 0\nf 1/1 2/0 3/1\n"),
        "5: face names texture coordinate 0, but OBJ counts from 1"},
       {with_triangle("vt 0 0\nf 1/1 2/-2 3/1\n"),
        "5: face names texture coordinate -2, but only 1 stand before it"},
       {"vt 0 nan\n", "1: texture coordinate `nan` is no finite number"},
       {"vt\n", "1: texture coordinate without a number"}},
      true);
}

TEST(ReadObj, KeepsMaterialsAndNamesOfGroups) {
  const MeshFile file =
      obj_of(with_triangle("f 1 2 3\no part one\nf 1 2 3\nusemtl red\nf 1 2 3\ng left\nf 1 2 3\n"
                           "g\nf 1 2 3\no\nusemtl\nf 1 2 3\ng never used\n"));
  EXPECT_THAT(file.mesh.face_groups, ElementsAre(0, 1, 2, 3, 2, 0));
  std::vector<std::string> names;
  for (const FaceGroup& group : file.mesh.groups)
    names.push_back(group.name + "|" + group.material);
  EXPECT_THAT(names, ElementsAre("|", "part one|", "part one|red", "left|red"));
  EXPECT_THAT(obj_of(with_triangle("f 1 2 3\ng a\n")).mesh.groups, IsEmpty());
}

TEST(ReadObj, ReadsColoursAsSrgb) {
  const MeshFile file = obj_of("v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0 0.04 1 1 0.25\nf 1 2 3\n");
  ASSERT_EQ(file.mesh.colors.size(), 3u);
  EXPECT_EQ(file.mesh.colors[0], glm::vec4(1));
  // ((0.5 + 0.055) / 1.055)^2.4 and 0.04 / 12.92
  EXPECT_EQ(file.mesh.colors[1], glm::vec4(1, 0.21404114f, 0, 1));
  EXPECT_EQ(file.mesh.colors[2], glm::vec4(0.0030959751f, 1, 1, 0.25f));
  EXPECT_THAT(obj_of("v 0 0 0 1\n").mesh.colors, IsEmpty());
  EXPECT_EQ(obj_of("v 0 0 0 1 1 1 2\nv 0 0 0 1 1 1 -1\n").warnings.at(0).count, 2);
  const MeshFile bytes = obj_of("v 0 0 0 255 -1 0\nv 0 0 0 1 1 1\n");
  EXPECT_EQ(bytes.mesh.colors[0], glm::vec4(1, 0, 0, 1));
  ASSERT_EQ(bytes.warnings.size(), 1u);
  EXPECT_EQ(bytes.warnings[0].message, "1 vertex colour lies outside 0 to 1 and is clamped");
}

TEST(ReadObj, KeepsHoles) {
  const MeshFile file = obj_of(with_triangle("t hole 1/0/0 1\nf 1 2 3\nf 1 2 3\nt hole 1/0/0 0\n"));
  EXPECT_THAT(file.mesh.hole_faces, ElementsAre(1, 0));
}

TEST(ReadObj, CountsWhatCarriesNoSurface) {
  const MeshFile file =
      obj_of(with_triangle("l 1 2\np 3\nvt 0 0\nvn 0 0 1\ng a\nusemtl b\ns off\n"));
  EXPECT_EQ(file.dropped_element_count, 2);
  EXPECT_EQ(file.mesh.face_count(), 0);
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(ReadObj, WarnsOfUnknownLines) {
  const MeshFile file = obj_of(with_triangle("foo 1\nbar\nt foo 1/0/0 0\n"));
  EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("unknown-keyword", "unknown-tag"));
  EXPECT_THAT(test::messages_of(file.warnings),
              ElementsAre("line 4: unknown keyword `foo`; such lines are ignored",
                          "line 6: unknown tag `foo`; such lines are ignored"));
  EXPECT_EQ(file.warnings[0].count, 2);
}

TEST(ReadObj, CollectsTheHeaderOfACage) {
  EXPECT_THAT(
      obj_of("# planish weights=averaged\n# other\n#planish x\n# planish tolerance=1e-06\r\n")
          .header,
      ElementsAre("planish weights=averaged", "planish tolerance=1e-06"));
}

TEST(ReadObj, RefusesWrongNumbers) {
  test::expect_refused(
      "a.obj",
      {{"v 0 0 0\nv nan 0 0\n", "2: vertex coordinate `nan` is no finite number"},
       {"v 1,5 0 0", "1: vertex coordinate `1,5` is no finite number; write 1.5 if that is meant"},
       {"v 0 inf 0", "1: vertex coordinate `inf` is no finite number"},
       {"v 0 1e999 0", "1: vertex coordinate `1e999` is no finite number"},
       {"v 0 0x10 0", "1: vertex coordinate `0x10` is no finite number"},
       {"v 0 +-1 0", "1: vertex coordinate `+-1` is no finite number"},
       {"v 0 0 0 \x01\xff", "1: vertex coordinate `??` is no finite number"},
       {"v 0 0 0\nv 1 nan 0\nv 1 0 0\nf 1 2 3\n", "2: vertex coordinate `nan` is no finite number"},
       {"v 0 0 0\nv 1 nan 0\n", "2: vertex coordinate `nan` is no finite number"},
       {"v 0 \\\n 0 \\\n 0\nv x 0 0\n", "4: vertex coordinate `x` is no finite number"},
       {"# a\nv 1 2\n", "2: vertex has 2 coordinates, 3 are needed"},
       {"Dear reader,\nhow are you?\n",
        "1: unknown keyword `Dear` in a file without vertices: this is no OBJ file"}});
  EXPECT_EQ(obj_of("").mesh.face_count(), 0);
}

// Behind the triangle's three lines.
void expect_lines_refused(const std::vector<test::WrongFile>& lines) {
  std::vector<test::WrongFile> files;
  for (const auto& [line, message] : lines) files.push_back({with_triangle(line), message});
  test::expect_refused("a.obj", files);
}

TEST(ReadObj, RefusesWrongFaces) {
  expect_lines_refused(
      {{"f 1 2 3\nf 1 2 4", "5: face names vertex 4 of 3"},
       {"f 1 2 -4", "4: face names vertex -4, but only 3 stand before it"},
       {"f 0 1 2", "4: face names vertex 0, but OBJ counts from 1"},
       {"f 1 2 99999999999", "4: face names vertex 99999999999 of 3"},
       {"f 1 2 99999999999999999999", "4: face corner `99999999999999999999` is no v/vt/vn"},
       {"f 1 2 x", "4: face corner `x` is no v/vt/vn"},
       {"f 1 2 1.5", "4: face corner `1.5` is no v/vt/vn"},
       {"f 1 2 1/x", "4: face corner `1/x` is no v/vt/vn"},
       {"f 1 2 1/1/1/1", "4: face corner `1/1/1/1` is no v/vt/vn"},
       {"f 1 2 /1", "4: face corner `/1` is no v/vt/vn"},
       {"f 1 2 1/1/1x", "4: face corner `1/1/1x` is no v/vt/vn"}});
}

TEST(ReadObj, RefusesWrongTags) {
  expect_lines_refused(
      {{"t crease 2/1/0 0 3 1", "4: tag names vertex 3 of 3"},
       {"t corner 1/1/0 -1 1", "4: tag vertex `-1` is no index from 0"},
       {"t crease 2/1/0 0 1 nan", "4: tag sharpness `nan` is no number from 0"},
       {"t crease 2/1/0 0 1", "4: tag sharpness `` is no number from 0"},
       {"t crease 999999999999/1/0 0 1 1", "4: tag vertex `` is no index from 0"},
       {"t crease 2/1 0 1 1", "4: tag counts `2/1` are no integers/numbers/strings"},
       {"t crease 3/1/0 0 1 2 1",
        "4: crease of 3 vertices and 1 sharpnesses; pairs of vertices with one sharpness each or "
        "together are needed"},
       {"t corner 1/2/0 0 1 1",
        "4: corner tag of 1 vertices and 2 sharpnesses; one sharpness each or together is needed"},
       {"f 1 2 3\nt hole 1/0/0 1", "5: tag names face 1 of 1"},
       {"f 1 2 3\nt hole 1/0/0 -1", "5: tag face `-1` is no index from 0"}});
}

// tinyobjloader is an independent reader of the same format.
TEST(ReadObj, AgreesWithTinyobjloader) {
  const std::string text =
      "v 0.25 -1e3 2\nv 1 0 0\nv 1 1 0 1\nv 0 1 0.5\nv 0 0 1e-2\nvt 0 0\nvn 0 0 1\n"
      "o part\nf 1/1/1 2/1/1 3/1/1 4/1/1\ng b\nf -5 -1 -3\nf 5//1 4//1 3//1 2//1 1//1\n"
      "t crease 2/1/0 0 1 2.5\nt corner 1/1/0 3 4\n";
  tinyobj::ObjReader oracle;
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;
  ASSERT_TRUE(oracle.ParseFromString(text, "", config)) << oracle.Error();
  std::vector<std::int32_t> vertices, offsets = {0};
  std::vector<tinyobj::tag_t> tags;
  for (const tinyobj::shape_t& shape : oracle.GetShapes()) {
    for (const auto& index : shape.mesh.indices) vertices.push_back(index.vertex_index);
    for (const auto size : shape.mesh.num_face_vertices)
      offsets.push_back(offsets.back() + static_cast<std::int32_t>(size));
    tags.insert(tags.end(), shape.mesh.tags.begin(), shape.mesh.tags.end());
  }
  const PolygonMesh mesh = obj_of(text).mesh;
  EXPECT_EQ(mesh.face_vertices, vertices);
  EXPECT_EQ(mesh.face_offsets, offsets);
  const auto& coordinates = oracle.GetAttrib().vertices;
  ASSERT_EQ(coordinates.size(), 3 * mesh.positions.size());
  for (std::size_t i = 0; i < coordinates.size(); ++i)
    EXPECT_FLOAT_EQ(static_cast<float>(mesh.positions[i / 3][static_cast<int>(i % 3)]),
                    static_cast<float>(coordinates[i]));
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[0].intValues, (std::vector<int>{mesh.creases[0].v0, mesh.creases[0].v1}));
  EXPECT_EQ(static_cast<float>(tags[0].floatValues[0]), mesh.creases[0].sharpness);
  EXPECT_EQ(tags[1].intValues[0], mesh.corners[0].vertex);
}

TEST(ReadObj, PlacesOnlyVerticesThatNoFaceNames) {
  const MeshFile file = obj_of("v 0 0 0\nv 1 nan 0\nv 1 0 0\nv 0 1 0\nf 1 3 4\nv 0 0 -inf\n");
  EXPECT_EQ(file.mesh.positions[1], glm::dvec3(0.0));
  EXPECT_EQ(file.mesh.positions[4], glm::dvec3(0.0));
  EXPECT_THAT(test::messages_of(file.warnings),
              ElementsAre("a.obj:2: vertex coordinate `nan` is no finite number; no face names "
                          "such vertices, which are put at 0 (2 times)"));
  EXPECT_EQ(file.warnings[0].count, 2);
}

TEST(ReadObj, TellsOfNamesThatTakeTheNextLine) {
  const MeshFile file = obj_of(with_triangle("usemtl tex\\\nf 1 2 3\nf 3 2 1\n"));
  EXPECT_EQ(file.mesh.face_count(), 1);
  EXPECT_THAT(test::messages_of(file.warnings),
              ElementsAre("a.obj:4: `usemtl` ends with `\\` and goes on with the next line, which "
                          "is part of the name `tex f 1 2 3`; a name without `\\` at its end keeps "
                          "them apart"));
}

}  // namespace
}  // namespace planish
