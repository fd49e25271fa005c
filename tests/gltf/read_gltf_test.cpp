#include "planish/gltf/read_gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include "gltf/glb_bytes.h"
#include "gltf/surfaces.h"
#include "mesh/expect_error.h"
#include "mesh/temporary_folder.h"
#include "mesh/test_meshes.h"
#include "planish/gltf/write_gltf.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

using test::glb_of;
using test::replaced;
using test::square_chunk;
using test::square_json;
using test::values;
using testing::ElementsAre;
using testing::IsEmpty;

MeshFile read(const std::string& bytes) { return read_gltf(test::bytes_of(bytes), "a.glb"); }

MeshFile read_square(const std::string& from, const std::string& to) {
  return read(glb_of(replaced(square_json(), from, to), square_chunk()));
}

std::string error_of(const std::string& bytes) {
  return test::message_of(ErrorCode::UnreadableInput, [&] { (void)read(bytes); });
}

std::string square_error(const std::string& from, const std::string& to) {
  return error_of(glb_of(replaced(square_json(), from, to), square_chunk()));
}

TEST(ReadGltf, ReadsIndexedTriangles) {
  const MeshFile file = read(glb_of(square_json(), square_chunk()));
  EXPECT_THAT(file.mesh.positions, ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0),
                                               glm::dvec3(1, 1, 0), glm::dvec3(0, 1, 0)));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 3, 6));
  EXPECT_EQ(file.format, MeshFormat::Glb);
  EXPECT_EQ(file.welded_vertex_count, 0);
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(ReadGltf, ReadsStripsAndFansWithTheirWinding) {
  const std::string chunk = square_chunk();
  const auto mode = [&](const char* text, std::initializer_list<double> indices) {
    const std::string json = replaced(
        replaced(square_json(), "\"indices\":1", std::string("\"indices\":1,\"mode\":") + text),
        "\"count\":6", "\"count\":" + std::to_string(indices.size()));
    return read(glb_of(json, chunk.substr(0, 48) + values<std::uint16_t>(indices) +
                                 std::string(12, '\0')))
        .mesh.face_vertices;
  };
  EXPECT_THAT(mode("5", {0, 1, 3, 2}), ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_THAT(mode("6", {0, 1, 2, 3}), ElementsAre(1, 2, 0, 2, 3, 0));
  EXPECT_THAT(mode("5", {0, 1}), IsEmpty());
}

TEST(ReadGltf, ReadsWithoutIndicesAndWelds) {
  std::string json = replaced(square_json(), ",\"indices\":1", "");
  json = replaced(json, "\"count\":4", "\"count\":6");
  json = replaced(json, "\"byteLength\":48", "\"byteLength\":72");
  json = replaced(json, "\"buffers\":[{\"byteLength\":60}", "\"buffers\":[{\"byteLength\":72}");
  const MeshFile file =
      read(glb_of(json, values<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, -0.0, 0, 0, 1, 1, 0, 0, 1, 0})));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.welded_vertex_count, 2);
}

TEST(ReadGltf, WeldsAcrossPrimitivesAndNodes) {
  std::string json = replaced(square_json(), "\"nodes\":[0]", "\"nodes\":[0,1]");
  json = replaced(json, "[{\"mesh\":0}]", "[{\"mesh\":0},{\"mesh\":0,\"translation\":[1,0,0]}]");
  const MeshFile file = read(glb_of(json, square_chunk()));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2));
  EXPECT_EQ(file.mesh.positions[5], glm::dvec3(2, 1, 0));
  EXPECT_EQ(file.welded_vertex_count, 2);
}

TEST(ReadGltf, AppliesTransformsDownTheTree) {
  // Parent: a quarter turn about z, then (10, 0, 0); child: twice as long in x, then (0, 0, 5).
  const double half = std::sqrt(0.5);
  const std::string nodes = "[{\"children\":[1],\"translation\":[10,0,0],\"rotation\":[0,0," +
                            std::to_string(half) + "," + std::to_string(half) +
                            "]},{\"mesh\":0,\"scale\":[2,1,1],\"translation\":[0,0,5]}]";
  const MeshFile file = read_square("[{\"mesh\":0}]", nodes);
  const glm::dvec3 expected[] = {{10, 0, 5}, {10, 2, 5}, {9, 2, 5}, {9, 0, 5}};
  for (int i = 0; i < 4; ++i)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(file.mesh.positions[i][axis], expected[i][axis], 1e-14);
}

