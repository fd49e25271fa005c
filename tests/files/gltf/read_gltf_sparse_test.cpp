// Sparse accessors: elements in the place of others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <array>
#include <cstring>

#include "files/gltf/read_square.h"

namespace planish {
namespace {

using test::glb_error;
using test::glb_of;
using test::read_glb;
using test::replaced;
using test::square_chunk;
using test::square_json;
using test::values;
using testing::ElementsAre;
using testing::HasSubstr;

// The square with `sparse` in its positions; the chunk goes on with two bytes, numbers of vertices,
// at 60 and two positions at 64.
std::string sparse_json(const std::string& sparse) {
  std::string json = replaced(square_json(), "\"count\":4", "\"count\":4,\"sparse\":" + sparse);
  json = replaced(json, "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}",
                  "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12},"
                  "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":4},"
                  "{\"buffer\":0,\"byteOffset\":64,\"byteLength\":24}");
  return replaced(json, "{\"byteLength\":60}", "{\"byteLength\":88}");
}

std::string sparse_chunk(const std::string& numbers) {
  return square_chunk() + numbers + values<float>({5, 6, 7, 8, 9, 10});
}

const std::string kSparse =
    R"({"count":2,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}})";

std::string sparse_error(const std::string& sparse, std::initializer_list<double> numbers) {
  return glb_error(glb_of(sparse_json(sparse), sparse_chunk(values<std::uint16_t>(numbers))));
}

TEST(ReadGltfSparse, ElementsTakeTheirPlaces) {
  const std::string chunk = sparse_chunk(values<std::uint16_t>({1, 3}));
  EXPECT_THAT(read_glb(glb_of(sparse_json(kSparse), chunk)).mesh.positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(5, 6, 7), glm::dvec3(1, 1, 0),
                          glm::dvec3(8, 9, 10)));
  // Indices of one byte, behind others.
  const std::string bytes = replaced(replaced(kSparse, "5123", "5121"), "\"bufferView\":2",
                                     "\"bufferView\":2,\"byteOffset\":2");
  EXPECT_THAT(
      read_glb(glb_of(sparse_json(bytes), sparse_chunk(std::string("\7\7\0\2", 4)))).mesh.positions,
      ElementsAre(glm::dvec3(5, 6, 7), glm::dvec3(1, 0, 0), glm::dvec3(8, 9, 10),
                  glm::dvec3(0, 1, 0)));
}

TEST(ReadGltfSparse, WithoutABufferViewTheOthersAreZeros) {
  const std::string json =
      replaced(sparse_json(kSparse), "\"bufferView\":0,\"componentType\"", "\"componentType\"");
  const PolygonMesh mesh = read_glb(glb_of(json, sparse_chunk(values<std::uint16_t>({1, 2})))).mesh;
  // Vertices 0 and 3 are welded at the origin, which leaves one triangle.
  EXPECT_THAT(mesh.positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(5, 6, 7), glm::dvec3(8, 9, 10)));
  EXPECT_THAT(mesh.face_vertices, ElementsAre(0, 1, 2));
}

TEST(ReadGltfSparse, IndicesAreReadToo) {
  const std::string json = replaced(
      replaced(square_json(), "\"count\":6",
               R"("count":6,"sparse":{"count":2,"indices":{"bufferView":2,"componentType":5125},)"
               R"("values":{"bufferView":2,"byteOffset":8}})"),
      "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}",
      "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12},"
      "{\"buffer\":0,\"byteOffset\":60,\"byteLength\":12}");
  const std::string chunk =
      square_chunk() + values<std::uint32_t>({0, 4}) + values<std::uint16_t>({3, 1});
  const PolygonMesh mesh =
      read_glb(glb_of(replaced(json, "{\"byteLength\":60}", "{\"byteLength\":72}"), chunk)).mesh;
  // 3 1 2 and 0 1 3 of the square, numbered as they come.
  EXPECT_THAT(mesh.face_vertices, ElementsAre(0, 1, 2, 3, 1, 0));
  EXPECT_THAT(mesh.positions, ElementsAre(glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0),
                                          glm::dvec3(1, 1, 0), glm::dvec3(0, 0, 0)));
}

