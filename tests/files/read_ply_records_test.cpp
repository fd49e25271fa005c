// Binary PLY files are read on all threads, records of faces lying where the sizes before them say:
// the same as the text of the same mesh, whose lines are read one after another.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "files/file_of.h"
#include "planish/files/ply/read_ply.h"
#include "support/byte_strings.h"
#include "support/expect_error.h"

namespace planish {
namespace {

constexpr std::int32_t kVertices = 30000, kFaces = 25000;

std::int32_t size_of(std::int32_t face) { return 3 + face % 7 % 4; }
std::int32_t corner(std::int32_t face, std::int32_t i) { return (7 * face + i) % kVertices; }
double coordinate(std::int32_t vertex, int axis) { return vertex * 0.25 + axis; }

std::string record_header(const std::string& format, const std::string& face_properties) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(kVertices) +
         "\nproperty float x\nproperty uchar red\nproperty double y\nproperty uchar green\n"
         "property float z\nproperty uchar blue\nelement face " +
         std::to_string(kFaces) + "\n" + face_properties + "end_header\n";
}

// With a number before and after each list, and with a second list where `further` says so.
std::string binary(bool further, std::endian order = std::endian::little) {
  std::string bytes = record_header(
      order == std::endian::little ? "binary_little_endian" : "binary_big_endian",
      std::string("property short flags\nproperty list ushort int vertex_indices\n") +
          (further ? "property list uchar float weights\n" : "property float quality\n"));
  for (std::int32_t v = 0; v < kVertices; ++v) {
    test::append<float>(bytes, static_cast<float>(coordinate(v, 0)), order);
    test::append<std::uint8_t>(bytes, static_cast<std::uint8_t>(v % 256), order);
    test::append<double>(bytes, coordinate(v, 1), order);
    test::append<std::uint8_t>(bytes, 10, order);
    test::append<float>(bytes, static_cast<float>(coordinate(v, 2)), order);
    test::append<std::uint8_t>(bytes, 20, order);
  }
  for (std::int32_t f = 0; f < kFaces; ++f) {
    test::append<std::int16_t>(bytes, -1, order);
    test::append<std::uint16_t>(bytes, static_cast<std::uint16_t>(size_of(f)), order);
    for (std::int32_t i = 0; i < size_of(f); ++i)
      test::append<std::int32_t>(bytes, corner(f, i), order);
    if (further) test::append<std::uint8_t>(bytes, 1, order);
    test::append<float>(bytes, 0.5f, order);
  }
  return bytes;
}

std::string text() {
  std::string text = record_header("ascii",
                                   "property short flags\n"
                                   "property list ushort int vertex_indices\n"
                                   "property float quality\n");
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
  const PolygonMesh expected = read_ply(test::file_of(text(), "a.ply")).mesh;
  for (const std::string& bytes : {binary(false), binary(true), binary(false, std::endian::big)}) {
    const PolygonMesh mesh = read_ply(test::file_of(bytes, "a.ply")).mesh;
    EXPECT_EQ(mesh.positions, expected.positions);
    EXPECT_EQ(mesh.colors, expected.colors);
    EXPECT_EQ(mesh.face_offsets, expected.face_offsets);
    EXPECT_EQ(mesh.face_vertices, expected.face_vertices);
  }
}

TEST(ReadPlyRecords, NameTheFirstThatIsWrong) {
  const auto message = [](const std::string& bytes) {
    return test::message_of(ErrorCode::UnreadableInput,
                            [&] { (void)read_ply(test::file_of(bytes, "a.ply")); });
  };
  const std::string whole = binary(false);
  std::string wrong = whole;
  for (const std::int32_t face : {24000, 9000, 17000})
    wrong.replace(record_of(whole, face) + 4, 4, "\xff\xff\xff\x7f");
  EXPECT_EQ(message(wrong), "a.ply: face 9000 of 25000 names vertex 2147483647 of 30000");

  const std::size_t vertex = whole.find("end_header\n") + 11;
  wrong = whole;
  for (const std::size_t v : {29000, 12345})
    wrong.replace(vertex + 19 * v, 4, std::string("\x00\x00\x80\x7f", 4));
  EXPECT_EQ(message(wrong), "a.ply: vertex 12345 of 30000: x is inf");

  EXPECT_EQ(
      message(whole.substr(0, record_of(whole, 20000) + 9)),
      "a.ply: face 20000 of 25000: list `vertex_indices` promises 4 values, but no more than 1 can "
      "follow");
  wrong = whole;
  wrong.replace(record_of(whole, 24999) + 2, 2, "\xff\xff");
  EXPECT_EQ(message(wrong),
            "a.ply: face 24999 of 25000: list `vertex_indices` promises 65535 "
            "values, but no more than 6 can follow");
}

}  // namespace
}  // namespace planish
