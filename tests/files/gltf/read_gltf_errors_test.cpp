#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <limits>
#include <random>

#include "files/read_bytes.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

// What the glTF reader refuses, and that nothing brings it down.

using test::glb_of;
using test::read_glb;
using test::read_square;
using test::replaced;
using test::square_chunk;
using test::square_json;
using test::values;
using testing::HasSubstr;

TEST(ReadGltfErrors, RefusesWrongContainers) {
  const std::string glb = glb_of(square_json(), square_chunk());
  const std::string size = std::to_string(glb.size()), less = std::to_string(glb.size() - 1);
  std::string long_chunk = glb;
  long_chunk[15] = 1;
  test::expect_refused(
      "a.glb",
      {{"glTF", " a GLB begins with 20 bytes, but the file has 4"},
       {replaced(glb, std::string("\2\0\0\0", 4), std::string("\1\0\0\0", 4)),
        " GLB version 1 is not 2"},
       {glb.substr(0, glb.size() - 1),
        " header promises " + size + " bytes, but the file has " + less},
       {replaced(glb, "JSON", "JSOM"), " the first chunk is not JSON"},
       {long_chunk, testing::MatchesRegex(" chunk 0 promises 1677.* bytes, but only .* follow")},
       {"{\"a\":",
        " parse error at line 1, column 6: syntax error while parsing value - unexpected end of "
        "input; expected '[', '{', or a literal"},
       {"[]", " is no glTF: it starts neither with glTF nor with {"},
       {"{}", " has no `asset`"},
       {"{\"a\":" + std::string(100000, '['), " JSON is nested deeper than 64 levels"},
       {square_json(), " buffers[0]: has no `uri`, and there is no binary chunk for it"}});
}

TEST(ReadGltfErrors, RefusesWrongVersionsAndExtensions) {
  const std::string version = R"("version":"2.0")";
  test::expect_squares_refused(
      {{"2.0", "1.0", " asset.version: `1.0` is not 2.x"},
       {version, R"("version":"2.1","minVersion":"2.1")",
        " asset.minVersion: the file needs a reader of glTF 2.1, and 2.0 is read; save it as glTF "
        "2.0"},
       {version, version + R"(,"minVersion":"two")", " asset.minVersion: `two` is no version"},
       {R"("scene":0)", R"("extensionsRequired":["EXT_other"])",
        " extensionsRequired[0]: `EXT_other` cannot be read; save the file without it"}});
  EXPECT_EQ(read_square(version, R"("version":"2.1","minVersion":"2.0")").mesh.face_count(), 2);
}

TEST(ReadGltfErrors, RefusesDracoByNameWhereItIsNotBuiltIn) {
  const std::string to = R"("extensionsRequired":["KHR_draco_mesh_compression"])";
  if (reads_draco()) {
    EXPECT_EQ(read_square(R"("scene":0)", to).mesh.face_count(), 2);
  } else {
    test::expect_squares_refused({{R"("scene":0)", to, HasSubstr("`KHR_draco_mesh_compression`")}});
  }
}

// Why documents are not read by tinygltf, which takes the second node for 0 and misses the first.
TEST(ReadGltfErrors, NumbersAreNotCutTo32Bits) {
  EXPECT_EQ(read_square(R"({"mesh":0})", R"({"mesh":0.0})").mesh.face_count(), 2);
  test::expect_squares_refused({{R"({"mesh":0})", R"({"mesh":4294967296})",
                                 " meshes: entry 4294967296 is asked for, but there are only 1"}});
  tinygltf::Model model;
  std::string error, warning;
  const std::string wrong = R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0.0},)"
                            R"({"mesh":4294967296}]})";
  ASSERT_TRUE(tinygltf::TinyGLTF().LoadASCIIFromString(&model, &error, &warning, wrong.data(),
                                                       static_cast<unsigned>(wrong.size()), "", 0));
  EXPECT_EQ(model.nodes[0].mesh, -1);
  EXPECT_EQ(model.nodes[1].mesh, 0);
}

