// Streams of Draco's own encoder, read back.
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "files/read_bytes.h"
#include "planish/core/error.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/job/fit_file.h"
#include "support/files.h"

namespace planish {
namespace {

using testing::HasSubstr;

constexpr int kSide = 12;  // cells of a wavy sheet
constexpr int kPointCount = (kSide + 1) * (kSide + 1), kCornerCount = 6 * kSide * kSide;

glm::vec3 sheet_point(int i) {
  const int row = i / (kSide + 1);
  const auto x = static_cast<float>(i % (kSide + 1)), y = static_cast<float>(row);
  return {x, y, std::sin(0.5f * x) * std::cos(0.4f * y)};
}

std::vector<std::array<std::uint32_t, 3>> sheet_triangles() {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const std::uint32_t a = y * (kSide + 1) + x, b = a + kSide + 1;
      triangles.push_back({a, a + 1, b + 1});
      triangles.push_back({a, b + 1, b});
    }
  }
  return triangles;
}

template <class Value>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data_type,
                  int number_count, const std::vector<Value>& values) {
  draco::GeometryAttribute attribute;
  const int size = number_count * draco::DataTypeLength(data_type);
  attribute.Init(type, nullptr, static_cast<std::uint8_t>(number_count), data_type,
                 data_type == draco::DT_UINT8, size, 0);
  const int id = mesh.AddAttribute(attribute, true, kPointCount);
  for (std::uint32_t i = 0; i < kPointCount; ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          &values[static_cast<std::size_t>(number_count) * i]);
  return static_cast<int>(mesh.attribute(id)->unique_id());
}

struct Stream {
  std::string bytes;
  int positions = 0, uvs = 0, colors = 0;  // identifiers
};

// `bits` of positions; 0: floats as they are.
Stream sheet_stream(draco::MeshEncoderMethod method, int bits) {
  draco::Mesh mesh;
  mesh.set_num_points(kPointCount);
  std::vector<float> positions, uvs;
  std::vector<std::uint8_t> colors;
  for (int i = 0; i < kPointCount; ++i) {
    const glm::vec3 p = sheet_point(i);
    positions.insert(positions.end(), {p.x, p.y, p.z});
    uvs.insert(uvs.end(), {p.x / 16, p.y / 16});
    colors.insert(colors.end(), {static_cast<std::uint8_t>(i), 0, 255, 255});
  }
  Stream stream;
  using Type = draco::GeometryAttribute::Type;
  stream.positions = add_attribute(mesh, Type::POSITION, draco::DT_FLOAT32, 3, positions);
  stream.uvs = add_attribute(mesh, Type::TEX_COORD, draco::DT_FLOAT32, 2, uvs);
  stream.colors = add_attribute(mesh, Type::COLOR, draco::DT_UINT8, 4, colors);
  for (const auto& t : sheet_triangles())
    mesh.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  if (bits > 0) encoder.SetAttributeQuantization(Type::POSITION, bits);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  stream.bytes.assign(buffer.data(), buffer.size());
  return stream;
}

std::string sheet_json(const Stream& stream, int point_count = kPointCount,
                       std::int64_t corner_count = kCornerCount) {
  const auto text = [](auto value) { return std::to_string(value); };
  const std::string count = "\"count\":" + text(point_count);
  return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],)"
         R"("extensionsUsed":["KHR_draco_mesh_compression"],)"
         R"("extensionsRequired":["KHR_draco_mesh_compression"],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":1,"TEXCOORD_0":2,"COLOR_0":3},)"
         R"("indices":0,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,)"
         R"("attributes":{"POSITION":)" +
         text(stream.positions) + ",\"TEXCOORD_0\":" + text(stream.uvs) +
         ",\"COLOR_0\":" + text(stream.colors) + R"(}}}}]}],"accessors":[)" +
         "{\"componentType\":5123,\"type\":\"SCALAR\",\"count\":" + text(corner_count) + "}," +
         "{\"componentType\":5126,\"type\":\"VEC3\"," + count + "}," +
         "{\"componentType\":5126,\"type\":\"VEC2\"," + count + "}," +
         "{\"componentType\":5121,\"normalized\":true,\"type\":\"VEC4\"," + count +
         "}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":" + text(stream.bytes.size()) +
         "}],\"buffers\":[{\"byteLength\":" + text(stream.bytes.size()) + "}]}";
}

