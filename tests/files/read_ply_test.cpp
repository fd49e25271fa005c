#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "files/read_bytes.h"
#include "planish/files/ply/read_ply.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

using test::append;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

MeshFile ply_of(std::string_view text) { return read_ply(test::file_of(text, "a.ply")); }

constexpr std::string_view kPositions = "property float x\nproperty float y\nproperty float z\n";
constexpr std::string_view kIndices = "property list uchar int vertex_indices\n";

std::string header(std::string_view format, std::string_view elements) {
  return "ply\nformat " + std::string(format) + " 1.0\n" + std::string(elements) + "end_header\n";
}

// Vertices and faces with further properties.
std::string elements_of(int vertices, std::string_view vertex_properties, int faces,
                        std::string_view face_properties = {}) {
  return "element vertex " + std::to_string(vertices) + "\n" + std::string(kPositions) +
         std::string(vertex_properties) + "element face " + std::to_string(faces) + "\n" +
         std::string(kIndices) + std::string(face_properties);
}

std::string ply_text_of(int vertices, int faces, std::string_view body) {
  return header("ascii", elements_of(vertices, "", faces)) + std::string(body);
}

// A triangle with the same values at each vertex.
std::string triangle_with(const std::string& properties, const std::string& values) {
  return header("ascii", elements_of(3, properties, 1)) + "0 0 0 " + values + "\n1 0 0 " + values +
         "\n0 1 0 " + values + "\n3 2 1 0\n";
}

TEST(ReadPly, ReadsTextWithPolygons) {
  const MeshFile file = ply_of(ply_text_of(
      5, 3, "0 0 0\n1 0 0\n1 1 0\n0 1 0.1\n0 0 1\n\n4 0 1 2 3\n3 0 1 4\n5 0 1 2 3 4\n"));
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 4, 7, 12));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 3, 0, 1, 4, 0, 1, 2, 3, 4));
  EXPECT_EQ(file.mesh.positions[3], glm::dvec3(0, 1, 0.1));
  EXPECT_EQ(file.format, FileFormat::Ply);
}

TEST(ReadPly, PassesOverOtherPropertiesAndElements) {
  const MeshFile file =
      ply_of(header("ascii",
                    "comment planish weights=averaged\ncomment other\nobj_info made by hand\n"
                    "element material 1\nproperty list int float values\n"
                    "element vertex 3\nproperty uchar red\n" +
                        std::string(kPositions) +
                        "property float quality\nelement face 1\nproperty list uchar float uv\n"
                        "property list uint8 uint32 vertex_index\nproperty int flags\n"
                        "element edge 2\nproperty int a\n") +
             "2 7 8\n255 0 0 0 nan\n255 1 0 0 nan\n255 0 1 0 nan\n2 0.5 0.5 3 2 1 0 9\n4\n5\n");
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(2, 1, 0));
  EXPECT_EQ(file.mesh.positions[1], glm::dvec3(1, 0, 0));
  EXPECT_EQ(file.dropped_element_count, 2);
  EXPECT_THAT(file.header, ElementsAre("planish weights=averaged"));
}

TEST(ReadPly, ReadsColoursAndTextureCoordinates) {
  const PolygonMesh bytes =
      ply_of(triangle_with("property uchar red\nproperty uchar green\nproperty uchar blue\n"
                           "property uchar alpha\nproperty float s\nproperty float t\n",
                           "255 128 0 51 0.25 0.75"))
          .mesh;
  ASSERT_EQ(bytes.colors.size(), 3u);
  // ((128 / 255 + 0.055) / 1.055)^2.4
  EXPECT_FLOAT_EQ(bytes.colors[1].g, 0.21586050f);
  EXPECT_EQ(bytes.colors[1].r, 1);
  EXPECT_EQ(bytes.colors[1].b, 0);
  EXPECT_FLOAT_EQ(bytes.colors[1].a, 0.2f);
  EXPECT_EQ(bytes.uvs[2], glm::dvec2(0.25, 0.75));
  EXPECT_THAT(bytes.face_uvs, ElementsAre(2, 1, 0));

  const PolygonMesh floats =
      ply_of(triangle_with("property float texture_v\nproperty float texture_u\n"
                           "property float blue\nproperty float green\nproperty float red\n",
                           "3 4 0.04045 0.50196078 1.5"))
          .mesh;
  EXPECT_EQ(floats.colors[0].r, 1);
  EXPECT_FLOAT_EQ(floats.colors[0].g, 0.21586050f);
  EXPECT_FLOAT_EQ(floats.colors[0].b, 0.04045f / 12.92f);
  EXPECT_EQ(floats.uvs[0], glm::dvec2(4, 3));
  // Half of them are none.
  const PolygonMesh half =
      ply_of(triangle_with("property float u\nproperty uchar red\n", "nan 3")).mesh;
  EXPECT_THAT(half.uvs, IsEmpty());
  EXPECT_THAT(half.colors, IsEmpty());
}

