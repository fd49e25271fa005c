#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "files/read_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/mesh/check.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

// Files as other programs write them: what concerns neither positions nor faces is read with a
// warning that names place and deed, and refused where the file is to be read strictly.

using test::append;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

MeshFile read(const std::string& bytes, FileFormat format) {
  return read_mesh(test::file_of(bytes, "a"), format);
}

std::string refusal(const std::string& bytes, FileFormat format, bool is_strict = false) {
  return test::message_of(ErrorCode::UnreadableInput, [&] {
    if (holds_points_only(format)) {
      (void)read_points(test::file_of(bytes, "a", is_strict), format);
    } else {
      (void)read_mesh(test::file_of(bytes, "a", is_strict), format);
    }
  });
}

void expect_read_with(const std::string& bytes, FileFormat format, const std::string& warning,
                      const std::string& strict) {
  EXPECT_THAT(test::messages_of(read(bytes, format).warnings), ElementsAre(warning));
  EXPECT_EQ(refusal(bytes, format, true), strict);
}

std::string text_ply(const std::string& header, const std::string& body) {
  return "ply\nformat ascii 1.0\n" + header + "end_header\n" + body;
}
std::string little_ply(const std::string& header, const std::string& body) {
  return "ply\nformat binary_little_endian 1.0\n" + header + "end_header\n" + body;
}
constexpr const char* kXyzProperties = "property float x\nproperty float y\nproperty float z\n";
constexpr const char* kColors = "property float red\nproperty float green\nproperty float blue\n";
constexpr const char* kList = "property list uchar int vertex_indices\n";
std::string triangle_header(const std::string& more = "") {
  return std::string("element vertex 3\n") + kXyzProperties + more + "element face 1\n" + kList;
}

TEST(ForeignPly, ValuesBehindALineAreWarnedOf) {
  const std::string bytes =
      text_ply(triangle_header(), "0 0 0 9\n1 0 0\n0 1 0 8 7\n3 0 1 2 255 0 0\n");
  expect_read_with(bytes, FileFormat::Ply,
                   "a:10: vertex 0 of 3 has a value too many: `9`; what stands behind an entry's "
                   "last value is passed over (3 times)",
                   "a:10: vertex 0 of 3 has a value too many: `9`");
  const MeshFile file = read(bytes, FileFormat::Ply);
  EXPECT_THAT(file.mesh.positions,
              ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2));
  EXPECT_EQ(file.warnings[0].code, "excess-values");
  EXPECT_EQ(file.warnings[0].count, 3);
  EXPECT_EQ(file.warnings[0].first, 0);
}

// They would be values too many, but then lines are missing.
TEST(ForeignPly, EntriesThatShareALineAreReadWhereAllComeOutEven) {
  expect_read_with(text_ply(triangle_header(), "0 0 0 1 0 0\n0 1 0\n3 0 1 2\n     \n"),
                   FileFormat::Ply,
                   "a: entries go over lines; the numbers are read one after another, and are as "
                   "many as wanted",
                   "a:10: vertex 0 of 3 has a value too many: `1`");
  EXPECT_EQ(
      refusal(text_ply(triangle_header(), "0 0 0 1 0 0\n0 1 0\n3 0 1\n     \n"), FileFormat::Ply),
      "a:13: the file ends at face 0 of 1");
}

TEST(ForeignPly, UnknownWordsOfTheHeaderAreWarnedOf) {
  const std::string begin = "ply\nTextureFile wood.png\nformat ascii 1.0\n";
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  expect_read_with(begin + "made by hand, in a hurry\n" + triangle_header() + "end_header\n" + body,
                   FileFormat::Ply,
                   "a:2: unknown keyword `TextureFile`; such lines are passed over (2 times)",
                   "a:2: unknown keyword `TextureFile`");
  // What may be a misspelt element or property decides where values stand.
  for (const char* line : {"elemnt vertex 3\n", "proprty float w\n", "propery list uchar int a\n"})
    EXPECT_THAT(refusal(text_ply(std::string("element vertex 3\n") + kXyzProperties + line, body),
                        FileFormat::Ply),
                HasSubstr("a:7: unknown keyword `"));
}