std::string sheet_glb(const Stream& stream) {
  return test::glb_of(sheet_json(stream), stream.bytes);
}

// Of a point on the sheet.
int number_of(const glm::dvec3& p) {
  return static_cast<int>(std::lround(p.y)) * (kSide + 1) + static_cast<int>(std::lround(p.x));
}

// The place of a triangle: its corners' numbers on the sheet, the least first.
std::array<int, 3> numbers_of(const PolygonMesh& mesh, std::int32_t face) {
  std::array<int, 3> numbers{};
  for (int k = 0; k < 3; ++k) numbers[k] = number_of(mesh.positions[mesh.face(face)[k]]);
  std::ranges::rotate(numbers, std::ranges::min_element(numbers));
  return numbers;
}

void expect_sheet(const PolygonMesh& mesh, double error) {
  ASSERT_EQ(mesh.vertex_count(), kPointCount);
  ASSERT_EQ(mesh.face_count(), kCornerCount / 3);
  std::vector<std::array<int, 3>> found, expected;
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    found.push_back(numbers_of(mesh, face));
    for (int k = 0; k < 3; ++k) {
      const std::int32_t corner = mesh.face_offsets[face] + k;
      const glm::dvec3& p = mesh.positions[mesh.face_vertices[corner]];
      const int number = number_of(p);
      EXPECT_LE(glm::distance(p, glm::dvec3(sheet_point(number))), error);
      // Texture coordinates are not quantised, and run upwards here.
      const glm::dvec2& uv = mesh.uvs[mesh.face_uvs[corner]];
      EXPECT_EQ(uv, glm::dvec2(sheet_point(number).x / 16, 1 - sheet_point(number).y / 16.0));
      EXPECT_FLOAT_EQ(mesh.colors[mesh.face_vertices[corner]].r,
                      static_cast<float>(number % 256) / 255);
    }
  }
  for (const auto& t : sheet_triangles()) {
    std::array<int, 3> numbers{static_cast<int>(t[0]), static_cast<int>(t[1]),
                               static_cast<int>(t[2])};
    std::ranges::rotate(numbers, std::ranges::min_element(numbers));
    expected.push_back(numbers);
  }
  std::ranges::sort(found);
  std::ranges::sort(expected);
  EXPECT_EQ(found, expected);
}

TEST(ReadDraco, GivesTheMeshThatWasPacked) {
  for (const auto method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    for (const int bits : {0, 14}) {
      SCOPED_TRACE(std::to_string(method) + " " + std::to_string(bits));
      const MeshFile file = test::read_glb(sheet_glb(sheet_stream(method, bits)));
      // 14 bits of 12 units round by half of 12 / 2^14 on each axis.
      expect_sheet(file.mesh, bits == 0 ? 0 : 12.0 / (1 << 14));
    }
  }
}

// Nothing of the extension stays, and the surface passes through the points that were packed.
TEST(ReadDraco, AnAssetComesOutUnpacked) {
  const test::TemporaryFolder folder;
  const std::filesystem::path input = folder.path() / "in.glb", output = folder.path() / "out.glb";
  std::ofstream(input, std::ios::binary)
      << sheet_glb(sheet_stream(draco::MESH_EDGEBREAKER_ENCODING, 0));
  FitFileOptions options;
  options.settings.set_levels({0});
  options.settings.quads = QuadChoice::Off;
  (void)fit_file(input, output, options);
  const std::string bytes = test::content_of(output);
  EXPECT_EQ(bytes.find("KHR_draco"), std::string::npos);
  const MeshFile made = test::read_glb(bytes);
  for (int i = 0; i < kPointCount; ++i) {
    double nearest = 1;
    for (const glm::dvec3& p : made.mesh.positions)
      nearest = std::min(nearest, glm::distance(p, glm::dvec3(sheet_point(i))));
    EXPECT_LT(nearest, 1e-4) << i;
  }
  EXPECT_FALSE(made.mesh.uvs.empty());
  EXPECT_FALSE(made.mesh.colors.empty());
}