std::vector<std::string> names_of(const MeshFile& file) {
  std::vector<std::string> names;
  for (const VertexAttribute& property : file.mesh.attributes) names.push_back(property.name);
  return names;
}

// Whatever their type; lists, and what the convention names, are none.
TEST(ReadPly, KeepsFurtherPropertiesOfVertices) {
  const MeshFile file = ply_of(
      triangle_with("property float nx\nproperty uchar quality\nproperty list uchar int tags\n"
                    "property double Intensity\nproperty int red\n",
                    "0 200 1 7 -0.25 9"));
  EXPECT_THAT(names_of(file), ElementsAre("quality", "Intensity"));
  EXPECT_THAT(file.mesh.attributes[0].values, ElementsAre(200, 200, 200));
  EXPECT_THAT(file.mesh.attributes[1].values, ElementsAre(-0.25f, -0.25f, -0.25f));
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(ReadPly, NamesOfPropertiesAreMadePlainAndTellApart) {
  const MeshFile file = ply_of(
      triangle_with("property float a-b\nproperty float 2nd\nproperty float Q\nproperty float q\n"
                    "property float displayColor\nproperty float " +
                        std::string(80, 'l') + "\n",
                    "1 2 3 4 5 6"));
  EXPECT_THAT(names_of(file), ElementsAre("a_b", "_2nd", "Q"));
  EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("left-out-properties"));
  EXPECT_EQ(file.warnings[0].count, 3);
  EXPECT_THAT(file.warnings[0].message, HasSubstr("property `q` of the vertices"));
}

TEST(ReadPly, TooManyPropertiesAreLeftOut) {
  std::string properties, values;
  for (int i = 0; i < 300; ++i) {
    properties += "property uchar p" + std::to_string(i) + "\n";
    values += std::to_string(i % 256) + " ";
  }
  const MeshFile file = ply_of(triangle_with(properties, values));
  ASSERT_EQ(file.mesh.attributes.size(), 32u);
  EXPECT_THAT(file.mesh.attributes[31].values, ElementsAre(31, 31, 31));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].count, 268);
}

// Also what float32 cannot hold, and words.
TEST(ReadPly, PropertiesThatAreNoNumbersAreZero) {
  const MeshFile file = ply_of(
      triangle_with("property double a\nproperty float b\nproperty float c\nproperty float d\n",
                    "1e300 nan word 4"));
  for (std::size_t k = 0; k < 4; ++k) {
    const float expected = k < 3 ? 0 : 4;
    EXPECT_THAT(file.mesh.attributes[k].values, ElementsAre(expected, expected, expected));
  }
  EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("missing-properties"));
  EXPECT_EQ(file.warnings[0].count, 3);
  test::expect_refused("a.ply",
                       {{triangle_with("property float a\n", "nan"), HasSubstr("a is nan")}}, true);
}

TEST(ReadPly, PointsAloneMakeAMeshWithoutFaces) {
  const MeshFile file =
      ply_of(header("ascii", "element vertex 2\n" + std::string(kPositions)) + "1 2 3\n4 5 6\n");
  EXPECT_EQ(file.mesh.vertex_count(), 2);
  EXPECT_EQ(file.mesh.face_count(), 0);
}