TEST(ReadGltf, ReadsColumnMajorMatrices) {
  const MeshFile file =
      read_square("[{\"mesh\":0}]", "[{\"mesh\":0,\"matrix\":[0,1,0,0,-1,0,0,0,0,0,1,0,7,8,9,1]}]");
  EXPECT_THAT(file.mesh.positions, ElementsAre(glm::dvec3(7, 8, 9), glm::dvec3(7, 9, 9),
                                               glm::dvec3(6, 9, 9), glm::dvec3(6, 8, 9)));
}

TEST(ReadGltf, MirrorsFlipTheWinding) {
  const MeshFile file = read_square("[{\"mesh\":0}]", "[{\"mesh\":0,\"scale\":[-1,1,1]}]");
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(-1, 1, 0));
  // The square faces +z as before: counter-clockwise seen from there.
  for (std::int32_t face = 0; face < 2; ++face) {
    const auto corners = file.mesh.face(face);
    const glm::dvec3 a = file.mesh.positions[corners[1]] - file.mesh.positions[corners[0]];
    const glm::dvec3 b = file.mesh.positions[corners[2]] - file.mesh.positions[corners[0]];
    EXPECT_GT(a.x * b.y - a.y * b.x, 0);
  }
}

TEST(ReadGltf, TakesTheDefaultScene) {
  const std::string two = "\"scenes\":[{\"nodes\":[0]},{}],";
  EXPECT_EQ(read_square("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],", "\"scene\":1," + two)
                .mesh.face_count(),
            0);
  EXPECT_EQ(read_square("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],", two).mesh.face_count(), 2);
  EXPECT_EQ(read_square("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],", "").mesh.face_count(), 2);
}

TEST(ReadGltf, ReadsQuantisedPositionsWithAStride) {
  std::string json =
      replaced(square_json(), "5126,\"count\":4", "5120,\"normalized\":true,\"count\":4");
  json = replaced(json, "\"byteLength\":48", "\"byteLength\":16,\"byteStride\":4");
  json = replaced(json, "\"byteOffset\":48", "\"byteOffset\":16");
  const MeshFile file = read(glb_of(
      json, values<std::int8_t>({0, 0, 0, 99, 127, 0, 0, 99, 127, -127, 0, 99, -128, 127, 0, 99}) +
                values<std::uint16_t>({0, 1, 2, 0, 2, 3}) + std::string(32, '\0')));
  EXPECT_THAT(file.mesh.positions, ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0),
                                               glm::dvec3(1, -1, 0), glm::dvec3(-1, 1, 0)));
}

TEST(ReadGltf, CountsWhatCarriesNoSurface) {
  const MeshFile file = read_square("\"primitives\":[",
                                    "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":0},"
                                    "{\"attributes\":{\"POSITION\":0},\"mode\":1},"
                                    "{\"attributes\":{}},");
  EXPECT_EQ(file.dropped_element_count, 3);
  EXPECT_EQ(file.mesh.face_count(), 2);
}

TEST(ReadGltf, WarnsOfSkinsAndMorphTargets) {
  const MeshFile file =
      read(glb_of(replaced(replaced(square_json(), "{\"mesh\":0}", "{\"mesh\":0,\"skin\":0}"),
                           "\"indices\":1", "\"indices\":1,\"targets\":[{}]"),
                  square_chunk()));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].code, "ignored-deformation");
  EXPECT_EQ(file.warnings[0].count, 2);
}

TEST(ReadGltf, LeavesOutTrianglesWithoutArea) {
  const MeshFile file = read(glb_of(
      square_json(), square_chunk().substr(0, 48) + values<std::uint16_t>({0, 1, 2, 0, 2, 2})));
  EXPECT_EQ(file.mesh.face_count(), 1);
  EXPECT_EQ(file.dropped_element_count, 1);
  EXPECT_EQ(file.warnings.at(0).code, "degenerate-triangles");
}

TEST(ReadGltf, ReadsDataUris) {
  // The 60 bytes of the square in base64, with the padding left out in the second document.
  const std::string base64 =
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAACAAMA";
  const std::string json = replaced(
      square_json(), "{\"byteLength\":60}",
      "{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64," + base64 + "\"}");
  const MeshFile file = read(json);
  EXPECT_EQ(file.format, MeshFormat::Gltf);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(1, 1, 0));
  EXPECT_EQ(error_of(replaced(json, base64, "AA*A")),
            "a.glb: buffers[0].uri: `data:application/octet-stream;base64,AA*...` is no base64 "
            "data URI");
  EXPECT_EQ(error_of(replaced(json, base64, "AAAA")),
            "a.glb: buffers[0].byteLength: promises 60 bytes, but there are only 3");
}