TEST(ForeignPly, ColoursAndCoordinatesThatAreNoNumbersAreNone) {
  const std::string colors = text_ply(
      triangle_header(kColors), "0 0 0 1 0 0\n1 0 0 0 nan 0\n0 1 0 -nan(ind) 1 inf\n3 0 1 2\n");
  expect_read_with(colors, FileFormat::Ply,
                   "a:14: vertex 1 of 3: green is nan; such vertices are white (2 times)",
                   "a:14: vertex 1 of 3: green is nan");
  EXPECT_THAT(read(colors, FileFormat::Ply).mesh.colors,
              ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(1), glm::vec4(1)));
  const std::string uvs = text_ply(triangle_header("property float s\nproperty float t\n"),
                                   "0 0 0 1 0\n1 0 0 nan 0\n0 1 0 0 1\n3 0 1 2\n");
  expect_read_with(uvs, FileFormat::Ply,
                   "a:13: vertex 1 of 3: s is nan; corners at such vertices have none",
                   "a:13: vertex 1 of 3: s is nan");
  EXPECT_THAT(read(uvs, FileFormat::Ply).mesh.face_uvs, ElementsAre(0, -1, 2));
  EXPECT_EQ(read(uvs, FileFormat::Ply).mesh.uvs[1], glm::dvec2(0));
  // Other words may come of columns that have shifted.
  EXPECT_EQ(refusal(test::replaced(colors, "1 0 0\n", "1 0 red\n"), FileFormat::Ply),
            "a:13: vertex 0 of 3: `red` is no finite number");
}

TEST(ForeignPly, BinaryColoursThatAreNoNumbersAreNone) {
  const auto file_of = [](double x, double blue) {
    return little_ply(triangle_header(kColors), test::values<float>({x, 0, 0, 1, 0, 0, 1, 0, 0, 0,
                                                                     0, blue, 0, 1, 0, 0, 0, 1}) +
                                                    "\3" + test::values<std::int32_t>({0, 1, 2}));
  };
  expect_read_with(file_of(0, NAN), FileFormat::Ply,
                   "a: vertex 1 of 3: blue is nan; such vertices are white",
                   "a: vertex 1 of 3: blue is nan");
  // A position that is none stays an error.
  EXPECT_EQ(refusal(file_of(NAN, 0), FileFormat::Ply), "a: vertex 0 of 3: x is nan");
}

TEST(ForeignPly, NormalsThatAreNoNumbersAreNone) {
  const std::string bytes =
      little_ply("element vertex 2\n" + std::string(kXyzProperties) +
                     "property float nx\nproperty float ny\nproperty float nz\n",
                 test::values<float>({1, 2, 3, NAN, 0, NAN, 4, 5, 6, 0, 1, 0}));
  EXPECT_THAT(read_points(test::file_of(bytes, "a"), FileFormat::Ply).normals,
              ElementsAre(glm::vec3(0), glm::vec3(0, 1, 0)));
}

TEST(ForeignPly, TheLastLineNeedsNoEnd) {
  EXPECT_EQ(read(text_ply(triangle_header(), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2"), FileFormat::Ply)
                .mesh.face_count(),
            1);
}

TEST(ForeignPly, HeadersMayEndLinesInReturnsBeforeBinaryBytes) {
  // The first byte behind the header is a line feed.
  const auto x = std::bit_cast<float>(0x3f00000au);
  const std::string bytes = test::with_line_ends(little_ply(triangle_header(), ""), "\r") +
                            test::values<float>({x, 0, 0, 1, 0, 0, 0, 1, 0}) + "\3" +
                            test::values<std::int32_t>({0, 1, 2});
  const MeshFile file = read(bytes, FileFormat::Ply);
  EXPECT_EQ(file.mesh.positions[0].x, x);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2));
}

