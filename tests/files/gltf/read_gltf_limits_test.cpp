// Scenes that are too large, by limits that are pretended to be small.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "files/gltf/read_square.h"

namespace planish {
namespace {

using test::bytes_of;
using test::glb_of;
using test::message_of;
using test::replaced;
using test::square_chunk;
using test::square_json;
using testing::HasSubstr;

// The square, placed by two nodes: 12 corners, 8 vertices.
std::string two_squares(std::string json = square_json()) {
  json = replaced(json, "\"nodes\":[0]", "\"nodes\":[0,1]");
  return replaced(json, "[{\"mesh\":0}]", "[{\"mesh\":0},{\"mesh\":0,\"translation\":[1,0,0]}]");
}

MeshFile read_limited(const std::string& json, const GltfLimits& limits) {
  const std::string glb = glb_of(json, square_chunk());
  return read_gltf_within({.bytes = bytes_of(glb), .name = "a.glb"}, limits);
}

std::string limit_error(ErrorCode code, const std::string& json, const GltfLimits& limits) {
  return message_of(code, [&] { (void)read_limited(json, limits); });
}

TEST(ReadGltfLimits, CountsCornersOfAllPlaces) {
  EXPECT_EQ(read_limited(two_squares(), {.corners = 12}).mesh.face_count(), 4);
  EXPECT_EQ(limit_error(ErrorCode::UnreadableInput, two_squares(), {.corners = 11}),
            "a.glb: meshes[0].primitives[0]: the scene has more than 11 triangle corners and "
            "points, which 32-bit numbers do not reach; split it into several files");
  const std::string points = replaced(two_squares(), "\"indices\":1", "\"indices\":1,\"mode\":0");
  EXPECT_EQ(read_limited(points, {.corners = 8}).mesh.vertex_count(), 8);
  EXPECT_THAT(limit_error(ErrorCode::UnreadableInput, points, {.corners = 7}),
              HasSubstr("more than 7 triangle corners and points"));
}

TEST(ReadGltfLimits, CountsTextureCoordinates) {
  const std::string json =
      replaced(replaced(two_squares(), "\"POSITION\":0", "\"POSITION\":0,\"TEXCOORD_0\":2"),
               "\"type\":\"SCALAR\"}",
               "\"type\":\"SCALAR\"},{\"bufferView\":0,\"componentType\":5126,"
               "\"count\":4,\"type\":\"VEC2\"}");
  EXPECT_EQ(read_limited(json, {}).mesh.uvs.size(), 8u);
  // One triangle each, with all four coordinates.
  const std::string fewer = replaced(json, "\"count\":6", "\"count\":3");
  EXPECT_EQ(read_limited(fewer, {.corners = 8}).mesh.face_count(), 2);
  EXPECT_THAT(limit_error(ErrorCode::UnreadableInput, fewer, {.corners = 7}),
              HasSubstr("TEXCOORD_0: the scene has more than 7 texture coordinates"));
}

TEST(ReadGltfLimits, AsksForMemoryFirst) {
  EXPECT_EQ(read_limited(two_squares(), {.memory_bytes = 2000}).mesh.face_count(), 4);
  EXPECT_EQ(limit_error(ErrorCode::OutOfMemory, two_squares(), {.memory_bytes = 600}),
            "a.glb: meshes[0].primitives[0]: the scene up to here needs about 0.0 GiB of memory "
            "where 0.0 GiB are free; split it into several files");
  // 1.6e9 corners in a few bytes; nothing of them is read. As sparse elements of nothing.
  const std::string many =
      replaced(replaced(square_json(), "\"indices\":1", "\"indices\":1,\"mode\":4"),
               "\"bufferView\":1,\"componentType\":5123,\"count\":6",
               "\"componentType\":5123,\"count\":1600000002,\"sparse\":{\"count\":1,\"indices\":{"
               "\"bufferView\":1,\"componentType\":5123},\"values\":{\"bufferView\":1}}");
  EXPECT_THAT(limit_error(ErrorCode::OutOfMemory, many, {.memory_bytes = std::uint64_t{16} << 30}),
              HasSubstr("needs about 41.7 GiB of memory where 16.0 GiB are free"));
  EXPECT_THAT(
      limit_error(ErrorCode::UnreadableInput, replaced(many, "1600000002", "2400000000"), {}),
      HasSubstr("more than 2147483647 triangle corners"));
}

}  // namespace
}  // namespace planish