TEST(ReadGltf, ReadsFilesBesideTheDocumentOnly) {
  const test::TemporaryFolder folder;
  const auto write = [&](const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
  };
  const std::filesystem::path inside = folder.path() / "inside";
  std::filesystem::create_directory(inside);
  write(inside / "a b.bin", square_chunk());
  write(folder.path() / "outside.bin", square_chunk());
  const auto read_with = [&](const std::string& uri) {
    write(inside / "a.gltf", replaced(square_json(), "{\"byteLength\":60}",
                                      "{\"byteLength\":60,\"uri\":\"" + uri + "\"}"));
    return read_gltf(inside / "a.gltf");
  };
  EXPECT_EQ(read_with("a%20b.bin").mesh.face_count(), 2);
  const std::string name = (inside / "a.gltf").string();
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("x/../../outside.bin"),
        std::string("%2e%2e/outside.bin"), (folder.path() / "outside.bin").string(),
        "file://" + (folder.path() / "outside.bin").string(), std::string("%00"),
        std::string("..\\\\outside.bin"), std::string("%2")}) {
    const std::string message =
        test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_with(uri); });
    EXPECT_TRUE(message.starts_with(name + ": buffers[0].uri: `") &&
                message.ends_with("leads away from the folder of the file"))
        << message;
  }
  EXPECT_EQ(test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_with("no.bin"); }),
            (inside / "no.bin").string() + ": cannot read: No such file or directory");
  EXPECT_EQ(error_of(replaced(square_json(), "{\"byteLength\":60}",
                              "{\"byteLength\":60,\"uri\":\"a.bin\"}")),
            "a.glb: buffers[0].uri: `a.bin` is another file, but only embedded data can be read");
}

// What the project itself writes is read back to the last bit of float32.
TEST(ReadGltf, ReadsWhatIsWritten) {
  const SurfaceMesh surface = test::wavy_grid(9, 7);
  const std::vector<std::byte> bytes = encode_glb(surface, {});
  const MeshFile file = read_gltf(bytes, "own.glb");
  EXPECT_EQ(file.mesh.face_count(), 2 * 8 * 6);
  ASSERT_EQ(file.mesh.vertex_count(), 63);
  EXPECT_THAT(check(file.mesh), IsEmpty());
  std::vector<glm::dvec3> expected;
  for (const glm::dvec3& position : surface.positions) expected.emplace_back(glm::vec3(position));
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::vector<glm::dvec3> found = file.mesh.positions;
  std::ranges::sort(expected, less);
  std::ranges::sort(found, less);
  EXPECT_EQ(found, expected);
}

TEST(ReadGltf, RefusesWrongContainers) {
  const std::string glb = glb_of(square_json(), square_chunk());
  EXPECT_EQ(error_of("glTF"), "a.glb: a GLB begins with 20 bytes, but the file has 4");
  EXPECT_EQ(error_of(replaced(glb, std::string("\2\0\0\0", 4), std::string("\1\0\0\0", 4))),
            "a.glb: GLB version 1 is not 2");
  EXPECT_EQ(error_of(glb.substr(0, glb.size() - 1)),
            "a.glb: header promises " + std::to_string(glb.size()) + " bytes, but the file has " +
                std::to_string(glb.size() - 1));
  EXPECT_EQ(error_of(replaced(glb, "JSON", "JSOM")), "a.glb: the first chunk is not JSON");
  std::string long_chunk = glb;
  long_chunk[15] = 1;
  EXPECT_THAT(error_of(long_chunk),
              testing::MatchesRegex("a.glb: chunk 0 promises 1677.* bytes, but only .* follow"));
}

