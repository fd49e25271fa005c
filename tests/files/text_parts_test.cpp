#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <tuple>
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

std::string told(Read read, std::string_view text, std::size_t part_bytes, bool is_strict) {
  std::string result;
  try {
    const MeshFile file = read(test::file_of(text, "a.x", is_strict), part_bytes);
    const auto add = [&](double value) { result += std::to_string(value) + " "; };
    for (const auto& p : file.mesh.positions)
      for (int axis = 0; axis < 3; ++axis) add(p[axis]);
    for (const auto& uv : file.mesh.uvs) add(uv.x), add(uv.y);
    for (const auto& color : file.mesh.colors) add(color.r), add(color.a);
    for (const auto* numbers :
         {&file.mesh.face_offsets, &file.mesh.face_vertices, &file.mesh.face_uvs}) {
      result += "| ";
      for (const std::int32_t number : *numbers) add(number);
    }
    for (const std::string& line : file.header) result += "{" + line + "}";
    for (const Warning& warning : file.warnings) {
      result += warning.code + ": " + warning.message;
      add(static_cast<double>(warning.count)), add(static_cast<double>(warning.first));
    }
    add(static_cast<double>(file.dropped_element_count));
  } catch (const Error& error) {
    result = std::string("error ") + error.what() + " " + std::to_string(error.element());
  }
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

TEST(ReadTextInParts, KeepsEverything) {
  for (const auto& [read, text] :
       {std::pair<Read, std::string>(read_ply, kPly), {read_off, kOff}}) {
    const std::string all = told(read, text, 1, true);
    EXPECT_EQ(all.find("error"), std::string::npos) << all;
    expect_the_same_wherever_it_is_cut(read, text);
    expect_the_same_wherever_it_is_cut(read, test::with_line_ends(text, "\r\n"));
    expect_the_same_wherever_it_is_cut(read, text.substr(0, text.size() - 1));
    expect_the_same_wherever_it_is_cut(read, text + "\n\n");
  }
}

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
MeshFile xyz_in_parts(const FileBytes& file, std::size_t part_bytes) {
  return read_cloud(read_xyz(file, part_bytes));
}
MeshFile pts_in_parts(const FileBytes& file, std::size_t part_bytes) {
  return read_cloud(read_pts(file, part_bytes));
}
MeshFile pcd_in_parts(const FileBytes& file, std::size_t part_bytes) {
  return read_cloud(read_pcd(file, part_bytes));
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

TEST(ReadTextInParts, KeepsFacetsAndPoints) {
  for (const auto& [read, text] :
       std::vector<std::pair<Read, std::string>>{{read_stl, kStl},
                                                 {xyz_in_parts, kXyz},
                                                 {xyz_in_parts, kColumns},
                                                 {pts_in_parts, kPts},
                                                 {pcd_in_parts, kPcd}}) {
    const std::string all = told(read, text, 1, false);
    EXPECT_EQ(all.find("error"), std::string::npos) << all;
    for (const char* line_end : {"\n", "\r", "\r\n"}) {
      const std::string ended = test::with_line_ends(text, line_end);
      expect_the_same_wherever_it_is_cut(read, ended);
      expect_the_same_wherever_it_is_cut(read, ended.substr(0, ended.size() - 1));
      expect_the_same_wherever_it_is_cut(read, ended + line_end + line_end);
    }
  }
  // What one reads serially is what the parts say: points behind counts, lines, places.
  const MeshFile pts = pts_in_parts(test::file_of(kPts, "a.pts"), 1);
  ASSERT_EQ(pts.warnings.size(), 1u);
  EXPECT_EQ(pts.warnings[0].message,
            "a.pts:7: 2 points stand behind the 1 that line 5 counts; they are read as well");
  EXPECT_EQ(pts.warnings[0].first, 3);
}

TEST(ReadTextInParts, SaysTheSameOfErrorsInFacetsAndPoints) {
  using Changes = std::vector<std::pair<std::string, std::string>>;
  const std::vector<std::tuple<Read, std::string, Changes>> cases = {
      {read_stl,
       kStl,
       {{"  vertex 4.5e1 1 -2", "  vertex 4.5e 1 -2"},
        {" endloop\nendfacet\nendsolid", "endfacet\nendsolid"},
        {"FACET", "facets"},
        {"  vertex 4.5e1 1 -2\n", ""},
        {"endfacet\ncolor", "color"},
        {"endfacet\nendsolid b\n", ""},
        {"solid b", "solid"},
        {"solid b\n", ""},
        {"vertex 0 1 0", "vertex 0 1 0 0"}}},
      {xyz_in_parts,
       kXyz,
       {{"4,5,6 7", "4,5"}, {"7;8;9", "7;8;x"}, {"1 2 3", "1 inf 3"}, {"nan", "on"}}},
      {pts_in_parts,
       kPts,
       {{"7 8 9", "7 8"},
        {"2\n1 2 3", "3\n1 2 3"},
        {"# scan\n2", "9"},
        {"0\n2", "0\n5"},
        {"0\n2", "-1\n2"},
        {"6 6 6", "6 6 six"}}},
      {pcd_in_parts,
       kPcd,
       {{"4 5 6", "4 5 six"},
        {"1 0 0 65280", "1"},
        {"WIDTH 4", "WIDTH 5"},
        {"7 8 9", "7 8 1e300"}}}};
  for (const auto& [read, text, changes] : cases) {
    for (const auto& [what, by] : changes) {
      const std::string damaged = substituted(text, what, by);
      EXPECT_EQ(told(read, damaged, 1, true).find("error"), 0u) << damaged;
      expect_the_same_wherever_it_is_cut(read, damaged);
    }
  }
}

TEST(ReadTextInParts, SaysTheSameOfErrors) {
  const std::vector<std::pair<std::string, std::string>> ply = {
      {"1 1 0 0 0 9", "1 one 0 0 0 9"}, {"8 8 8", "8 8"},       {"7 7 7", "7 7 7 7"},
      {"1 3 0 1 2 0", "1 3 0 1 5 0"},   {"2 4 0", "2 400 0"},   {"4 3 0 3 4 0\n", ""},
      {"face 4", "face 400"},           {"float y", "float w"}, {"1 1.5", "1 x"},
      {"0 1 2 3 2", "0 1 -2 3 2"}};
  for (const auto& [what, by] : ply) {
    expect_the_same_wherever_it_is_cut(read_ply, substituted(kPly, what, by));
    expect_the_same_wherever_it_is_cut(
        read_ply, substituted(substituted(kPly, what, by), "0.5 0.5", "0.5 y"));
  }
  const std::vector<std::pair<std::string, std::string>> off = {{"1 1 0", "1 one 0"},
                                                                {"0 1 0\n", "0 1\n"},
                                                                {"3 0 1 2", "3 0 1 5"},
                                                                {"4 0", "5 0"},
                                                                {"4 0", "x 0"},
                                                                {"3 0 3 4\n", ""},
                                                                {"3 0 3 4\n", "3 0 3 4\nmore\n"},
                                                                {"5 4 0", "5 400 0"},
                                                                {"3 2 3 4", "3 2 -3 4"}};
  for (const auto& [what, by] : off) {
    expect_the_same_wherever_it_is_cut(read_off, substituted(kOff, what, by));
    expect_the_same_wherever_it_is_cut(read_off,
                                       substituted(substituted(kOff, what, by), "4.5e1", "4.5e"));
  }
}

// OBJ files are read in parts on all threads: the result and the messages must be those of a file
// read as one, wherever it is cut.

// All that a file says, or its error.
std::string told_obj(std::string_view text, std::size_t part_bytes, bool is_strict) {
  std::string result;
  const auto add = [&](const auto&... values) { ((result += std::to_string(values) + " "), ...); };
  MeshFile file;
  try {
    file = read_obj(test::file_of(text, "a.obj", is_strict), part_bytes);
  } catch (const Error& error) {
    return std::string("error ") + error.what() + " " + std::to_string(error.element());
  }
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
  for (const auto& warning : file.warnings) {
    result += warning.code + ": " + warning.message;
    add(warning.count);
  }
  for (const std::string& line : file.header) result += "{" + line + "}";
  add(file.dropped_element_count, file.mesh.colors.size(), file.mesh.uvs.size());
  return result;
}

void expect_the_same_obj_wherever_it_is_cut(const std::string& text) {
  for (const bool is_strict : {false, true}) {
    const std::string whole = told_obj(text, text.size() + 1, is_strict);
    for (std::size_t bytes = 1; bytes <= text.size(); ++bytes)
      ASSERT_EQ(told_obj(text, bytes, is_strict), whole) << "in parts of " << bytes << " bytes";
  }
}

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

TEST(ReadObjInParts, KeepsEverything) {
  for (const char* line_end : {"\n", "\r\n", "\r"}) {
    const std::string text = test::with_line_ends(kEverything, line_end);
    const std::string told = told_obj(text, text.size(), true);
    ASSERT_EQ(told.find("error"), std::string::npos) << told;
    expect_the_same_obj_wherever_it_is_cut(text);
    expect_the_same_obj_wherever_it_is_cut(text + line_end);
    expect_the_same_obj_wherever_it_is_cut(text + "\\" + line_end);
  }
}

TEST(ReadObjInParts, SaysTheSameOfErrors) {
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
                          "f 1/-9 2 3\n"}) {
    for (const std::string& text : {good + bad + good, bad + good + good, good + good + bad,
                                    good + bad + "f 1 2 0\n" + good}) {
      expect_the_same_obj_wherever_it_is_cut(text);
    }
  }
  expect_the_same_obj_wherever_it_is_cut("this is\nno file\nof any kind\n");
  expect_the_same_obj_wherever_it_is_cut("f 1 2 3\nwhat\n");
  expect_the_same_obj_wherever_it_is_cut("\n\n\n");
  EXPECT_EQ(told_obj("", 1, true), told_obj("", 100, true));
}

TEST(ReadObjInParts, NamesLinesOfTheWholeFile) {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nwhat\nf 1 2 3\nf 1 2 4\n";
  EXPECT_EQ(told_obj(text, 8, true), "error a.obj:6: face names vertex 4 of 3 1");
}

}  // namespace
}  // namespace planish