// Geomview: numbers of 32 bits, big endian.
std::string binary_off(const std::string& keyword, int floats_of_vertex, int components) {
  std::string bytes = keyword + " BINARY\n";
  const auto put_int = [&](std::int32_t value) {
    append<std::int32_t>(bytes, value, std::endian::big);
  };
  const auto put_float = [&](float value) { append<float>(bytes, value, std::endian::big); };
  for (const int count : {4, 2, 0}) put_int(count);
  for (int v = 0; v < 4; ++v) {
    for (const int value : {v % 2, v / 2, v}) put_float(static_cast<float>(value));
    for (int i = 3; i < floats_of_vertex; ++i) put_float(0.5f);
  }
  for (const std::vector<int>& face : {std::vector{0, 1, 3, 2}, std::vector{2, 1, 0}}) {
    put_int(static_cast<std::int32_t>(face.size()));
    for (const int vertex : face) put_int(vertex);
    put_int(components);
    for (int i = 0; i < components; ++i) put_float(1.0f);
  }
  return bytes;
}

TEST(ForeignOff, BinaryFilesAreRead) {
  for (const auto& [keyword, floats] : {std::pair<std::string, int>{"OFF", 3},
                                        {"COFF", 7},
                                        {"NOFF", 6},
                                        {"CNOFF", 10},
                                        {"STOFF", 5},
                                        {"STCNOFF", 12}}) {
    for (const int components : {0, 3, 4}) {
      const MeshFile file = read(binary_off(keyword, floats, components), FileFormat::Off);
      EXPECT_THAT(file.mesh.positions, ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 1),
                                                   glm::dvec3(0, 1, 2), glm::dvec3(1, 1, 3)));
      EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 4, 7));
      EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 3, 2, 2, 1, 0));
      ASSERT_EQ(file.warnings.size(), components > 0 ? 1u : 0u);
      if (components > 0) {
        EXPECT_EQ(file.warnings[0].code, "ignored-colors");
        EXPECT_EQ(file.warnings[0].count, 2);
      }
      EXPECT_EQ(file.format, FileFormat::Off);
    }
  }
}

TEST(ForeignOff, DamagedBinaryFilesAreRefused) {
  const std::string sound = binary_off("COFF", 7, 3);
  for (std::size_t size = 0; size < sound.size(); ++size)
    EXPECT_THAT(refusal(sound.substr(0, size), FileFormat::Off), HasSubstr("a:")) << size;
  const auto damaged = [&](std::size_t place, char by) {
    std::string bytes = sound;
    bytes[sound.find('\n') + 1 + place] = by;
    return bytes;
  };
  const std::size_t first_corner = 12 + 4 * 28 + 4 + 3;
  test::expect_refused(
      "a.off",
      {{"OFF BINARY\nshort", "1: the file ends before its counts, 12 bytes behind the keyword"},
       {sound + "more", " 4 bytes more follow after the last face"},
       {damaged(0, '\xff'),
        "1: count -16777212 behind the keyword does not fit 192 bytes, nor does it in the other "
        "byte order"},
       {damaged(3, 100),
        "1: count 100 behind the keyword does not fit 192 bytes, nor does it in the other byte "
        "order"},
       {damaged(first_corner, 9), " face 0 of 2 names vertex 9 of 4"},
       // The vertices of another keyword are as long as it says.
       {binary_off("OFF", 7, 3), testing::_},
       {"4OFF BINARY\n", HasSubstr("only three-dimensional OFF")}});
}

constexpr const char* kForeignTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(ForeignObj, TextureCoordinatesThatAreNotThereAreNone) {
  const std::string start = kForeignTriangle;
  const std::string none = start + "f 1/1 2/2 3/1\n";
  expect_read_with(none, FileFormat::Obj,
                   "a:4: face names texture coordinate 2 of 0; such corners have none (3 times)",
                   "a:4: face names texture coordinate 2 of 0");
  EXPECT_THAT(read(none, FileFormat::Obj).mesh.uvs, IsEmpty());
  EXPECT_THAT(read(none, FileFormat::Obj).mesh.face_uvs, IsEmpty());
  const MeshFile file = read(start + "vt 0.5 0.25\nf 1/1 2/2 3/-2\nf 1/0 2/1 3\n", FileFormat::Obj);
  EXPECT_THAT(file.mesh.face_uvs, ElementsAre(0, -1, -1, -1, 0, -1));
  EXPECT_THAT(file.mesh.uvs, ElementsAre(glm::dvec2(0.5, 0.25)));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 1, 2));
  EXPECT_THAT(test::codes_of(file.warnings), ElementsAre("missing-texture-coordinates"));
  EXPECT_EQ(file.warnings[0].message,
            "a:5: face names texture coordinate -2, but only 1 stand before it; such corners have "
            "none (3 times)");
  const std::string wrong = start + "vt nan 0\nvt 1 1\nf 1/1 2/2 3/2\n";
  expect_read_with(wrong, FileFormat::Obj,
                   "a:4: texture coordinate `nan` is no finite number; corners that name such "
                   "have none",
                   "a:4: texture coordinate `nan` is no finite number");
  EXPECT_THAT(read(wrong, FileFormat::Obj).mesh.face_uvs, ElementsAre(-1, 1, 1));
  // Vertices that are not there stay an error.
  EXPECT_EQ(refusal(start + "f 1/1 2/2 4/1\n", FileFormat::Obj), "a:4: face names vertex 4 of 3");
}

