#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <string>
#include <string_view>

#include "files/gltf/surfaces.h"
#include "files/read_bytes.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/mesh/check.h"
#include "support/files.h"

namespace planish {
namespace {

using test::glb_error;
using test::glb_of;
using test::read_glb;
using test::read_square;
using test::replaced;
using test::square_chunk;
using test::square_json;
using test::values;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(ReadGltf, ReadsIndexedTriangles) {
  const MeshFile file = read_glb(glb_of(square_json(), square_chunk()));
  EXPECT_THAT(file.mesh.positions, ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0),
                                               glm::dvec3(1, 1, 0), glm::dvec3(0, 1, 0)));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_THAT(file.mesh.face_offsets, ElementsAre(0, 3, 6));
  EXPECT_EQ(file.format, FileFormat::Glb);
  EXPECT_EQ(file.welded_vertex_count, 0);
  EXPECT_THAT(file.warnings, IsEmpty());
}

TEST(ReadGltf, ReadsStripsAndFansWithTheirWinding) {
  const std::string chunk = square_chunk();
  const auto mode = [&](const char* text, std::initializer_list<double> indices) {
    const std::string json = replaced(
        replaced(square_json(), "\"indices\":1", std::string("\"indices\":1,\"mode\":") + text),
        "\"count\":6", "\"count\":" + std::to_string(indices.size()));
    return read_glb(glb_of(json, chunk.substr(0, 48) + values<std::uint16_t>(indices) +
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
  const MeshFile file = read_glb(
      glb_of(json, values<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, -0.0, 0, 0, 1, 1, 0, 0, 1, 0})));
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.welded_vertex_count, 2);
}

TEST(ReadGltf, WeldsAcrossPrimitivesAndNodes) {
  std::string json = replaced(square_json(), "\"nodes\":[0]", "\"nodes\":[0,1]");
  json = replaced(json, "[{\"mesh\":0}]", "[{\"mesh\":0},{\"mesh\":0,\"translation\":[1,0,0]}]");
  const MeshFile file = read_glb(glb_of(json, square_chunk()));
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
  const MeshFile file = read_glb(glb_of(
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
      read_glb(glb_of(replaced(replaced(square_json(), "{\"mesh\":0}",
                                        "{\"mesh\":0,\"skin\":0}],\"skins\":[{\"joints\":[0]}"),
                               "\"indices\":1", "\"indices\":1,\"targets\":[{}]"),
                      square_chunk()));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].code, "ignored-deformation");
  EXPECT_EQ(file.warnings[0].count, 2);
}

// The place of a node with a skin means nothing; where its joints stand does (section 3.7.3.3).
TEST(ReadGltf, JointsPlaceWhatTheyMove) {
  // Two joints, at (0, 0, 5) and turned about z by a right angle below it; the second half of the
  // square hangs at the second one, all of its first vertex at neither.
  const std::string nodes =
      R"("nodes":[{"mesh":0,"skin":0,"translation":[100,0,0]},{"translation":[0,0,5],)"
      R"("children":[2]},{"rotation":[0,0,1,1]}],"skins":[{"joints":[1,2],)"
      R"("inverseBindMatrices":4}])";
  std::string json = replaced(square_json(), R"("nodes":[{"mesh":0}])", nodes);
  json = replaced(json, R"("POSITION":0)", R"("POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3)");
  json = replaced(json, R"("type":"SCALAR"})",
                  R"("type":"SCALAR"},{"bufferView":2,"componentType":5121,"count":4,)"
                  R"("type":"VEC4"},{"bufferView":3,"componentType":5126,"count":4,)"
                  R"("type":"VEC4"},{"bufferView":4,"componentType":5126,"count":2,)"
                  R"("type":"MAT4"})");
  json = replaced(json, R"("byteLength":12})",
                  R"("byteLength":12},{"buffer":0,"byteOffset":60,"byteLength":16},)"
                  R"({"buffer":0,"byteOffset":76,"byteLength":64},)"
                  R"({"buffer":0,"byteOffset":140,"byteLength":128})");
  json = replaced(json, R"([{"byteLength":60}])", R"([{"byteLength":268}])");
  const std::string chunk = square_chunk() +
                            values<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}) +
                            values<float>({0, 0, 0, 0, 1, 0, 0, 0, 0.25, 0.75, 0, 0, 2, 0, 0, 0}) +
                            values<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1}) +
                            values<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  const MeshFile file = read_glb(glb_of(json, chunk));
  ASSERT_EQ(file.mesh.vertex_count(), 4);
  // The first as the first joint has it; (1, 0, 0) too; of (1, 1, 0) a quarter stays there, the
  // rest is at (-1, 1, 5); (0, 1, 0) is all at (-1, 0, 5).
  const glm::dvec3 expected[] = {{0, 0, 0}, {1, 0, 0}, {-0.5, 1, 3.75}, {-1, 0, 5}};
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LT(glm::distance(file.mesh.positions[v], expected[v]), 1e-12) << v;
  EXPECT_EQ(test::glb_error(glb_of(replaced(json, "\"joints\":[1,2]", "\"joints\":[1]"), chunk)),
            "a.glb: meshes[0].primitives[0].attributes.JOINTS_0: vertex 2 names joint 1, and the "
            "skin has 1");
}