TEST(ReadGltf, RefusesWrongJson) {
  EXPECT_EQ(error_of("{\"a\":"),
            "a.glb: parse error at line 1, column 6: syntax error while parsing value - unexpected "
            "end of input; expected '[', '{', or a literal");
  EXPECT_EQ(error_of("[]"), "a.glb: an array is no object");
  EXPECT_EQ(error_of("{}"), "a.glb: has no `asset`");
  EXPECT_EQ(error_of(std::string(100000, '[')), "a.glb: JSON is nested deeper than 64 levels");
  EXPECT_EQ(square_error("2.0", "1.0"), "a.glb: asset.version: `1.0` is not 2.x");
  EXPECT_EQ(square_error("\"scene\":0", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"),
            "a.glb: extensionsRequired[0]: `KHR_draco_mesh_compression` cannot be read; save the "
            "file without it");
}

TEST(ReadGltf, RefusesWrongNodes) {
  EXPECT_EQ(square_error("\"scene\":0", "\"scene\":1"),
            "a.glb: scenes: entry 1 is asked for, but there are only 1");
  EXPECT_EQ(square_error("\"nodes\":[0]", "\"nodes\":[4]"),
            "a.glb: nodes: entry 4 is asked for, but there are only 1");
  EXPECT_EQ(square_error("\"nodes\":[0]", "\"nodes\":[-1]"),
            "a.glb: scenes[0].nodes[0]: -1 is no integer from 0");
  EXPECT_EQ(square_error("{\"mesh\":0}", "{\"children\":[0]}"),
            "a.glb: nodes[0]: is reached twice, but nodes must form trees");
  EXPECT_EQ(square_error("{\"mesh\":0}", "{\"mesh\":1}"),
            "a.glb: meshes: entry 1 is asked for, but there are only 1");
  EXPECT_EQ(square_error("{\"mesh\":0}", "{\"mesh\":0,\"scale\":[1,2]}"),
            "a.glb: nodes[0].scale: has 2 numbers, 3 are needed");
  EXPECT_EQ(square_error("{\"mesh\":0}", "{\"mesh\":0,\"rotation\":[0,0,0,0]}"),
            "a.glb: nodes[0].rotation: is no rotation");
  EXPECT_EQ(
      square_error("{\"mesh\":0}", "{\"mesh\":0,\"matrix\":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}"),
      "a.glb: nodes[0].matrix: is no affine transformation: its last row is not 0 0 0 1");
}

TEST(ReadGltf, RefusesWrongPrimitives) {
  EXPECT_EQ(square_error("\"indices\":1", "\"indices\":1,\"mode\":7"),
            "a.glb: meshes[0].primitives[0].mode: 7 is no mode of primitives");
  EXPECT_EQ(square_error("\"count\":6", "\"count\":5"),
            "a.glb: meshes[0].primitives[0]: 5 corners make no whole triangles");
  const std::string positions = square_chunk().substr(0, 48);
  EXPECT_EQ(error_of(glb_of(square_json(), positions + values<std::uint16_t>({0, 1, 2, 0, 2, 4}))),
            "a.glb: meshes[0].primitives[0].indices: entry 5 names vertex 4 of 4");
  EXPECT_EQ(error_of(glb_of(square_json(),
                            values<float>({0, 0, 0, 1, std::numeric_limits<float>::infinity(), 0}) +
                                square_chunk().substr(24))),
            "a.glb: meshes[0].primitives[0].attributes.POSITION: vertex 1 is at (1, inf, 0)");
  EXPECT_EQ(square_error("{\"mesh\":0}",
                         "{\"mesh\":0,\"translation\":[1e308,0,0],"
                         "\"scale\":[1e308,1,1]}")
                .substr(0, 70),
            "a.glb: meshes[0].primitives[0].attributes.POSITION: vertex 1 is at (in");
}

TEST(ReadGltf, RefusesWrongAccessors) {
  EXPECT_EQ(square_error("\"POSITION\":0", "\"POSITION\":2"),
            "a.glb: accessors: entry 2 is asked for, but there are only 2");
  EXPECT_EQ(square_error("\"POSITION\":0", "\"POSITION\":1"),
            "a.glb: accessors[1].type: `SCALAR` stands in the place of `VEC3`");
  EXPECT_EQ(square_error("\"count\":4", "\"count\":1000000000"),
            "a.glb: accessors[0]: 1000000000 elements reach to byte 12000000000 of "
            "bufferViews[0], which has 48");
  EXPECT_EQ(square_error("\"count\":4", "\"count\":0"),
            "a.glb: accessors[0].count: 0 is no integer from 1");
  EXPECT_EQ(square_error("\"count\":4", "\"count\":1e300"),
            "a.glb: accessors[0].count: 1e+300 is no integer from 1");
  EXPECT_EQ(square_error("\"count\":4", "\"count\":\"4\""),
            "a.glb: accessors[0].count: \"4\" is no integer from 1");
  EXPECT_EQ(square_error("\"count\":4", "\"byteOffset\":1,\"count\":4"),
            "a.glb: accessors[0]: 4 elements reach to byte 49 of bufferViews[0], which has 48");
  EXPECT_EQ(square_error("5126", "5125"),
            "a.glb: accessors[0].componentType: 5125 cannot be used for positions");
  EXPECT_EQ(square_error("5123", "5122"),
            "a.glb: accessors[1].componentType: 5122 cannot be used for indices");
  EXPECT_EQ(square_error("5126", "5124"),
            "a.glb: accessors[0].componentType: 5124 cannot be used for positions");
  EXPECT_EQ(square_error("\"count\":4", "\"count\":4,\"sparse\":{}"),
            "a.glb: accessors[0]: sparse accessors cannot be read; save the file without");
  EXPECT_EQ(square_error("\"count\":4", "\"count\":4,\"normalized\":1"),
            "a.glb: accessors[0].normalized: 1 is neither true nor false");
  EXPECT_EQ(square_error("{\"bufferView\":0,", "{"), "a.glb: accessors[0]: has no `bufferView`");
}

TEST(ReadGltf, RefusesWrongBuffers) {
  EXPECT_EQ(square_error("\"byteLength\":48", "\"byteLength\":61"),
            "a.glb: bufferViews[0]: bytes 0 to 61 are asked of a buffer of 60");
  EXPECT_EQ(square_error("\"byteLength\":48", "\"byteLength\":48,\"byteOffset\":9007199254740992"),
            "a.glb: bufferViews[0]: bytes 9007199254740992 to 9007199254741040 are asked of a "
            "buffer of 60");
  EXPECT_EQ(square_error("\"byteLength\":48", "\"byteLength\":48,\"byteStride\":8"),
            "a.glb: bufferViews[0].byteStride: 8 is not between 12 and 252");
  EXPECT_EQ(square_error("\"byteLength\":60", "\"byteLength\":1000"),
            "a.glb: buffers[0].byteLength: promises 1000 bytes, but there are only 60");
  EXPECT_EQ(error_of(square_json()),
            "a.glb: buffers[0]: has no `uri`, and there is no binary chunk for it");
}

// True when a mesh came out.
bool read_safely(const std::string& bytes) {
  try {
    const PolygonMesh mesh = read(bytes).mesh;
    for (const MeshProblem& problem : check(mesh))
      EXPECT_NE(problem.kind, MeshProblemKind::IndexOutOfRange) << problem.message;
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::UnreadableInput);
    EXPECT_TRUE(std::string_view(error.what()).starts_with("a.glb: ")) << error.what();
    return false;
  }
}