TEST(ForeignObj, NormalsThatAreNotThereAreNone) {
  const std::string start = kForeignTriangle;
  for (const auto& [face, what] :
       {std::pair<std::string, std::string>{"f 1//1 2//3 3//2\n", "a:5: face names normal 3 of 1"},
        {"f 1//1 2//-2 3//-3\n", "a:5: face names normal -2, but only 1 stand before it"}}) {
    const std::string bytes = start + "vn 0 0 1\n" + face;
    FileBytes file = test::file_of(bytes, "a");
    EXPECT_THAT(read_mesh(file, FileFormat::Obj).warnings, IsEmpty());
    file.split_normals_crease = true;
    EXPECT_THAT(test::messages_of(read_mesh(file, FileFormat::Obj).warnings),
                ElementsAre(what + "; such corners have none (2 times)"));
    file.is_strict = true;
    EXPECT_EQ(test::message_of(ErrorCode::UnreadableInput,
                               [&] { (void)read_mesh(file, FileFormat::Obj); }),
              what);
  }
}

TEST(ForeignObj, ColoursThatAreNoNumbersAreNone) {
  const std::string bytes = "v 0 0 0 1 0 0\nv 1 0 0 nan nan nan\nv 0 1 0 -1.#IND 0 0\nf 1 2 3\n";
  expect_read_with(bytes, FileFormat::Obj,
                   "a:2: vertex coordinate `nan` is no finite number; such vertices have no colour "
                   "(2 times)",
                   "a:2: vertex coordinate `nan` is no finite number");
  EXPECT_THAT(read(bytes, FileFormat::Obj).mesh.colors,
              ElementsAre(glm::vec4(1, 0, 0, 1), glm::vec4(1), glm::vec4(1)));
  EXPECT_EQ(refusal("v 0 0 0 1 0 red\n", FileFormat::Obj),
            "a:1: vertex coordinate `red` is no finite number");
}

// Some programs take it for 3.1, others for 310.
TEST(ForeignNumbers, ExponentsThatArePlacedWrongAreRefusedWithTheRemedy) {
  const std::string remedy = "`3.1+e2` is no finite number; write 3.1e+2 if that is meant";
  test::expect_refused(
      "a.obj",
      {{"v 0 0 3.1+e2\n", "1: vertex coordinate " + remedy},
       {"v 0 0 3.1-E2\n",
        "1: vertex coordinate `3.1-E2` is no finite number; write 3.1E-2 if that is meant"},
       {"v 0 0 3+e\n", "1: vertex coordinate `3+e` is no finite number"}});
  test::expect_refused("a.off", {{"OFF\n1 0 0\n0 0 3.1+e2\n", "3: vertex coordinate " + remedy}});
  test::expect_refused(
      "a.ply", {{text_ply("element vertex 1\n" + std::string(kXyzProperties), "0 0 3.1+e2\n"),
                 "8: vertex 0 of 1: " + remedy}});
}

TEST(ForeignPcd, UnknownWordsOfTheHeaderAreWarnedOf) {
  const std::string header =
      "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nORIGIN of the scan, here\n"
      "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n";
  const PointCloud cloud = read_points(test::file_of(header, "a"), FileFormat::Pcd);
  EXPECT_THAT(cloud.points, ElementsAre(glm::dvec3(1, 2, 3)));
  EXPECT_THAT(test::messages_of(cloud.warnings),
              ElementsAre("a:6: unknown keyword `ORIGIN`; is this a PCD file?; such lines are "
                          "passed over"));
  EXPECT_THAT(refusal(header, FileFormat::Pcd, true), HasSubstr("a:6: unknown keyword `ORIGIN`"));
  // Sizes of fields and counts decide where values stand.
  for (const char* line : {"SIZES 4 4 4\n", "WIDHT 2\n"})
    EXPECT_THAT(refusal("FIELDS x y z\n" + std::string(line) + "WIDTH 1\nDATA ascii\n1 2 3\n",
                        FileFormat::Pcd),
                HasSubstr("a:2: unknown keyword"));
}