// Every scalar type in both byte orders, as position and as index.
template <class Position, class Index>
void expect_binary(std::string_view position_type, std::string_view index_type) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const std::string type(position_type);
    std::string bytes = header(
        order == std::endian::little ? "binary_little_endian" : "binary_big_endian",
        "element vertex 3\nproperty " + type + " x\nproperty " + type + " y\nproperty " + type +
            " z\nproperty list ushort short extra\nelement face 1\nproperty list int " +
            std::string(index_type) + " vertex_indices\n");
    for (int vertex = 0; vertex < 3; ++vertex) {
      for (int axis = 0; axis < 3; ++axis)
        append<Position>(bytes, static_cast<Position>(10 * vertex + axis), order);
      append<std::uint16_t>(bytes, 1, order);
      append<std::int16_t>(bytes, -1, order);
    }
    append<std::int32_t>(bytes, 3, order);
    for (const int vertex : {2, 0, 1}) append<Index>(bytes, static_cast<Index>(vertex), order);
    const MeshFile file = ply_of(bytes);
    EXPECT_THAT(file.mesh.positions,
                ElementsAre(glm::dvec3(0, 1, 2), glm::dvec3(10, 11, 12), glm::dvec3(20, 21, 22)));
    EXPECT_THAT(file.mesh.face_vertices, ElementsAre(2, 0, 1));
  }
}

// As depth cameras write where they saw nothing: all that such a point has goes.
TEST(ReadPly, PointsWithoutCoordinatesAreCountedAndLeftOut) {
  const std::string start =
      header("ascii", "element vertex 4\n" + std::string(kPositions) +
                          "property float nx\nproperty float ny\nproperty float nz\n"
                          "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                          "property float quality\n");
  const std::string body =
      "0 0 0 0 0 1 255 0 0 1\nnan nan nan 0 1 0 0 255 0 2\n1 0 0 1 0 0 0 0 255 3\n"
      "0 1 -nan(ind) 0 0 1 0 0 0 4\n";
  const MeshFile file = ply_of(start + body);
  EXPECT_EQ(file.missing_count, 2);
  EXPECT_THAT(file.mesh.positions, ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0)));
  EXPECT_THAT(file.normals, ElementsAre(glm::vec3(0, 0, 1), glm::vec3(1, 0, 0)));
  EXPECT_THAT(file.mesh.colors, ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(0, 0, 1, 1)));
  EXPECT_THAT(file.mesh.attributes.at(0).values, ElementsAre(1, 3));
  test::expect_refused("a.ply", {{start + body, HasSubstr("16: vertex 1 of 4: ")}}, true);
  test::expect_refused(
      "a.ply",
      {{start + test::replaced(body, "nan", "inf"), HasSubstr("vertex 1 of 4: x is inf")},
       // A face may name it.
       {ply_text_of(3, 1, "0 0 0\n1 0 0\nnan 1 0\n3 0 1 2\n"), HasSubstr("vertex 2 of 3: ")}});
}

TEST(ReadPly, ReadsEveryScalarTypeInBothByteOrders) {
  expect_binary<std::int8_t, std::uint8_t>("char", "uchar");
  expect_binary<std::uint8_t, std::int8_t>("uint8", "int8");
  expect_binary<std::int16_t, std::uint16_t>("short", "ushort");
  expect_binary<std::uint16_t, std::int16_t>("uint16", "int16");
  expect_binary<std::int32_t, std::uint32_t>("int", "uint");
  expect_binary<std::uint32_t, std::int32_t>("uint32", "int32");
  expect_binary<float, double>("float", "float64");
  expect_binary<double, float>("double", "float32");
}