TEST(ReadGltf, LeavesOutWhatIsHidden) {
  const std::string extension = R"(,"extensions":{"KHR_node_visibility":{"visible":false}})";
  std::string json = replaced(square_json(), R"("nodes":[{"mesh":0}])",
                              R"("nodes":[{"children":[1,2]},{"mesh":0},{"children":[3])" +
                                  extension + R"(},{"mesh":0,"translation":[0,0,1]}],)" +
                                  R"("extensionsRequired":["KHR_node_visibility"])");
  const MeshFile file = read_glb(glb_of(json, square_chunk()));
  EXPECT_EQ(file.mesh.face_count(), 2);
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].code, "hidden-nodes");
  EXPECT_EQ(file.warnings[0].count, 1);
  json = replaced(json, "false", "true");
  EXPECT_EQ(read_glb(glb_of(json, square_chunk())).mesh.face_count(), 4);
}

// Section 3.6.2.1: what has no buffer view is zero.
TEST(ReadGltf, AccessorsWithoutViewsAreZeros) {
  const std::string zeros = R"("type":"SCALAR"},{"componentType":5126,"count":4,"type":"VEC2"},)"
                            R"({"componentType":5126,"count":4,"type":"VEC4"})";
  const std::string json = replaced(
      replaced(square_json(), R"("POSITION":0)", R"("POSITION":0,"TEXCOORD_0":2,"COLOR_0":3)"),
      R"("type":"SCALAR"})", zeros);
  const PolygonMesh mesh = read_glb(glb_of(json, square_chunk())).mesh;
  EXPECT_EQ(mesh.positions[2], glm::dvec3(1, 1, 0));
  EXPECT_EQ(mesh.uvs, std::vector<glm::dvec2>(4, {0, 1}));  // upwards
  EXPECT_EQ(mesh.colors, std::vector<glm::vec4>(4, glm::vec4(0.0f)));
}

// Of two vertices at one place the first has the colour.
TEST(ReadGltf, WarnsOfColorsThatShareAPlace) {
  std::string json = replaced(square_json(), R"("POSITION":0)", R"("POSITION":0,"COLOR_0":2)");
  json = replaced(json, R"("type":"SCALAR"})",
                  R"("type":"SCALAR"},{"bufferView":2,"componentType":5121,"normalized":true,)"
                  R"("count":4,"type":"VEC4"})");
  json = replaced(json, R"("byteLength":12})",
                  R"("byteLength":12},{"buffer":0,"byteOffset":60,"byteLength":16})");
  json = replaced(json, R"([{"byteLength":60}])", R"([{"byteLength":76}])");
  const std::string colors = values<std::uint8_t>({0, 0, 0, 255, 255, 0, 0, 255, 0, 255, 0, 255,  //
                                                   0, 0, 255, 255});
  EXPECT_THAT(read_glb(glb_of(json, square_chunk() + colors)).warnings, IsEmpty());
  // The last vertex lies on the first.
  const std::string chunk = values<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0}) +
                            values<std::uint16_t>({0, 1, 2, 1, 2, 3}) + colors;
  const MeshFile file = read_glb(glb_of(json, chunk));
  ASSERT_EQ(file.warnings.size(), 1u);
  EXPECT_EQ(file.warnings[0].message,
            "1 of 4 vertices has another colour at a place they share: there the first one's is "
            "taken");
  EXPECT_EQ(file.warnings[0].first, 0);
}

TEST(ReadGltf, LeavesOutTrianglesWithoutArea) {
  const MeshFile file = read_glb(glb_of(
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
  const MeshFile file = read_glb(json);
  EXPECT_EQ(file.format, FileFormat::Gltf);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(1, 1, 0));
  EXPECT_EQ(glb_error(replaced(json, base64, "AA*A")),
            "a.glb: buffers[0].uri: `data:application/octet-stream;base64,AA*...` is no data "
            "URI: its base64 is broken, or it has no data");
  EXPECT_EQ(glb_error(replaced(json, base64, "AAAA")),
            "a.glb: buffers[0].byteLength: promises 60 bytes, but there are only 3");
}

// RFC 2397, and what is in none.
TEST(DataUri, IsThatOfItsRfc) {
  const auto decoded = [](std::string_view uri) {
    const auto bytes = decode_data_uri(uri);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())
                 : "none";
  };
  EXPECT_EQ(decoded("data:,A%20brief%20note"), "A brief note");
  EXPECT_EQ(decoded("data:text/plain;charset=iso-8859-7,%be%fg%be"), "\xbe%fg\xbe");
  EXPECT_EQ(decoded("data:application/octet-stream,%00%ff"), std::string("\0\xff", 2));
  EXPECT_EQ(decoded("data:;base64,Zm9v"), "foo");
  EXPECT_EQ(decoded("data:;base64,Zm8%3D"), "fo");
  EXPECT_EQ(decoded("data:;base64,Zm-9"), "none");
  EXPECT_EQ(decoded("data:application/octet-stream"), "none");
}