TEST(ReadGltf, CutOffAtEveryByteIsRefused) {
  const std::string glb = glb_of(square_json(), square_chunk());
  for (std::size_t size = 0; size < glb.size(); ++size)
    EXPECT_FALSE(read_safely(glb.substr(0, size))) << size;
}

TEST(ReadGltf, RandomBytesChanged) {
  std::mt19937 random(5);
  const std::string glb = glb_of(square_json(), square_chunk());
  for (int round = 0; round < 20000; ++round) {
    std::string bytes = glb;
    for (unsigned i = 1 + random() % 4; i > 0; --i) {
      char& byte = bytes[random() % bytes.size()];
      byte = random() % 2 ? static_cast<char>(random()) : "0123456789-.e,[]{}\":"[random() % 20];
    }
    (void)read_safely(bytes);
  }
}

TEST(ReadGltf, ChecksTextureCoordinatesAndColours) {
  const std::string position = "\"POSITION\":0";
  EXPECT_THAT(square_error(position, position + ",\"TEXCOORD_0\":0"),
              testing::HasSubstr("`VEC3` stands in the place of `VEC2`"));
  EXPECT_THAT(square_error(position, position + ",\"TEXCOORD_0\":7"),
              testing::HasSubstr("accessors"));
  EXPECT_THAT(square_error(position, position + ",\"COLOR_0\":1"),
              testing::HasSubstr("`SCALAR` stands in the place of `VEC4`"));
  EXPECT_THAT(square_error("\"indices\":1", "\"indices\":1,\"material\":3"),
              testing::HasSubstr("materials"));
  // Positions of 0 and 1 are colours, too.
  const MeshFile colored = read_square(position, position + ",\"COLOR_0\":0");
  ASSERT_EQ(colored.mesh.colors.size(), 4u);
  EXPECT_EQ(colored.mesh.colors[2], glm::vec4(1, 1, 0, 1));
}

}  // namespace
}  // namespace planish