TEST(ReadPly, RefusesWrongHeaders) {
  const auto text = [](const std::string& elements) { return header("ascii", elements); };
  const auto binary = [](const std::string& elements) {
    return header("binary_little_endian", elements);
  };
  test::expect_refused(
      "a.ply",
      {{"", "1: `` stands in the place of `ply`"},
       {"solid\n", "1: `solid` stands in the place of `ply`"},
       {"ply\nformat ascii 1.0\n", "2: the file ends inside the header"},
       {"ply\nend_header\n", "2: the header names no format"},
       {"ply\nformat ascii 2.0\n", "2: PLY version `2.0` is not 1.0"},
       {"ply\nformat text 1.0\n", "2: unknown format `text`"},
       {text("elemnt vertex 3\n"), "3: unknown keyword `elemnt`"},
       {text("property float x\n"), "3: property before the first element"},
       {text("element vertex -1\n"), "3: element count `-1` is no integer from 0"},
       {text("element vertex 1\nproperty half x\n"), "4: unknown type `half`"},
       {text("element vertex 1\nproperty float\n"), "4: property without a name"},
       {text("element vertex 1\n" + std::string(kPositions) + "property double x\n"),
        "7: element `vertex` has two properties `x`; rename one"},
       {text("element face 1\nproperty list float int vertex_indices\n"),
        "4: a list cannot be counted by a floating-point number"},
       {text("element vertex 1\n" + std::string(kPositions) +
             "element face 1\nproperty int vertex_indices\n") +
            "0 0 0\n3\n",
        "10: element `face` has no list `vertex_indices`"},
       {binary("element face 0\n"), " the header has no element `vertex`"},
       {binary("element vertex 0\nelement vertex 0\n"), " the header has element `vertex` twice"},
       {binary("element vertex 1\n") + "abcdefghijkl", " element `vertex` has no properties"},
       {binary("element vertex 1\nproperty float x\nproperty list uchar float y\n"
               "property float z\n") +
            "abcdefghijkl",
        " element `vertex` has no property `y`"}});
}

TEST(ReadPly, RefusesWrongText) {
  const std::string strip = header("ascii", "element vertex 1\n" + std::string(kPositions) +
                                                "element tristrips 1\n" + std::string(kIndices));
  test::expect_refused(
      "a.ply",
      {{ply_text_of(1, 1, "0 nan 0\n"), "10: vertex 0 of 1: `nan` is no finite number"},
       {ply_text_of(1, 0, "0,5 0 0\n"),
        "10: vertex 0 of 1: `0,5` is no finite number; write 0.5 if that is meant"},
       {ply_text_of(2, 0, "0 0 0\n1     1\n"), "11: vertex 1 of 2 has too few values"},
       {ply_text_of(2, 0, "0 0 0         \n"), "10: the file ends at vertex 1 of 2"},
       {ply_text_of(1, 1, "0 0 0\n3 0 1 0\n"), "11: face 0 of 1 names vertex 1 of 1"},
       {ply_text_of(1, 1, "0 0 0\n3 0 0.5 0\n"), "11: face 0 of 1 names vertex 0.5 of 1"},
       {ply_text_of(1, 1, "0 0 0\n3 0 -1 0\n"), "11: face 0 of 1 names vertex -1 of 1"},
       {ply_text_of(1, 1, "0 0 0\n3 0 0\n"), "11: face 0 of 1 has too few values"},
       {ply_text_of(1, 1, "0 0 0\n300 0 0\n"),
        "11: face 0 of 1: list `vertex_indices` promises 300 values, but no more than 4 can "
        "follow"},
       {ply_text_of(1000000000, 0, "0 0 0\n"),
        "9: header promises 1000000000 of element `vertex`, but only 6 bytes follow"},
       {strip + "0 0 0\n3 0 0 -2\n", "11: tristrips 0 of 1 names vertex -2 of 1"},
       {strip + "0 0 0\n3 0 0 1\n", "11: tristrips 0 of 1 names vertex 1 of 1"},
       // Entries over lines, whose numbers are not as many as wanted.
       {ply_text_of(3, 2, "0 0 0 1 0 0 0 1 0\n3 0 1 2 3 2 1\n"), testing::_},
       {ply_text_of(3, 2, "0 0\n0 1 0 0 0 1 0\n3 0 1 2 3 2 1 0 7\n"), testing::_}});
}

TEST(ReadPly, RefusesWrongBinaries) {
  const auto start = [](const std::string& count, const std::string& faces) {
    return header("binary_little_endian",
                  "element vertex " + count + "\n" + std::string(kPositions) + faces);
  };
  const std::string begin = start("1", "element face 1\n" + std::string(kIndices));
  const std::string vertex = begin + std::string(12, '\0');
  const float inf = std::numeric_limits<float>::infinity();
  test::expect_refused(
      "a.ply",
      {{begin + "0123456789",
        " header promises 1 of element `vertex` of at least 12 bytes, but only 10 bytes follow"},
       {start("9000000000000000000", ""),
        " header promises 9000000000000000000 of element `vertex` of at least 12 bytes, but only 0 "
        "bytes follow"},
       {begin + test::values<float>({0, inf, 0}), " vertex 0 of 1: y is inf"},
       {vertex + "\x03",
        " face 0 of 1: list `vertex_indices` promises 3 values, but no more than 0 can follow"},
       {vertex + "\x01" + test::values<std::int32_t>({1}), " face 0 of 1 names vertex 1 of 1"},
       {start("0", "element face 1\nproperty list char int vertex_indices\n") + "\xff",
        " face 0 of 1: list `vertex_indices` promises -1 values, but no more than 0 can follow"}});
}

