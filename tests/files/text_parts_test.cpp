#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/read_bytes.h"
#include "planish/core/error.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/readers.h"
#include "support/files.h"

namespace planish {
namespace {

// Text is read in parts on all threads: the result and the messages must be those of a file read as
// one, wherever it is cut.

using Read = MeshFile (*)(const FileBytes&, std::size_t);

// All that a file says, or its error.
std::string told(Read read, std::string_view text, std::size_t part_bytes, bool is_strict) {
  MeshFile file;
  try {
    file = read(test::file_of(text, "a.x", is_strict), part_bytes);
  } catch (const Error& error) {
    return std::string("error ") + error.what() + " " + std::to_string(error.element());
  }
  std::string result;
  const auto add = [&](const auto&... values) { ((result += std::to_string(values) + " "), ...); };
  const PolygonMesh& mesh = file.mesh;
  for (const auto& p : mesh.positions) add(p.x, p.y, p.z);
  for (const auto* numbers : {&mesh.face_offsets, &mesh.face_vertices, &mesh.face_uvs,
                              &mesh.face_groups, &mesh.hole_faces}) {
    result += "| ";
    for (const std::int32_t number : *numbers) add(number);
  }
  for (const auto& uv : mesh.uvs) add(uv.x, uv.y);
  result += "| ";
  for (const auto& c : mesh.colors) add(c.r, c.g, c.b, c.a);
  for (const auto& group : mesh.groups) result += "[" + group.name + "," + group.material + "]";
  for (const auto& crease : mesh.creases) add(crease.v0, crease.v1, crease.sharpness);
  for (const auto& corner : mesh.corners) add(corner.vertex, corner.sharpness);
  for (const Warning& warning : file.warnings) {
    result += warning.code + ": " + warning.message;
    add(warning.count, warning.first);
  }
  for (const std::string& line : file.header) result += "{" + line + "}";
  add(file.dropped_element_count, mesh.colors.size(), mesh.uvs.size());
  return result;
}

void expect_the_same_wherever_it_is_cut(Read read, const std::string& text) {
  for (const bool is_strict : {false, true}) {
    const std::string whole = told(read, text, text.size() + 1, is_strict);
    for (std::size_t bytes = 1; bytes <= text.size(); ++bytes)
      ASSERT_EQ(told(read, text, bytes, is_strict), whole)
          << "in parts of " << bytes << " bytes of\n"
          << text;
  }
}

std::string substituted(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

constexpr const char* kPly = R"(ply
format ascii 1.0
comment planish scheme=doo-sabin
element vertex 5
property float x
property float y
property float z
property float s
property float t
property uchar red
property uchar green
property uchar blue
element face 4
property uchar flags
property list uchar int vertex_indices
property list uchar float weights
end_header
0 0 0 0.5 .25 255 0 0
1 0 0 1 1 0 255 0

1 1 0 0 0 9 9 9
# a comment
0 1 0 0 0 8 8 8
4.5e1 1 -2 0 0 7 7 7
1 3 0 1 2 0
2 4 0 1 2 3 2 0.5 0.5
 3  3 2 3 4  1 1.5

4 3 0 3 4 0
)";

constexpr const char* kOff = R"(OFF
# planish scheme=doo-sabin
5 4 0

0 0 0
1 0 0 255 0 0
# between
1 1 0
0 1 0
4.5e1 1 -2
3 0 1 2
4 0 1 2 3   0.5 0.5 0.5

3 2 3 4
3 0 3 4
)";

constexpr const char* kStl = R"(solid a
facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 1 0 0
  vertex 0 1 0
 endloop
endfacet
color 1 0 0

FACET normal 0 0 1
 outer loop
  vertex 1 0 0
  vertex 0 1 0
  vertex 4.5e1 1 -2
 endloop
endfacet
endsolid a
solid b
facet normal 0 0 1
 outer loop
  vertex 0 0 0
  vertex 0 0 0
  vertex 0 1 0
 endloop
endfacet
endsolid b
)";

MeshFile read_cloud(PointCloud cloud) {
  MeshFile file{.format = FileFormat::Xyz};
  file.mesh.positions = std::move(cloud.points);
  file.mesh.colors = std::move(cloud.colors);
  file.warnings = std::move(cloud.warnings);
  file.dropped_element_count = cloud.missing_count;
  for (const glm::vec3& n : cloud.normals) file.header.push_back(std::to_string(n.x + 2 * n.y));
  for (const VertexAttribute& attribute : cloud.attributes)
    for (const float value : attribute.values)
      file.header.push_back(attribute.name + std::to_string(value));
  return file;
}
template <auto read>
MeshFile cloud_in_parts(const FileBytes& file, std::size_t part_bytes) {
  return read_cloud(read(file, part_bytes));
}

