// Text PLY and OFF are read in parts on all threads: the result and the messages must be those of a
// file read as one, wherever it is cut.
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/files/off/read_off.h"
#include "planish/files/ply/read_ply.h"
#include "support/byte_strings.h"

namespace planish {
namespace {

using Read = MeshFile (*)(std::span<const std::byte>, std::string_view, std::size_t);

std::string told(Read read, std::string_view text, std::size_t part_bytes) {
  std::string result;
  try {
    const MeshFile file = read(test::bytes_of(text), "a.x", part_bytes);
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
    add(static_cast<double>(file.dropped_element_count));
  } catch (const Error& error) {
    result = std::string("error ") + error.what() + " " + std::to_string(error.element());
  }
  return result;
}

void expect_the_same_wherever_it_is_cut(Read read, const std::string& text) {
  const std::string whole = told(read, text, text.size() + 1);
  for (std::size_t bytes = 1; bytes <= text.size(); ++bytes)
    ASSERT_EQ(told(read, text, bytes), whole) << "in parts of " << bytes << " bytes of\n" << text;
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
       {std::pair<Read, std::string>(read_ply_in_parts, kPly), {read_off_in_parts, kOff}}) {
    EXPECT_EQ(told(read, text, 1).find("error"), std::string::npos) << told(read, text, 1);
    expect_the_same_wherever_it_is_cut(read, text);
    expect_the_same_wherever_it_is_cut(read, test::with_line_ends(text, "\r\n"));
    expect_the_same_wherever_it_is_cut(read, text.substr(0, text.size() - 1));
    expect_the_same_wherever_it_is_cut(read, text + "\n\n");
  }
}

TEST(ReadTextInParts, SaysTheSameOfErrors) {
  const std::vector<std::pair<std::string, std::string>> ply = {
      {"1 1 0 0 0 9", "1 one 0 0 0 9"}, {"8 8 8", "8 8"},       {"7 7 7", "7 7 7 7"},
      {"1 3 0 1 2 0", "1 3 0 1 5 0"},   {"2 4 0", "2 400 0"},   {"4 3 0 3 4 0\n", ""},
      {"face 4", "face 400"},           {"float y", "float w"}, {"1 1.5", "1 x"},
      {"0 1 2 3 2", "0 1 -2 3 2"}};
  for (const auto& [what, by] : ply) {
    expect_the_same_wherever_it_is_cut(read_ply_in_parts, substituted(kPly, what, by));
    expect_the_same_wherever_it_is_cut(
        read_ply_in_parts, substituted(substituted(kPly, what, by), "0.5 0.5", "0.5 y"));
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
    expect_the_same_wherever_it_is_cut(read_off_in_parts, substituted(kOff, what, by));
    expect_the_same_wherever_it_is_cut(read_off_in_parts,
                                       substituted(substituted(kOff, what, by), "4.5e1", "4.5e"));
  }
}

}  // namespace
}  // namespace planish