TEST(ForeignStl, UnknownWordsBetweenFacetsAreWarnedOf) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\n";
  expect_read_with("solid a\ncolor 1 0 0\n" + facet + "endsolid a\n", FileFormat::Stl,
                   "a:2: `color` is no word of STL; such lines are passed over",
                   "a:2: `color` is no word of STL");
  std::string damaged = "solid a\n" + facet + "endsolid a\n";
  damaged.replace(damaged.find("vertex"), 6, "vertx ");
  EXPECT_EQ(refusal(damaged, FileFormat::Stl), "a:4: `vertx` is no word of STL");
}

// Text of any encoding and with any line ends is read; text of UTF-16 and zeros behind the text
// with a warning.

struct ForeignFile {
  std::string bytes;
  FileFormat format;
};

std::vector<ForeignFile> texts() {
  return {
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", FileFormat::Obj},
      {text_ply(triangle_header(), "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), FileFormat::Ply},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", FileFormat::Off},
      {"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid\n",
       FileFormat::Stl},
      {"0 0 0\n1 0 0\n0 1 0\n", FileFormat::Xyz},
      {"3\n0 0 0\n1 0 0\n0 1 0\n", FileFormat::Pts},
      {"FIELDS x y z\nWIDTH 3\nDATA ascii\n0 0 0\n1 0 0\n0 1 0\n", FileFormat::Pcd},
      {R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
       R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,)"
       R"("componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,)"
       R"("byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;)"
       R"(base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})",
       FileFormat::Gltf},
  };
}

std::pair<std::vector<glm::dvec3>, std::vector<std::string>> found_in(const std::string& bytes,
                                                                      FileFormat format) {
  if (holds_points_only(format)) {
    const PointCloud cloud = read_points(test::file_of(bytes, "a"), format);
    return {cloud.points, test::messages_of(cloud.warnings)};
  }
  const MeshFile file = read(bytes, format);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2));
  return {file.mesh.positions, test::messages_of(file.warnings)};
}

const auto kCorners = ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0));

TEST(ForeignText, IsReadWhateverItsEncoding) {
  for (const ForeignFile& text : texts()) {
    SCOPED_TRACE(name_of(text.format));
    for (const std::string& wide : test::as_utf16(text.bytes)) {
      const auto [positions, warnings] = found_in(wide, text.format);
      EXPECT_THAT(positions, kCorners);
      EXPECT_THAT(warnings, ElementsAre("a: is text of UTF-16; it is read as UTF-8"));
      EXPECT_EQ(refusal(wide, text.format, true),
                "a: is text of UTF-16; save it as UTF-8 (iconv -f UTF-16 -t UTF-8)");
    }
    EXPECT_EQ(refusal(test::as_utf16(text.bytes)[0] + "x", text.format),
              "a: is text of UTF-16, damaged at byte " + std::to_string(2 * text.bytes.size() + 2) +
                  "; save it as UTF-8 (iconv -f UTF-16 -t UTF-8)");
    const auto [positions, warnings] = found_in("\xEF\xBB\xBF" + text.bytes, text.format);
    EXPECT_THAT(positions, kCorners);
    EXPECT_THAT(warnings, IsEmpty());
  }
}

TEST(ForeignText, IsReadWhateverEndsItsLinesAndItself) {
  for (const ForeignFile& text : texts()) {
    SCOPED_TRACE(name_of(text.format));
    for (const char* line_end : {"\r", "\r\n"})
      EXPECT_THAT(found_in(test::with_line_ends(text.bytes, line_end), text.format).first,
                  kCorners);
    const auto [positions, warnings] = found_in(text.bytes + std::string(5, '\0'), text.format);
    EXPECT_THAT(positions, kCorners);
    EXPECT_THAT(warnings, ElementsAre("a: 5 zero bytes behind the text, from byte " +
                                      std::to_string(text.bytes.size()) + " on, are left out"));
  }
}