TEST(ReadGltfErrors, RefusesWrongNodes) {
  const std::string node = R"({"mesh":0})", nodes = R"("nodes":[0])";
  test::expect_squares_refused(
      {{R"("scene":0)", R"("scene":1)", " scenes: entry 1 is asked for, but there are only 1"},
       {nodes, R"("nodes":[4])", " nodes: entry 4 is asked for, but there are only 1"},
       {nodes, R"("nodes":[-1])", " scenes[0].nodes[0]: -1 is no integer from 0"},
       {node, R"({"children":[0]})", " nodes[0]: is reached twice, but nodes must form trees"},
       {node, R"({"mesh":1})", " meshes: entry 1 is asked for, but there are only 1"},
       {node, R"({"mesh":0,"scale":[1,2]})", " nodes[0].scale: has 2 numbers, 3 are needed"},
       {node, R"({"mesh":0,"rotation":[0,0,0,0]})", " nodes[0].rotation: is no rotation"},
       {node, R"({"mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]})",
        " nodes[0].matrix: is no affine transformation: its last row is not 0 0 0 1"},
       {node, R"({"mesh":0,"translation":[1e308,0,0],"scale":[1e308,1,1]})",
        testing::StartsWith(" meshes[0].primitives[0].attributes.POSITION: vertex 1 is at (in")}});
}

TEST(ReadGltfErrors, RefusesWrongPrimitives) {
  const std::string indices = R"("indices":1)", position = R"("POSITION":0)";
  test::expect_squares_refused(
      {{indices, R"("indices":1,"mode":7)",
        " meshes[0].primitives[0].mode: 7 is no mode of primitives"},
       {R"("count":6)", R"("count":5)",
        " meshes[0].primitives[0]: 5 corners make no whole triangles"},
       {position, R"("POSITION":0,"TEXCOORD_0":0)",
        HasSubstr("`VEC3` stands in the place of `VEC2`")},
       {position, R"("POSITION":0,"TEXCOORD_0":7)", HasSubstr("accessors")},
       {position, R"("POSITION":0,"COLOR_0":1)",
        HasSubstr("`SCALAR` stands in the place of `VEC4`")},
       {indices, R"("indices":1,"material":3)", HasSubstr("materials")}});
  const float inf = std::numeric_limits<float>::infinity();
  test::expect_refused(
      "a.glb",
      {{glb_of(square_json(),
               square_chunk().substr(0, 48) + values<std::uint16_t>({0, 1, 2, 0, 2, 4})),
        " meshes[0].primitives[0].indices: entry 5 names vertex 4 of 4"},
       {glb_of(square_json(), values<float>({0, 0, 0, 1, inf, 0}) + square_chunk().substr(24)),
        " meshes[0].primitives[0].attributes.POSITION: vertex 1 is at (1, inf, 0)"}});
}

TEST(ReadGltfErrors, RefusesWrongAccessors) {
  const std::string position = R"("POSITION":0)", count = R"("count":4)";
  test::expect_squares_refused(
      {{position, R"("POSITION":2)", " accessors: entry 2 is asked for, but there are only 2"},
       {position, R"("POSITION":1)", " accessors[1].type: `SCALAR` stands in the place of `VEC3`"},
       {count, R"("count":1000000000)",
        " accessors[0]: 1000000000 elements reach to byte 12000000000 of bufferViews[0], which has "
        "48"},
       {count, R"("count":0)", " accessors[0].count: 0 is no integer from 1"},
       {count, R"("count":1e300)", " accessors[0].count: 1e+300 is no integer from 1"},
       {count, R"("count":"4")", " accessors[0].count: \"4\" is no integer from 1"},
       {count, R"("byteOffset":1,"count":4)",
        " accessors[0]: 4 elements reach to byte 49 of bufferViews[0], which has 48"},
       {"5126", "5125", " accessors[0].componentType: 5125 cannot be used for positions"},
       {"5123", "5122", " accessors[1].componentType: 5122 cannot be used for indices"},
       {"5126", "5124", " accessors[0].componentType: 5124 cannot be used for positions"},
       {count, R"("count":4,"sparse":{})", " accessors[0].sparse: has no `indices`"},
       {count, R"("count":4,"normalized":1)",
        " accessors[0].normalized: 1 is neither true nor false"},
       {R"({"bufferView":1,)", "{",
        " accessors[1]: has no `bufferView`: each index is 0, which makes no triangle"}});
}

TEST(ReadGltfErrors, RefusesWrongBuffers) {
  const std::string length = R"("byteLength":48)";
  test::expect_squares_refused(
      {{length, R"("byteLength":61)",
        " bufferViews[0]: bytes 0 to 61 are asked of a buffer of 60; fetch the file anew, it may "
        "be cut short"},
       {length, R"("byteLength":48,"byteOffset":9007199254740992)",
        HasSubstr("bytes 9007199254740992 to 9007199254741040 are asked of a buffer of 60;")},
       {length, R"("byteLength":48,"byteStride":8)",
        " bufferViews[0].byteStride: 8 is not between 12 and 252"},
       {R"("byteLength":60)", R"("byteLength":1000)",
        " buffers[0].byteLength: promises 1000 bytes, but there are only 60"}});
}