// tinygltf hands the parts on; put together by hand.
TEST(ReadGltfSparse, TinygltfSeesTheSameParts) {
  const std::string glb = glb_of(sparse_json(kSparse), sparse_chunk(values<std::uint16_t>({1, 3})));
  tinygltf::Model model;
  std::string error, warning;
  ASSERT_TRUE(tinygltf::TinyGLTF().LoadBinaryFromMemory(
      &model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
      static_cast<unsigned>(glb.size())))
      << error;
  const auto& sparse = model.accessors[0].sparse;
  ASSERT_TRUE(sparse.isSparse);
  ASSERT_EQ(sparse.count, 2);
  const auto bytes_of_view = [&](int view) {
    return model.buffers[0].data.data() + model.bufferViews[view].byteOffset;
  };
  std::array<std::uint16_t, 2> numbers{};
  std::memcpy(numbers.data(), bytes_of_view(sparse.indices.bufferView), 4);
  std::array<float, 12> positions{};
  std::memcpy(positions.data(), bytes_of_view(model.accessors[0].bufferView), 48);
  for (int i = 0; i < 2; ++i)
    std::memcpy(&positions[3 * numbers[i]], bytes_of_view(sparse.values.bufferView) + 12 * i, 12);
  const PolygonMesh mesh = read_glb(glb).mesh;
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_EQ(mesh.positions[v],
              glm::dvec3(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]));
}

TEST(ReadGltfSparse, RefusesWrongParts) {
  const std::string place = "a.glb: accessors[0].sparse";
  EXPECT_EQ(sparse_error(kSparse, {3, 1}),
            place + ".indices: entry 1 is 1 behind 3; they must ascend");
  EXPECT_EQ(sparse_error(kSparse, {1, 1}),
            place + ".indices: entry 1 is 1 behind 1; they must ascend");
  EXPECT_EQ(sparse_error(kSparse, {1, 4}), place + ".indices: entry 1 names element 4 of 4");
  EXPECT_EQ(sparse_error(replaced(kSparse, "\"count\":2", "\"count\":5"), {1, 3}),
            place + ".count: 5 is more than the accessor has (4)");
  EXPECT_EQ(sparse_error(replaced(kSparse, "\"count\":2", "\"count\":0"), {1, 3}),
            place + ".count: 0 is no integer from 1");
  EXPECT_EQ(sparse_error(replaced(kSparse, "\"count\":2", "\"count\":3"), {1, 3}),
            place + ".indices: reaches to byte 6 of bufferViews[2], which has 4");
  EXPECT_EQ(sparse_error(replaced(kSparse, "\"bufferView\":3", "\"bufferView\":3,\"byteOffset\":4"),
                         {1, 3}),
            place + ".values: reaches to byte 28 of bufferViews[3], which has 24");
  EXPECT_EQ(sparse_error(replaced(kSparse, "5123", "5126"), {1, 3}),
            place + ".indices.componentType: 5126 cannot be used for indices");
  EXPECT_EQ(sparse_error(replaced(kSparse, "\"bufferView\":3", "\"bufferView\":4"), {1, 3}),
            "a.glb: bufferViews: entry 4 is asked for, but there are only 4");
  EXPECT_EQ(sparse_error(replaced(kSparse, "{\"bufferView\":3}", "{}"), {1, 3}),
            place + ".values: has no `bufferView`");
  const std::string strided = replaced(sparse_json(kSparse), "\"byteOffset\":64,\"byteLength\":24",
                                       "\"byteOffset\":64,\"byteLength\":24,\"byteStride\":12");
  EXPECT_THAT(glb_error(glb_of(strided, sparse_chunk(values<std::uint16_t>({1, 3})))),
              HasSubstr("bufferViews[3].byteStride: the parts of sparse accessors have no stride"));
}

TEST(ReadGltfSparse, EveryPlaceHasThem) {
  // Looked at once.
  std::string json = replaced(sparse_json(kSparse), "\"nodes\":[0]", "\"nodes\":[0,1]");
  json = replaced(json, "[{\"mesh\":0}]", "[{\"mesh\":0},{\"mesh\":0,\"translation\":[20,0,0]}]");
  const PolygonMesh mesh = read_glb(glb_of(json, sparse_chunk(values<std::uint16_t>({1, 3})))).mesh;
  EXPECT_EQ(mesh.positions[5], glm::dvec3(25, 6, 7));
}

}  // namespace
}  // namespace planish
