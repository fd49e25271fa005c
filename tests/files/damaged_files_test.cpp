// Every sample cut off at every byte, and with random bytes changed: an error or a mesh whose
// indices are in range and whose positions are finite, never a crash.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/mesh/check.h"
#include "support/byte_strings.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

struct Sample {
  std::string bytes;
  FileFormat format;
};

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
  const auto bytes = read_file(folder.path() / "mesh");
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<Sample> samples() {
  std::string stl(80, ' ');
  test::append<std::uint32_t>(stl, 2);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 12; ++j) test::append<float>(stl, static_cast<float>(i + j));
    test::append<std::uint16_t>(stl, 0);
  }
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
  std::string off = "NOFF BINARY\n";
  for (const int count : {3, 1, 0}) test::append<std::int32_t>(off, count, std::endian::big);
  for (int i = 0; i < 18; ++i)
    test::append<float>(off, static_cast<float>(i * i % 7), std::endian::big);
  for (const int value : {3, 0, 1, 2, 1, 5})
    test::append<std::int32_t>(off, value, std::endian::big);
  std::string own = "STCOFF BINARY\n";  // the machine's numbers, faces without colours
  for (const int count : {3, 1, 0}) test::append<std::int32_t>(own, count);
  for (int i = 0; i < 27; ++i) test::append<float>(own, static_cast<float>(i * i % 7));
  for (const int value : {3, 0, 1, 2}) test::append<std::int32_t>(own, value);
  std::string strips =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n"
      "property float y\nproperty float z\nproperty float diffuse_red\n"
      "property float diffuse_green\nproperty float diffuse_blue\nelement tristrips 1\n"
      "property list int int vertex_indices\nend_header\n";
  for (int i = 0; i < 24; ++i) test::append<float>(strips, static_cast<float>(i * i % 7));
  for (const int value : {8, 0, 1, 2, 3, -1, 3, 2, 1}) test::append<std::int32_t>(strips, value);
  return {
      {own, FileFormat::Off},
      {strips, FileFormat::Ply},
      {"OFF\n3 1 0\n0 0 0 1\n0 0 0 1 0 3\n0 1\n2\n", FileFormat::Off},
      {"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement tristrips 1\nproperty list uchar int vertex_index\n"
       "end_header\n0 0\n0 1 0 0\n0 1 0 4 0\n1 2 -1\n",
       FileFormat::Ply},
      {"v 0 0 0\nv 1 0 0\nv nan 0 0\nv 0 1 0\nusemtl a\\\nf 1 2 4\nf 2 1 4\n", FileFormat::Obj},
      {written(FileFormat::Obj), FileFormat::Obj},
      {"v 0 0 0\r\nv 1 0 0 1\r\nv 0 1 \\\r\n 0\r\nvt 0\r\nvt 1 1 0\r\nf -1/2/3 -2//1 \\\r\n-3\r\nt "
       "corner 2/2/0 0 1 1 "
       "2\r\nl 1 2\r\n",
       FileFormat::Obj},
      {written(FileFormat::Ply), FileFormat::Ply},
      {big, FileFormat::Ply},
      {"ply\nformat ascii 1.0\ncomment planish a=b\nelement vertex 3\nproperty float x\n"
       "property float y\nproperty float z\nproperty list uchar int n\nelement face 1\n"
       "property list uchar int vertex_indices\nend_header\n0 0 0 0\n1 0 0 1 5\n0 1 0 2 3 4\n3 0 "
       "1 2\n",
       FileFormat::Ply},
      {written(FileFormat::Off), FileFormat::Off},
      {"COFF 3 1 0\n0 0 0 1 1 1 1\n# c\n1 0 0\n0 1 0\n3 0 1 2 0.5\n", FileFormat::Off},
      {off, FileFormat::Off},
      {"ply\nTexture a\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nproperty float s\nproperty float t\nelement face 1\n"
       "property list uchar int vertex_indices\nend_header\n0 0 0 nan 0 9\n1 0 0 1 inf\n"
       "0 1 0 1 1\n3 0 1 2 4 5\n",
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

TEST(DamagedFiles, SamplesThemselvesAreRead) {
  for (const Sample& sample : samples()) EXPECT_TRUE(read_safely(sample.bytes, sample.format));
}

TEST(DamagedFiles, CutOffAtEveryByte) {
  for (const Sample& sample : samples())
    for (std::size_t size = 0; size < sample.bytes.size(); ++size)
      (void)read_safely(sample.bytes.substr(0, size), sample.format);
}

TEST(DamagedFiles, CutBinariesAreRefused) {
  for (const Sample& sample : samples()) {
    const bool is_text = sample.bytes.find('\0') == std::string::npos;
    if (is_text) continue;
    for (std::size_t size = 0; size < sample.bytes.size(); ++size)
      EXPECT_FALSE(read_safely(sample.bytes.substr(0, size), sample.format)) << size;
  }
}

TEST(DamagedFiles, RandomBytesChanged) {
  std::mt19937 random(3);
  for (const Sample& sample : samples()) {
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