TEST(ForeignText, AHeaderWithoutTrianglesIsNoText) {
  const MeshFile file = read(std::string(80, 'h') + std::string(4, '\0'), FileFormat::Stl);
  EXPECT_EQ(file.mesh.face_count(), 0);
  EXPECT_THAT(file.warnings, IsEmpty());
  std::string text = "solid a\nendsolid a\n";
  text.resize(80, '\n');
  EXPECT_EQ(read(text + std::string(4, '\0'), FileFormat::Stl).warnings.size(), 1u);
}

TEST(ForeignText, NamesBeyondAsciiComeThroughUtf16) {
  const std::u16string text = u"v 0 0 0\nv 1 0 0\nv 0 1 0\ng \u00fc\u4e2d\U0001F600\nf 1 2 3\n";
  std::string bytes;
  for (const char16_t c : text) test::append<char16_t>(bytes, c);
  const MeshFile file = read(bytes, FileFormat::Obj);
  ASSERT_EQ(file.mesh.groups.size(), 1u);
  EXPECT_EQ(file.mesh.groups[0].name, "\u00fc\u4e2d\U0001F600");
}

// Every sample cut off at every byte, and with random bytes changed: an error or a mesh whose
// indices are in range and whose positions are finite, never a crash.

std::string written(FileFormat format) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1, 2.5f}};
  mesh.corners = {{7}};
  mesh.uvs = {{0, 0.5}, {1, 1}};
  mesh.face_uvs.assign(mesh.face_vertices.size(), 1);
  mesh.colors.assign(mesh.positions.size(), glm::vec4(0.5f, 0, 1, 1));
  mesh.groups = {{"a b", ""}, {"", "c"}};
  mesh.face_groups = {0, 1, 1, 0, 0, 1};
  mesh.hole_faces = {2};
  const test::TemporaryFolder folder;
  write_mesh(folder.path() / "mesh", format, mesh, {.header = {"planish a=b"}});
  return test::content_of(folder.path() / "mesh");
}

// Numbers one after another.
template <class Value>
std::string squares(int count, std::endian order = std::endian::little) {
  std::string bytes;
  for (int i = 0; i < count; ++i) test::append<Value>(bytes, static_cast<Value>(i * i % 7), order);
  return bytes;
}
std::string integers(std::initializer_list<int> values, std::endian order = std::endian::little) {
  std::string bytes;
  for (const int value : values) test::append<std::int32_t>(bytes, value, order);
  return bytes;
}

