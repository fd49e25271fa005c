#include "planish/files/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "files/file_of.h"
#include "support/byte_strings.h"
#include "support/expect_error.h"

namespace planish {
namespace {

using testing::ElementsAre;

MeshFile off_of(std::string_view text) { return read_off(test::file_of(text, "a.off")); }

std::string off_error(std::string_view text) {
  return test::message_of(ErrorCode::UnreadableInput, [&] { (void)off_of(text); });
}

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

std::vector<std::string> off_codes(const MeshFile& file) {
  std::vector<std::string> codes;
  for (const Warning& warning : file.warnings) codes.push_back(warning.code);
  return codes;
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
  EXPECT_THAT(off_codes(bytes),
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
    EXPECT_THAT(off_codes(file), ElementsAre("wrapped-lines")) << body;
  }
  EXPECT_EQ(off_error("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n4 0\n1\n2\n"),
            "a.off:6: face has 1 corner of 4");
  EXPECT_EQ(off_error("OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n4 0\n1\n2\n1\n1\n"),
            "a.off:6: face has 1 corner of 4");
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
    EXPECT_EQ(off_codes(file).size(), is_usual ? 0u : 1u);
    bytes.pop_back();
    EXPECT_FALSE(off_error(bytes).empty());
  }
  std::string absurd = "OFF BINARY\n";
  for (const int count : {1 << 29, 1, 0})
    test::append<std::int32_t>(absurd, count, std::endian::little);
  EXPECT_EQ(off_error(absurd),
            "a.off:1: count 32 behind the keyword does not fit 12 bytes, nor does it in the other "
            "byte order");
}

TEST(ReadOff, AcceptsTheCountsBehindTheKeyword) {
  for (const char* start : {"OFF 3 1 0\n", "OFF3 1 0\n", "OFF\r\n3 1\r\n"})
    EXPECT_EQ(off_of(std::string(start) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2").mesh.face_count(), 1);
}

TEST(ReadOff, RefusesWrongHeaders) {
  EXPECT_EQ(off_error(""), "a.off:1: the file is empty");
  EXPECT_EQ(off_error("3 1 0\n"), "a.off:1: `3` stands in the place of OFF");
  EXPECT_EQ(
      off_error("4OFF\n"),
      "a.off:1: `4OFF`: only three-dimensional OFF with the prefixes ST, C and N can be read");
  EXPECT_EQ(off_error("OFF\n"), "a.off:1: the file ends before its counts");
  EXPECT_EQ(off_error("OFF\n3 x 0\n"), "a.off:2: count `x` is no integer from 0");
  EXPECT_EQ(off_error("OFF\n-3 1 0\n"), "a.off:2: count `-3` is no integer from 0");
  EXPECT_EQ(off_error("OFF\n3\n"), "a.off:2: count `` is no integer from 0");
  EXPECT_EQ(off_error("OFF\n1000000000 0 0\n0 0 0\n"),
            "a.off:2: header promises 1000000000 vertices, but only 6 bytes follow");
  EXPECT_EQ(off_error("OFF\n1 9000000000000000000 0\n0 0 0\n"),
            "a.off:2: header promises 9000000000000000000 faces, but only 6 bytes follow");
}

TEST(ReadOff, RefusesWrongBodies) {
  EXPECT_EQ(off_error("OFF\n1 0 0\n0 nan 0\n"),
            "a.off:3: vertex coordinate `nan` is no finite number");
  EXPECT_EQ(off_error("OFF\n1 0 0\n0 0     \n"),
            "a.off:3: vertex coordinate `` is no finite number");
  EXPECT_EQ(off_error("OFF\n2 0 0\n0 0 0     \n"), "a.off:3: the file ends at vertex 1 of 2");
  EXPECT_EQ(off_error("OFF\n1 1 0\n0 0 0\n3 0 1 0\n"), "a.off:4: face names vertex 1 of 1");
  EXPECT_EQ(off_error("OFF\n1 1 0\n0 0 0\n3 0 -1 0\n"), "a.off:4: face names vertex -1 of 1");
  EXPECT_EQ(off_error("OFF\n1 1 0\n0 0 0\n3 0 a 0\n"), "a.off:4: face corner `a` is no integer");
  EXPECT_EQ(off_error("OFF\n1 1 0\n0 0 0\n3 0 0\n"), "a.off:4: face has 2 corners of 3");
  EXPECT_EQ(off_error("OFF\n1 1 0\n0 0 0\n-3 0 0\n"),
            "a.off:4: face size `-3` is no integer from 0");
  EXPECT_EQ(off_error("OFF\n1 2 0\n0 0 0\n3 0 0 0\n"), "a.off:4: the file ends at face 1 of 2");
  EXPECT_EQ(off_error("OFF\n1 0 0\n0 0 0\n3 0 0 0\n"), "a.off:4: more follows after the last face");
}

}  // namespace
}  // namespace planish