TEST(ReadPly, TellsWhatFloatingPointColoursGoUpTo) {
  const auto file_of = [&](const std::string& color) {
    return ply_of(header("ascii", elements_of(3,
                                              "property float diffuse_red\n"
                                              "property float diffuse_green\n"
                                              "property float diffuse_blue\n",
                                              1)) +
                  "0 0 0 " + color + "\n1 0 0 0 0 0\n0 1 0 1 0 0\n3 0 1 2\n");
  };
  const MeshFile bytes = file_of("255 128 0");
  EXPECT_THAT(test::codes_of(bytes.warnings), ElementsAre("color-range"));
  EXPECT_THAT(bytes.warnings[0].message, HasSubstr("numbers up to 255"));
  EXPECT_EQ(bytes.mesh.colors[0].r, 1);
  EXPECT_FLOAT_EQ(bytes.mesh.colors[0].g, 0.21586050f);
  const MeshFile shares = file_of("1.5 0.50196078 -1");
  EXPECT_THAT(test::codes_of(shares.warnings), ElementsAre("clamped-colors"));
  EXPECT_EQ(shares.warnings[0].count, 1);
  EXPECT_FLOAT_EQ(shares.mesh.colors[0].g, 0.21586050f);
  EXPECT_EQ(shares.mesh.colors[2], glm::vec4(1, 0, 0, 1));
}

TEST(ReadPly, ReadsTriangleStrips) {
  const MeshFile file =
      ply_of(header("ascii", "element vertex 5\n" + std::string(kPositions) +
                                 "element tristrips 2\n" + std::string(kIndices)) +
             "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 4\n3 4 3 2\n");
  // Every second one turns the other way; a vertex twice makes no triangle.
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 2));
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(ReadPly, ReadsEntriesThatGoOverLines) {
  for (const char* body :
       {"0 0 0 1 0 0 0 1 0\n3 0 1 2 3 2 1 0\n", "0\n0 0 1\n0 0 0 1\n0\n3 0\n1 2 3\n2 1 0"}) {
    const MeshFile file = ply_of(ply_text_of(3, 2, body));
    EXPECT_EQ(file.mesh.positions[2], glm::dvec3(0, 1, 0)) << body;
    EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 2, 1, 0)) << body;
    EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("wrapped-lines")) << body;
  }
}

TEST(ReadPly, TellsOfWhatIsLeftOut) {
  const MeshFile file = ply_of(
      header("ascii", "comment TextureFile my wood.png\n" +
                          elements_of(3, "", 1, "property uchar red\nproperty int texnumber\n")) +
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 9 0\n");
  ASSERT_THAT(test::codes_of(file.warnings),
              ElementsAre("ignored-face-properties", "left-out-textures"));
  EXPECT_THAT(file.warnings[0].message, HasSubstr("red, texnumber"));
  EXPECT_THAT(file.warnings[1].message, HasSubstr("my wood.png"));
}

TEST(ReadPly, TakesBlanksBehindTheFirstWord) {
  EXPECT_EQ(ply_of("ply \nformat ascii 1.0 \nelement vertex 1\n" + std::string(kPositions) +
                   "end_header \n0 0 0\n")
                .mesh.positions.size(),
            1u);
}

// Binary PLY files are read on all threads, records of faces lying where the sizes before them say:
// the same as the text of the same mesh, whose lines are read one after another.

constexpr std::int32_t kVertices = 30000, kFaces = 25000;

std::int32_t size_of(std::int32_t face) { return 3 + face % 7 % 4; }
std::int32_t corner(std::int32_t face, std::int32_t i) { return (7 * face + i) % kVertices; }
double coordinate(std::int32_t vertex, int axis) { return vertex * 0.25 + axis; }

// A number, the list, and a further number or list.
std::string record_header(const std::string& format, const std::string& last) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(kVertices) +
         "\nproperty float x\nproperty uchar red\nproperty double y\nproperty uchar green\n"
         "property float z\nproperty uchar blue\nelement face " +
         std::to_string(kFaces) +
         "\nproperty short flags\nproperty list ushort int vertex_indices\nproperty " + last +
         "\nend_header\n";
}