TEST(ReadDraco, PlainBytesBesideAreReadInstead) {
  std::string points, corners;
  for (int i = 0; i < kPointCount; ++i)
    for (int axis = 0; axis < 3; ++axis) test::append<float>(points, sheet_point(i)[axis]);
  for (const auto& t : sheet_triangles())
    for (const std::uint32_t corner : t)
      test::append<std::uint16_t>(corners, static_cast<std::uint16_t>(corner));
  test::GlbParts parts;
  const std::size_t stream =
      parts.add_view(sheet_stream(draco::MESH_EDGEBREAKER_ENCODING, 8).bytes);
  parts.json["nodes"] = {{{"mesh", 0}}};
  parts.json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", parts.add_accessor(points, 5126, kPointCount, "VEC3")}}},
          {"indices", parts.add_accessor(corners, 5123, kCornerCount, "SCALAR")},
          {"extensions",
           {{"KHR_draco_mesh_compression",
             {{"bufferView", stream}, {"attributes", {{"POSITION", 0}}}}}}}}}}}};
  const MeshFile file = test::read_glb(parts.glb());
  ASSERT_EQ(file.mesh.vertex_count(), kPointCount);
  for (const glm::dvec3& p : file.mesh.positions)
    EXPECT_EQ(p, glm::dvec3(sheet_point(number_of(p))));
}

TEST(ReadDraco, CountsAreHeldAgainstTheStream) {
  for (const auto method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Stream stream = sheet_stream(method, 14);
    const std::string json = sheet_json(stream);
    std::vector<test::WrongFile> files;
    for (const auto& [changed, message] : std::vector<std::pair<std::string, std::string>>{
             {sheet_json(stream, kPointCount, kCornerCount - 3),
              "the stream has 288 triangles, and the indices 861 corners"},
             {sheet_json(stream, kPointCount - 1),
              "the stream has 169 points, and the positions 168"},
             {sheet_json(stream, kPointCount, 9'000'000'000),
              "9000000000 corners of 169 points cannot come from"},
             {sheet_json(stream, 2'000'000'000), "cannot come from"},
             {test::replaced(json, R"("TEXCOORD_0":1)", R"("TEXCOORD_0":7)"),
              "attributes.TEXCOORD_0: the Draco stream has no attribute 7"},
             {test::replaced(json, "VEC2", "VEC3"), "`VEC3` stands in the place of `VEC2`"},
             {test::replaced(json, "5121", "5123"),
              "elements of 4 numbers of type 5123 are packed as"},
             {test::replaced(json, R"("indices":0)", R"("indices":0,"mode":5)"),
              "mode: only triangles are read of Draco streams"}})
      files.push_back({test::glb_of(changed, stream.bytes), HasSubstr(message)});
    test::expect_refused("a.glb", files);
  }
}

TEST(ReadDraco, OtherStreamsAreRefused) {
  const Stream stream = sheet_stream(draco::MESH_EDGEBREAKER_ENCODING, 14);
  Stream older = stream, points = stream, zeros = stream;
  older.bytes[6] = 1;
  points.bytes[7] = 0;
  std::fill(zeros.bytes.begin() + 40, zeros.bytes.end(), '\0');
  test::expect_refused(
      "a.glb", {{sheet_glb(older), HasSubstr("the stream is no mesh of Draco's bitstream 2.2")},
                {sheet_glb(points), HasSubstr("the stream is no mesh of Draco's bitstream 2.2")},
                {sheet_glb(zeros), HasSubstr("the stream is no Draco mesh")}});
}

TEST(ReadDraco, DamagedStreamsAreReadOrRefused) {
  std::mt19937 random(7);
  int refused = 0;
  for (const auto method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const Stream good = sheet_stream(method, 10);
    const std::string json = sheet_json(good);
    for (int round = 0; round < 5000; ++round) {
      Stream damaged = good;
      for (unsigned i = random() % 3; i < 3; ++i)
        damaged.bytes[11 + random() % (damaged.bytes.size() - 11)] = static_cast<char>(random());
      try {
        const MeshFile file = test::read_glb(test::glb_of(json, damaged.bytes));
        for (const std::int32_t vertex : file.mesh.face_vertices)
          ASSERT_LT(vertex, file.mesh.vertex_count());
      } catch (const Error& error) {
        ASSERT_EQ(error.code(), ErrorCode::UnreadableInput);
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace planish
