// Text of any encoding and with any line ends is read; text of UTF-16 and zeros behind the text
// with a warning.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "files/file_of.h"
#include "planish/files/mesh_file.h"
#include "support/byte_strings.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

MeshFile read_text(const std::string& bytes, FileFormat format) {
  return read_mesh(test::file_of(bytes, "a"), format);
}

std::string text_refusal(const std::string& bytes, FileFormat format, bool is_strict = false) {
  return test::message_of(ErrorCode::UnreadableInput, [&] {
    if (holds_points_only(format)) {
      (void)read_points(test::file_of(bytes, "a", is_strict), format);
    } else {
      (void)read_mesh(test::file_of(bytes, "a", is_strict), format);
    }
  });
}

std::vector<std::string> warning_texts(const std::vector<Warning>& warnings) {
  std::vector<std::string> texts;
  for (const Warning& warning : warnings) texts.push_back(warning.message);
  return texts;
}

struct Text {
  std::string bytes;
  FileFormat format;
};

std::vector<Text> texts() {
  return {
      {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", FileFormat::Obj},
      {"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
       FileFormat::Ply},
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
    return {cloud.points, warning_texts(cloud.warnings)};
  }
  const MeshFile file = read_text(bytes, format);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2));
  return {file.mesh.positions, warning_texts(file.warnings)};
}

const auto kCorners = ElementsAre(glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0));

TEST(ForeignText, IsReadWhateverItsEncoding) {
  for (const Text& text : texts()) {
    SCOPED_TRACE(name_of(text.format));
    std::string little, big;
    for (const char c : text.bytes) {
      little += {c, '\0'};
      big += {'\0', c};
    }
    for (const std::string& wide : {"\xFF\xFE" + little, "\xFE\xFF" + big, little, big}) {
      const auto [positions, warnings] = found_in(wide, text.format);
      EXPECT_THAT(positions, kCorners);
      EXPECT_THAT(warnings, ElementsAre("a: is text of UTF-16; it is read as UTF-8"));
      EXPECT_EQ(text_refusal(wide, text.format, true),
                "a: is text of UTF-16; save it as UTF-8 (iconv -f UTF-16 -t UTF-8)");
    }
    EXPECT_EQ(text_refusal("\xFF\xFE" + little + "x", text.format),
              "a: is text of UTF-16, damaged at byte " + std::to_string(little.size() + 2) +
                  "; save it as UTF-8 (iconv -f UTF-16 -t UTF-8)");
    const auto [positions, warnings] = found_in("\xEF\xBB\xBF" + text.bytes, text.format);
    EXPECT_THAT(positions, kCorners);
    EXPECT_THAT(warnings, IsEmpty());
  }
}

TEST(ForeignText, IsReadWhateverEndsItsLinesAndItself) {
  for (const Text& text : texts()) {
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
  const MeshFile file = read_text(std::string(80, 'h') + std::string(4, '\0'), FileFormat::Stl);
  EXPECT_EQ(file.mesh.face_count(), 0);
  EXPECT_THAT(file.warnings, IsEmpty());
  std::string text = "solid a\nendsolid a\n";
  text.resize(80, '\n');
  EXPECT_EQ(read_text(text + std::string(4, '\0'), FileFormat::Stl).warnings.size(), 1u);
}

TEST(ForeignText, NamesBeyondAsciiComeThroughUtf16) {
  const std::u16string text = u"v 0 0 0\nv 1 0 0\nv 0 1 0\ng \u00fc\u4e2d\U0001F600\nf 1 2 3\n";
  std::string bytes;
  for (const char16_t c : text) test::append<char16_t>(bytes, c);
  const MeshFile file = read_text(bytes, FileFormat::Obj);
  ASSERT_EQ(file.mesh.groups.size(), 1u);
  EXPECT_EQ(file.mesh.groups[0].name, "\u00fc\u4e2d\U0001F600");
}

}  // namespace
}  // namespace planish