std::string binary(bool has_second_list, std::endian order = std::endian::little) {
  std::string bytes =
      record_header(order == std::endian::little ? "binary_little_endian" : "binary_big_endian",
                    has_second_list ? "list uchar float weights" : "float quality");
  for (std::int32_t v = 0; v < kVertices; ++v) {
    append<float>(bytes, static_cast<float>(coordinate(v, 0)), order);
    append<std::uint8_t>(bytes, static_cast<std::uint8_t>(v % 256), order);
    append<double>(bytes, coordinate(v, 1), order);
    append<std::uint8_t>(bytes, 10, order);
    append<float>(bytes, static_cast<float>(coordinate(v, 2)), order);
    append<std::uint8_t>(bytes, 20, order);
  }
  for (std::int32_t f = 0; f < kFaces; ++f) {
    append<std::int16_t>(bytes, -1, order);
    append<std::uint16_t>(bytes, static_cast<std::uint16_t>(size_of(f)), order);
    for (std::int32_t i = 0; i < size_of(f); ++i) append<std::int32_t>(bytes, corner(f, i), order);
    if (has_second_list) append<std::uint8_t>(bytes, 1, order);
    append<float>(bytes, 0.5f, order);
  }
  return bytes;
}

std::string text() {
  std::string text = record_header("ascii", "float quality");
  for (std::int32_t v = 0; v < kVertices; ++v)
    text += std::to_string(coordinate(v, 0)) + " " + std::to_string(v % 256) + " " +
            std::to_string(coordinate(v, 1)) + " 10 " + std::to_string(coordinate(v, 2)) + " 20\n";
  for (std::int32_t f = 0; f < kFaces; ++f) {
    text += "-1 " + std::to_string(size_of(f));
    for (std::int32_t i = 0; i < size_of(f); ++i) text += " " + std::to_string(corner(f, i));
    text += " 0.5\n";
  }
  return text;
}

// Where face f's record begins.
std::size_t record_of(const std::string& bytes, std::int32_t face) {
  std::size_t place = bytes.size();
  for (std::int32_t f = kFaces - 1; f >= face; --f) place -= 8 + 4 * size_of(f);
  return place;
}

TEST(ReadPlyRecords, EqualTheLinesOfTheSameMesh) {
  const PolygonMesh expected = ply_of(text()).mesh;
  for (const std::string& bytes : {binary(false), binary(true), binary(false, std::endian::big)}) {
    const PolygonMesh mesh = ply_of(bytes).mesh;
    EXPECT_EQ(mesh.positions, expected.positions);
    EXPECT_EQ(mesh.colors, expected.colors);
    EXPECT_EQ(mesh.face_offsets, expected.face_offsets);
    EXPECT_EQ(mesh.face_vertices, expected.face_vertices);
  }
}

TEST(ReadPlyRecords, NameTheFirstThatIsWrong) {
  const std::string whole = binary(false);
  const std::size_t vertex = whole.find("end_header\n") + 11;
  std::string corners = whole, places = whole, size = whole;
  for (const std::int32_t face : {24000, 9000, 17000})
    corners.replace(record_of(whole, face) + 4, 4, "\xff\xff\xff\x7f");
  for (const std::size_t v : {29000, 12345})
    places.replace(vertex + 19 * v, 4, std::string("\x00\x00\x80\x7f", 4));
  size.replace(record_of(whole, 24999) + 2, 2, "\xff\xff");
  test::expect_refused(
      "a.ply",
      {{corners, " face 9000 of 25000 names vertex 2147483647 of 30000"},
       {places, " vertex 12345 of 30000: x is inf"},
       {whole.substr(0, record_of(whole, 20000) + 9),
        " face 20000 of 25000: list `vertex_indices` promises 4 values, but no more than 1 "
        "can follow"},
       {size,
        " face 24999 of 25000: list `vertex_indices` promises 65535 values, but no more "
        "than 6 can follow"}});
}

}  // namespace
}  // namespace planish