constexpr const char* kXyz = "// scan\n\nX Y Z\n1 2 3\n# c\n4,5,6 7\n\nnan 1 1\n7;8;9\n";
constexpr const char* kColumns =
    "# x y z nx ny nz r g b k m\n1 2 3 0 1 0 255 0 0 1 2\n4 5 6 1 0 0 0 9 0 3 4\nnan 1 1\n"
    "7 8 9 0 0 1 0 0 7 5 tree\n7 8 8 0 0 1 0 0 7 5\n6 6 6 0 0 1 0 0 9 7 8\n";
constexpr const char* kPts =
    "# scan\n2\n1 2 3\n4 5 6\n1\n7 8 9\n1 1 nan\n5 5 5\n0\n2\n6 6 6\n7 7 7\n";
constexpr const char* kPcd =
    "FIELDS x y z normal_x normal_y normal_z rgb\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F U\n"
    "WIDTH 4\nDATA ascii\n1 2 3 0 1 0 255\n\n4 5 6 1 0 0 65280\n# c\nnan 0 0 0 0 0 0\n"
    "7 8 9 0 0 1 7\n";

constexpr const char* kEverything = R"(# planish scheme=doo-sabin
# a path that ends with a backslash C:\
mtllib a.mtl
v 0 0 0
v 1 0 0 0.5 0.25 1.5
v 1 1 \
  0
v 0 1 0

vt 0 0
vt 1 0 0
f 1/1 2/2 3 4
o box
v 0 0 1
v 1 0 1 1 0 0 0.5
v 1 1 1
v 0 1 1
usemtl red paint
f -4 -3 \
   -2 \
   -1
g left  side
f 5//1 1 4 -1
vt 0.5 .5
usemtl
f 2/-1/1 6/-3 -2 3
p 1 2
bogus line
t crease 2/1/0 0 1 4.5
t hole 1/0/0 3
g
o
t corner 1/1/0 2 10
t wings 1/1/0 2 10
# planish solver=chebyshev
l 1 2
odd
f 1 2 6 5
s off
f 7 8 4 3)";

struct TextSample {
  std::string name;
  Read read;
  std::string text;
  bool is_plain = true;  // neither warnings nor errors where it is read strictly
  // Damages, with and without a second one behind them.
  std::vector<std::pair<std::string, std::string>> changes;
  std::pair<std::string, std::string> second = {};
};

std::vector<TextSample> text_samples() {
  return {
      {.name = "ply",
       .read = read_ply,
       .text = kPly,
       .changes = {{"1 1 0 0 0 9", "1 one 0 0 0 9"},
                   {"8 8 8", "8 8"},
                   {"7 7 7", "7 7 7 7"},
                   {"1 3 0 1 2 0", "1 3 0 1 5 0"},
                   {"2 4 0", "2 400 0"},
                   {"4 3 0 3 4 0\n", ""},
                   {"face 4", "face 400"},
                   {"float y", "float w"},
                   {"1 1.5", "1 x"},
                   {"0 1 2 3 2", "0 1 -2 3 2"}},
       .second = {"0.5 0.5", "0.5 y"}},
      {.name = "off",
       .read = read_off,
       .text = kOff,
       .changes = {{"1 1 0", "1 one 0"},
                   {"0 1 0\n", "0 1\n"},
                   {"3 0 1 2", "3 0 1 5"},
                   {"4 0", "5 0"},
                   {"4 0", "x 0"},
                   {"3 0 3 4\n", ""},
                   {"3 0 3 4\n", "3 0 3 4\nmore\n"},
                   {"5 4 0", "5 400 0"},
                   {"3 2 3 4", "3 2 -3 4"}},
       .second = {"4.5e1", "4.5e"}},
      {.name = "stl",
       .read = read_stl,
       .text = kStl,
       .is_plain = false,
       .changes = {{"  vertex 4.5e1 1 -2", "  vertex 4.5e 1 -2"},
                   {" endloop\nendfacet\nendsolid", "endfacet\nendsolid"},
                   {"FACET", "facets"},
                   {"  vertex 4.5e1 1 -2\n", ""},
                   {"endfacet\ncolor", "color"},
                   {"endfacet\nendsolid b\n", ""},
                   {"solid b", "solid"},
                   {"solid b\n", ""},
                   {"vertex 0 1 0", "vertex 0 1 0 0"}}},
      {.name = "xyz",
       .read = cloud_in_parts<read_xyz>,
       .text = kXyz,
       .is_plain = false,
       .changes = {{"4,5,6 7", "4,5"}, {"7;8;9", "7;8;x"}, {"1 2 3", "1 inf 3"}, {"nan", "on"}}},
      {.name = "xyz with names",
       .read = cloud_in_parts<read_xyz>,
       .text = kColumns,
       .is_plain = false,
       .changes = {}},
      {.name = "pts",
       .read = cloud_in_parts<read_pts>,
       .text = kPts,
       .is_plain = false,
       .changes = {{"7 8 9", "7 8"},
                   {"2\n1 2 3", "3\n1 2 3"},
                   {"# scan\n2", "9"},
                   {"0\n2", "0\n5"},
                   {"0\n2", "-1\n2"},
                   {"6 6 6", "6 6 six"}}},
      {.name = "pcd",
       .read = cloud_in_parts<read_pcd>,
       .text = kPcd,
       .is_plain = false,
       .changes = {{"4 5 6", "4 5 six"},
                   {"1 0 0 65280", "1"},
                   {"WIDTH 4", "WIDTH 5"},
                   {"7 8 9", "7 8 1e300"}}},
      {.name = "obj", .read = read_obj, .text = kEverything, .changes = {}}};
}

