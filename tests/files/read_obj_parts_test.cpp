// OBJ files are read in parts on all threads: the result and the messages must be those of a file
// read as one, wherever it is cut.
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "files/file_of.h"
#include "planish/core/error.h"
#include "planish/files/obj/read_obj.h"
#include "support/byte_strings.h"

namespace planish {
namespace {

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