// The test vectors of RFC 4648, section 10, and what has more or other digits than they may.
TEST(Base64, IsThatOfItsRfc) {
  const auto decoded = [](std::string_view text) {
    const auto bytes = decode_base64(text);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size())
                 : "none";
  };
  EXPECT_EQ(decoded(""), "");
  EXPECT_EQ(decoded("Zg=="), "f");
  EXPECT_EQ(decoded("Zm8="), "fo");
  EXPECT_EQ(decoded("Zm9v"), "foo");
  EXPECT_EQ(decoded("Zm9vYg=="), "foob");
  EXPECT_EQ(decoded("Zm9vYmE="), "fooba");
  EXPECT_EQ(decoded("Zm9vYmFy"), "foobar");
  for (const char* text : {"Zg===", "Z", "Zm9v=Zg", "Zm9-"})
    EXPECT_EQ(decoded(text), "none") << text;
}

// Normals are placed by the inverse transpose, which stays perpendicular to what is placed.
TEST(PlacedNormal, IsThatOfTheInverseTranspose) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1, -2, 0.5));
  for (const double mirror : {1.0, -1.0}) {
    const glm::dmat3 part({mirror * 2, 0.5, -1}, {0.25, 3, 1}, {-0.5, 1.5, 4});
    GltfInstance instance{0, 0, glm::dmat4(part)};
    instance.to_world[3] = {7, 8, 9, 1};
    const glm::dvec3 expected = glm::normalize(glm::inverse(glm::transpose(part)) * normal);
    const glm::dvec3 placed = glm::normalize(placed_normal(normal, instance));
    EXPECT_LT(glm::distance(placed, expected), 1e-14) << mirror;
  }
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
    return read_mesh(inside / "a.gltf");
  };
  // Names that no program has encoded, and those of programs for Windows.
  write(inside / "10%.bin", square_chunk());
  std::filesystem::create_directory(inside / "parts");
  write(inside / "parts" / "a.bin", square_chunk());
  for (const char* uri : {"a%20b.bin", "a b.bin", "10%.bin", "10%25.bin", "parts\\\\a.bin"})
    EXPECT_EQ(read_with(uri).mesh.face_count(), 2) << uri;
  const std::string name = (inside / "a.gltf").string();
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("x/../../outside.bin"),
        std::string("%2e%2e/outside.bin"), (folder.path() / "outside.bin").string(),
        std::string("..\\\\outside.bin"), std::string("%2e%2e%5coutside.bin")}) {
    const std::string message =
        test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_with(uri); });
    EXPECT_TRUE(message.starts_with(name + ": buffers[0].uri: ") &&
                message.find("leads away from the folder of the file") != std::string::npos)
        << message;
  }
  const auto refusal = [&](const std::string& uri) {
    return test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_with(uri); });
  };
  for (const std::string& uri :
       {"file://" + (folder.path() / "outside.bin").string(), std::string("https://a.org/a.bin")})
    EXPECT_THAT(refusal(uri), testing::HasSubstr("is the address of something elsewhere"));
  for (const char* uri : {"%00", ""})
    EXPECT_THAT(refusal(uri), testing::HasSubstr("names no file"));
  EXPECT_EQ(test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_with("no.bin"); }),
            name + ": buffers[0].uri: " + (inside / "no.bin").string() +
                ": cannot read: No such file or directory; it belongs to this file, copy it along");
  EXPECT_EQ(glb_error(replaced(square_json(), "{\"byteLength\":60}",
                               "{\"byteLength\":60,\"uri\":\"a.bin\"}")),
            "a.glb: buffers[0].uri: `a.bin` is another file, but only embedded data can be read");
}

// What the project itself writes is read back to the last bit of float32.
TEST(ReadGltf, ReadsWhatIsWritten) {
  const SurfaceMesh surface = test::wavy_grid(9, 7);
  const std::vector<std::byte> bytes = encode_glb(surface, {});
  const MeshFile file = read_mesh(bytes, "own.glb", FileFormat::Glb);
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

// Sparse accessors: elements in the place of others.
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