TEST(ReadTextInParts, KeepsEverything) {
  for (const TextSample& sample : text_samples()) {
    SCOPED_TRACE(sample.name);
    const std::string all = told(sample.read, sample.text, 1, sample.is_plain);
    EXPECT_EQ(all.find("error"), std::string::npos) << all;
    for (const std::string line_end : {"\n", "\r", "\r\n"}) {
      const std::string ended = test::with_line_ends(sample.text, line_end);
      for (const std::string& text : {ended, ended.substr(0, ended.size() - 1),
                                      ended + line_end + line_end, ended + "\\" + line_end})
        expect_the_same_wherever_it_is_cut(sample.read, text);
    }
  }
}

TEST(ReadTextInParts, SaysTheSameOfErrors) {
  for (const TextSample& sample : text_samples()) {
    for (const auto& [what, by] : sample.changes) {
      SCOPED_TRACE(sample.name + ": " + what);
      const std::string damaged = substituted(sample.text, what, by);
      expect_the_same_wherever_it_is_cut(sample.read, damaged);
      if (sample.is_plain) {
        expect_the_same_wherever_it_is_cut(
            sample.read, substituted(damaged, sample.second.first, sample.second.second));
      } else {
        EXPECT_EQ(told(sample.read, damaged, 1, true).find("error"), 0u) << damaged;
      }
    }
  }
}

TEST(ReadTextInParts, SaysTheSameOfErrorsOfAnObj) {
  const std::string good = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nv 0 0 1\nvt 1 1\n";
  for (const char* bad : {"v 1 x 3\n",
                          "v 1 2\n",
                          "f 1 2 9\n",
                          "f 1 2/7 3\n",
                          "f 1 2 -9\n",
                          "f 1 2 0\n",
                          "f 1/2/3/4 2 3\n",
                          "f 1 2/-5 3\n",
                          "f 1 2 99999999999\n",
                          "vt u\n",
                          "vt\n",
                          "t crease 2/1/0 0 77 1\n",
                          "t crease 1/1/0 0 1\n",
                          "t hole 1/0/0 5\n",
                          "t corner 1 2\n",
                          "v 1 2 1e999\n",
                          "v 1 2 3 nan 0 0\n",
                          "vt nan\n",
                          "f 1/0 2/-1 3/9\n",
                          "f 1/-9 2 3\n"})
    for (const std::string& text :
         {good + bad + good, bad + good + good, good + good + bad, good + bad + "f 1 2 0\n" + good})
      expect_the_same_wherever_it_is_cut(read_obj, text);
  for (const char* text : {"this is\nno file\nof any kind\n", "f 1 2 3\nwhat\n", "\n\n\n", ""})
    expect_the_same_wherever_it_is_cut(read_obj, text);
}

// Of the whole file, not of a part.
TEST(ReadTextInParts, CountsLines) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nwhat\nf 1 2 3\nf 1 2 4\n";
  EXPECT_EQ(told(read_obj, text, 8, true), "error a.x:6: face names vertex 4 of 3 1");
  const MeshFile pts = cloud_in_parts<read_pts>(test::file_of(kPts, "a.pts"), 1);
  ASSERT_EQ(pts.warnings.size(), 1u);
  EXPECT_EQ(pts.warnings[0].message,
            "a.pts:7: 2 points stand behind the 1 that line 5 counts; they are read as well");
  EXPECT_EQ(pts.warnings[0].first, 3);
}

}  // namespace
}  // namespace planish