std::vector<ForeignFile> samples() {
  std::string stl(80, ' ');
  test::append<std::uint32_t>(stl, 2);
  for (int i = 0; i < 2; ++i) stl += squares<float>(12) + std::string(2, '\0');
  std::string big =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\nproperty double y\n"
      "property list uchar uint t\nproperty float z\nelement edge 1\nproperty int a\n"
      "element face 1\nproperty list ushort uchar vertex_index\nend_header\n";
  for (int i = 0; i < 3; ++i) {
    test::append<std::int16_t>(big, static_cast<std::int16_t>(i), std::endian::big);
    test::append<double>(big, i * i, std::endian::big);
    big += '\0';
    test::append<float>(big, 1, std::endian::big);
  }
  big += std::string("\0\0\0\1\0\3\0\1\2", 9);
  const std::string off = "NOFF BINARY\n" + integers({3, 1, 0}, std::endian::big) +
                          squares<float>(18, std::endian::big) +
                          integers({3, 0, 1, 2, 1, 5}, std::endian::big);
  // The machine's numbers, faces without colours.
  const std::string own =
      "STCOFF BINARY\n" + integers({3, 1, 0}) + squares<float>(27) + integers({3, 0, 1, 2});
  const std::string strips =
      little_ply("element vertex 4\n" + std::string(kXyzProperties) +
                     "property float diffuse_red\nproperty float diffuse_green\n"
                     "property float diffuse_blue\nelement tristrips 1\n"
                     "property list int int vertex_indices\n",
                 squares<float>(24) + integers({8, 0, 1, 2, 3, -1, 3, 2, 1}));
  return {
      {own, FileFormat::Off},
      {strips, FileFormat::Ply},
      {"OFF\n3 1 0\n0 0 0 1\n0 0 0 1 0 3\n0 1\n2\n", FileFormat::Off},
      {text_ply("element vertex 3\n" + std::string(kXyzProperties) +
                    "element tristrips 1\nproperty list uchar int vertex_index\n",
                "0 0\n0 1 0 0\n0 1 0 4 0\n1 2 -1\n"),
       FileFormat::Ply},
      {"v 0 0 0\nv 1 0 0\nv nan 0 0\nv 0 1 0\nusemtl a\\\nf 1 2 4\nf 2 1 4\n", FileFormat::Obj},
      {written(FileFormat::Obj), FileFormat::Obj},
      {"v 0 0 0\r\nv 1 0 0 1\r\nv 0 1 \\\r\n 0\r\nvt 0\r\nvt 1 1 0\r\nf -1/2/3 -2//1 \\\r\n-3\r\n"
       "t corner 2/2/0 0 1 1 2\r\nl 1 2\r\n",
       FileFormat::Obj},
      {written(FileFormat::Ply), FileFormat::Ply},
      {big, FileFormat::Ply},
      {text_ply("comment planish a=b\n" + triangle_header("property list uchar int n\n"),
                "0 0 0 0\n1 0 0 1 5\n0 1 0 2 3 4\n3 0 1 2\n"),
       FileFormat::Ply},
      {written(FileFormat::Off), FileFormat::Off},
      {"COFF 3 1 0\n0 0 0 1 1 1 1\n# c\n1 0 0\n0 1 0\n3 0 1 2 0.5\n", FileFormat::Off},
      {off, FileFormat::Off},
      {text_ply("Texture a\n" + triangle_header("property float s\nproperty float t\n"),
                "0 0 0 nan 0 9\n1 0 0 1 inf\n0 1 0 1 1\n3 0 1 2 4 5\n"),
       FileFormat::Ply},
      {"v 0 0 0 nan 0 0\nv 1 0 0 1 0 0\nv 0 1 0\nvt nan\nvt 1 1\nf 1/1 2/2 3/9\nf -1/-7 -2/0 -3\n",
       FileFormat::Obj},
      {stl, FileFormat::Stl},
      {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       "endloop\nendfacet\nendsolid a\n",
       FileFormat::Stl},
  };
}

// True when a mesh came out.
bool read_safely(const std::string& bytes, FileFormat format) {
  try {
    const PolygonMesh mesh = read_mesh(test::bytes_of(bytes), "sample", format).mesh;
    for (const MeshProblem& problem : check(mesh)) {
      EXPECT_NE(problem.kind, MeshProblemKind::IndexOutOfRange) << problem.message;
      if (problem.kind == MeshProblemKind::NonFinitePosition) {
        const glm::dvec3& p = mesh.positions[problem.element];
        EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
      }
    }
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnreadableInput);
    EXPECT_TRUE(std::string_view(error.what()).starts_with("sample:")) << error.what();
    return false;
  }
}

TEST(DamagedFiles, AreRefusedWhereTheyAreCutBinaries) {
  for (const ForeignFile& sample : samples()) {
    EXPECT_TRUE(read_safely(sample.bytes, sample.format));
    const bool is_text = sample.bytes.find('\0') == std::string::npos;
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      const bool is_read = read_safely(sample.bytes.substr(0, size), sample.format);
      EXPECT_TRUE(is_text || !is_read) << size;
    }
  }
}

TEST(DamagedFiles, RandomBytesChanged) {
  std::mt19937 random(3);
  for (const ForeignFile& sample : samples()) {
    for (int round = 0; round < 2000; ++round) {
      std::string bytes = sample.bytes;
      for (unsigned i = 1 + random() % 4; i > 0; --i) {
        char& byte = bytes[random() % bytes.size()];
        // Half of the changes stay within what numbers are made of.
        byte = random() % 2 ? static_cast<char>(random()) : "0123456789-+./e \n"[random() % 17];
      }
      (void)read_safely(bytes, sample.format);
    }
  }
}

}  // namespace
}  // namespace planish