// True when a mesh came out.
bool read_glb_safely(const std::string& bytes) {
  try {
    const PolygonMesh mesh = read_glb(bytes).mesh;
    for (const MeshProblem& problem : check(mesh))
      EXPECT_NE(problem.kind, MeshProblemKind::IndexOutOfRange) << problem.message;
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnreadableInput);
    EXPECT_TRUE(std::string_view(error.what()).starts_with("a.glb: ")) << error.what();
    return false;
  }
}

TEST(ReadGltfErrors, CutOffAtEveryByteIsRefused) {
  const std::string glb = glb_of(square_json(), square_chunk());
  for (std::size_t size = 0; size < glb.size(); ++size)
    EXPECT_FALSE(read_glb_safely(glb.substr(0, size))) << size;
}

TEST(ReadGltfErrors, RandomBytesChanged) {
  std::mt19937 random(5);
  const std::string glb = glb_of(square_json(), square_chunk());
  for (int round = 0; round < 20000; ++round) {
    std::string bytes = glb;
    for (unsigned i = 1 + random() % 4; i > 0; --i) {
      char& byte = bytes[random() % bytes.size()];
      byte = random() % 2 ? static_cast<char>(random()) : "0123456789-.e,[]{}\":"[random() % 20];
    }
    (void)read_glb_safely(bytes);
  }
}

// Positions of 0 and 1 are colours, too.
TEST(ReadGltfErrors, ColoursMayBePositions) {
  const MeshFile colored = read_square(R"("POSITION":0)", R"("POSITION":0,"COLOR_0":0)");
  ASSERT_EQ(colored.mesh.colors.size(), 4u);
  EXPECT_EQ(colored.mesh.colors[2], glm::vec4(1, 1, 0, 1));
}

// Scenes that are too large, by limits that are pretended to be small.

using test::bytes_of;

// The square, placed by two nodes: 12 corners, 8 vertices.
std::string two_squares() {
  return replaced(replaced(square_json(), R"("nodes":[0])", R"("nodes":[0,1])"), R"([{"mesh":0}])",
                  R"([{"mesh":0},{"mesh":0,"translation":[1,0,0]}])");
}

MeshFile read_limited(const std::string& json, const GltfLimits& limits) {
  const std::string glb = glb_of(json, square_chunk());
  return read_gltf_within({.bytes = bytes_of(glb), .name = "a.glb"}, limits);
}

std::string limit_error(ErrorCode code, const std::string& json, const GltfLimits& limits) {
  return test::message_of(code, [&] { (void)read_limited(json, limits); });
}

TEST(ReadGltfLimits, CountsCornersOfAllPlaces) {
  EXPECT_EQ(read_limited(two_squares(), {.corners = 12}).mesh.face_count(), 4);
  EXPECT_EQ(limit_error(ErrorCode::UnreadableInput, two_squares(), {.corners = 11}),
            "a.glb: meshes[0].primitives[0]: the scene has more than 11 triangle corners and "
            "points, which 32-bit numbers do not reach; split it into several files");
  const std::string points = replaced(two_squares(), R"("indices":1)", R"("indices":1,"mode":0)");
  EXPECT_EQ(read_limited(points, {.corners = 8}).mesh.vertex_count(), 8);
  EXPECT_THAT(limit_error(ErrorCode::UnreadableInput, points, {.corners = 7}),
              HasSubstr("more than 7 triangle corners and points"));
}

TEST(ReadGltfLimits, CountsTextureCoordinates) {
  const std::string json =
      replaced(replaced(two_squares(), R"("POSITION":0)", R"("POSITION":0,"TEXCOORD_0":2)"),
               R"("type":"SCALAR"})",
               R"("type":"SCALAR"},{"bufferView":0,"componentType":5126,"count":4,"type":"VEC2"})");
  EXPECT_EQ(read_limited(json, {}).mesh.uvs.size(), 8u);
  // One triangle each, with all four coordinates.
  const std::string fewer = replaced(json, R"("count":6)", R"("count":3)");
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
      replaced(square_json(), R"("bufferView":1,"componentType":5123,"count":6)",
               R"("componentType":5123,"count":1600000002,"sparse":{"count":1,"indices":{)"
               R"("bufferView":1,"componentType":5123},"values":{"bufferView":1}})");
  EXPECT_THAT(limit_error(ErrorCode::OutOfMemory, many, {.memory_bytes = std::uint64_t{16} << 30}),
              HasSubstr("needs about 41.7 GiB of memory where 16.0 GiB are free"));
  EXPECT_THAT(
      limit_error(ErrorCode::UnreadableInput, replaced(many, "1600000002", "2400000000"), {}),
      HasSubstr("more than 2147483647 triangle corners"));
}

}  // namespace
}  // namespace planish
