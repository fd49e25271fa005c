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

#include "files/gltf/parsed_gltf.h"
#include "files/read_bytes.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/read_gltf.h"
#include "support/files.h"

namespace planish {
namespace {

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
  const auto faces = [&](const std::string& mode, std::initializer_list<double> indices) {
    const std::string json =
        replaced(replaced(square_json(), R"("indices":1)", R"("indices":1,"mode":)" + mode),
                 R"("count":6)", R"("count":)" + std::to_string(indices.size()));
    return read_glb(glb_of(json, square_chunk().substr(0, 48) + values<std::uint16_t>(indices) +
                                     std::string(12, '\0')))
        .mesh.face_vertices;
  };
  EXPECT_THAT(faces("5", {0, 1, 3, 2}), ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_THAT(faces("6", {0, 1, 2, 3}), ElementsAre(1, 2, 0, 2, 3, 0));
  EXPECT_THAT(faces("5", {0, 1}), IsEmpty());
}

TEST(ReadGltf, ReadsWithoutIndicesAndWelds) {
  test::GlbParts parts;
  const std::size_t points = parts.add_accessor(
      values<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, -0.0, 0, 0, 1, 1, 0, 0, 1, 0}), 5126, 6, "VEC3");
  parts.json["nodes"] = {{{"mesh", 0}}};
  parts.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", points}}}}}}}};
  const MeshFile file = read_glb(parts.glb());
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.welded_vertex_count, 2);
}

TEST(ReadGltf, WeldsAcrossPrimitivesAndNodes) {
  test::GlbParts parts = test::square_parts();
  parts.json["scenes"][0]["nodes"] = {0, 1};
  parts.json["nodes"].push_back({{"mesh", 0}, {"translation", {1, 0, 0}}});
  const MeshFile file = read_glb(parts.glb());
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2));
  EXPECT_EQ(file.mesh.positions[5], glm::dvec3(2, 1, 0));
  EXPECT_EQ(file.welded_vertex_count, 2);
}

TEST(ReadGltf, AppliesTransformsDownTheTree) {
  // Parent: a quarter turn about z, then (10, 0, 0); child: twice as long in x, then (0, 0, 5).
  const std::string half = std::to_string(std::sqrt(0.5));
  const MeshFile file =
      read_square(R"([{"mesh":0}])", R"([{"children":[1],"translation":[10,0,0],"rotation":[0,0,)" +
                                         half + "," + half +
                                         R"(]},{"mesh":0,"scale":[2,1,1],"translation":[0,0,5]}])");
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
  const std::string given = R"("scene":0,"scenes":[{"nodes":[0]}],)";
  const std::string two = R"("scenes":[{"nodes":[0]},{}],)";
  EXPECT_EQ(read_square(given, R"("scene":1,)" + two).mesh.face_count(), 0);
  EXPECT_EQ(read_square(given, two).mesh.face_count(), 2);
  EXPECT_EQ(read_square(given, "").mesh.face_count(), 2);
}

TEST(ReadGltf, ReadsQuantisedPositionsWithAStride) {
  test::GlbParts parts = test::square_parts();
  const std::size_t points = parts.add_accessor(
      values<std::int8_t>({0, 0, 0, 99, 127, 0, 0, 99, 127, -127, 0, 99, -128, 127, 0, 99}), 5120,
      4, "VEC3");
  parts.json["accessors"][points]["normalized"] = true;
  parts.json["bufferViews"].back()["byteStride"] = 4;
  parts.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = points;
  EXPECT_THAT(read_glb(parts.glb()).mesh.positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(1, -1, 0),
                          glm::dvec3(-1, 1, 0)));
}

TEST(ReadGltf, CountsWhatCarriesNoSurface) {
  const MeshFile file = read_square(R"("primitives":[)",
                                    R"("primitives":[{"attributes":{"POSITION":0},"mode":0},)"
                                    R"({"attributes":{"POSITION":0},"mode":1},{"attributes":{}},)");
  EXPECT_EQ(file.dropped_element_count, 3);
  EXPECT_EQ(file.mesh.face_count(), 2);
}

TEST(ReadGltf, WarnsOfSkinsAndMorphTargets) {
  test::GlbParts parts = test::square_parts();
  parts.json["nodes"][0]["skin"] = 0;
  parts.json["skins"] = {{{"joints", {0}}}};
  parts.json["meshes"][0]["primitives"][0]["targets"] = {nlohmann::json::object()};
  const MeshFile file = read_glb(parts.glb());
  ASSERT_THAT(test::codes_of(file.warnings), ElementsAre("ignored-deformation"));
  EXPECT_EQ(file.warnings[0].count, 2);
}

// The place of a node with a skin means nothing; where its joints stand does (section 3.7.3.3).
TEST(ReadGltf, JointsPlaceWhatTheyMove) {
  // Two joints, at (0, 0, 5) and turned about z by a right angle below it; the second half of the
  // square hangs at the second one, all of its first vertex at neither.
  test::GlbParts parts = test::square_parts();
  nlohmann::json& attributes = parts.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = parts.add_accessor(
      values<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}), 5121, 4, "VEC4");
  attributes["WEIGHTS_0"] = parts.add_accessor(
      values<float>({0, 0, 0, 0, 1, 0, 0, 0, 0.25, 0.75, 0, 0, 2, 0, 0, 0}), 5126, 4, "VEC4");
  const std::size_t inverses =
      parts.add_accessor(values<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1}) +
                             values<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}),
                         5126, 2, "MAT4");
  parts.json["nodes"] =
      nlohmann::json::parse(R"([{"mesh":0,"skin":0,"translation":[100,0,0]},)"
                            R"({"translation":[0,0,5],"children":[2]},{"rotation":[0,0,1,1]}])");
  parts.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", inverses}}};
  const MeshFile file = read_glb(parts.glb());
  ASSERT_EQ(file.mesh.vertex_count(), 4);
  // The first as the first joint has it; (1, 0, 0) too; of (1, 1, 0) a quarter stays there, the
  // rest is at (-1, 1, 5); (0, 1, 0) is all at (-1, 0, 5).
  const glm::dvec3 expected[] = {{0, 0, 0}, {1, 0, 0}, {-0.5, 1, 3.75}, {-1, 0, 5}};
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LT(glm::distance(file.mesh.positions[v], expected[v]), 1e-12) << v;
  parts.json["skins"][0]["joints"] = {1};
  test::expect_refused("a.glb", {{parts.glb(),
                                  " meshes[0].primitives[0].attributes.JOINTS_0: vertex 2 names "
                                  "joint 1, and the skin has 1"}});
}

TEST(ReadGltf, LeavesOutWhatIsHidden) {
  test::GlbParts parts = test::square_parts();
  parts.json["extensionsRequired"] = {"KHR_node_visibility"};
  parts.json["nodes"] = nlohmann::json::parse(
      R"([{"children":[1,2]},{"mesh":0},{"children":[3],"extensions":{"KHR_node_visibility":)"
      R"({"visible":false}}},{"mesh":0,"translation":[0,0,1]}])");
  const MeshFile file = read_glb(parts.glb());
  EXPECT_EQ(file.mesh.face_count(), 2);
  ASSERT_THAT(test::codes_of(file.warnings), ElementsAre("hidden-nodes"));
  EXPECT_EQ(file.warnings[0].count, 1);
  parts.json["nodes"][2]["extensions"]["KHR_node_visibility"]["visible"] = true;
  EXPECT_EQ(read_glb(parts.glb()).mesh.face_count(), 4);
}

// Section 3.6.2.1: what has no buffer view is zero.
TEST(ReadGltf, AccessorsWithoutViewsAreZeros) {
  test::GlbParts parts = test::square_parts();
  for (const char* type : {"VEC2", "VEC4"})
    parts.json["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", type}});
  parts.json["meshes"][0]["primitives"][0]["attributes"].update(
      {{"TEXCOORD_0", 2}, {"COLOR_0", 3}});
  const PolygonMesh mesh = read_glb(parts.glb()).mesh;
  EXPECT_EQ(mesh.positions[2], glm::dvec3(1, 1, 0));
  EXPECT_EQ(mesh.uvs, std::vector<glm::dvec2>(4, {0, 1}));  // upwards
  EXPECT_EQ(mesh.colors, std::vector<glm::vec4>(4, glm::vec4(0.0f)));
}

// Of two vertices at one place the first has the colour.
TEST(ReadGltf, WarnsOfColorsThatShareAPlace) {
  test::GlbParts parts = test::square_parts();
  const std::size_t colors = parts.add_accessor(
      values<std::uint8_t>({0, 0, 0, 255, 255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255}), 5121, 4,
      "VEC4");
  parts.json["accessors"][colors]["normalized"] = true;
  parts.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colors;
  EXPECT_THAT(read_glb(parts.glb()).warnings, IsEmpty());
  // The last vertex lies on the first.
  parts.bytes.replace(0, 60,
                      values<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0}) +
                          values<std::uint16_t>({0, 1, 2, 1, 2, 3}));
  const MeshFile file = read_glb(parts.glb());
  EXPECT_THAT(test::messages_of(file.warnings),
              ElementsAre("1 of 4 vertices has another colour at a place they share: there the "
                          "first one's is taken"));
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
  // The 60 bytes of the square in base64.
  const std::string base64 =
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAACAAMA";
  const std::string json =
      replaced(square_json(), R"({"byteLength":60})",
               R"({"byteLength":60,"uri":"data:application/octet-stream;base64,)" + base64 + "\"}");
  const MeshFile file = read_glb(json);
  EXPECT_EQ(file.format, FileFormat::Gltf);
  EXPECT_THAT(file.mesh.face_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
  EXPECT_EQ(file.mesh.positions[2], glm::dvec3(1, 1, 0));
  test::expect_refused(
      "a.glb",
      {{replaced(json, base64, "AA*A"),
        " buffers[0].uri: `data:application/octet-stream;base64,AA*...` is no data URI: its base64 "
        "is broken, or it has no data"},
       {replaced(json, base64, "AAAA"),
        " buffers[0].byteLength: promises 60 bytes, but there are only 3"},
       {replaced(square_json(), R"({"byteLength":60})", R"({"byteLength":60,"uri":"a.bin"})"),
        " buffers[0].uri: `a.bin` is another file, but only embedded data can be read"}});
}

std::string text_in(const std::optional<std::vector<std::byte>>& bytes) {
  return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : "none";
}

// RFC 2397, and what is in none.
TEST(DataUri, IsThatOfItsRfc) {
  for (const auto& [uri, text] : std::vector<std::pair<std::string, std::string>>{
           {"data:,A%20brief%20note", "A brief note"},
           {"data:text/plain;charset=iso-8859-7,%be%fg%be", "\xbe%fg\xbe"},
           {"data:application/octet-stream,%00%ff", std::string("\0\xff", 2)},
           {"data:;base64,Zm9v", "foo"},
           {"data:;base64,Zm8%3D", "fo"},
           {"data:;base64,Zm-9", "none"},
           {"data:application/octet-stream", "none"}})
    EXPECT_EQ(text_in(decode_data_uri(uri)), text) << uri;
}

// The test vectors of RFC 4648, section 10, and what has more or other digits than they may.
TEST(Base64, IsThatOfItsRfc) {
  for (const auto& [digits, text] :
       std::vector<std::pair<std::string, std::string>>{{"", ""},
                                                        {"Zg==", "f"},
                                                        {"Zm8=", "fo"},
                                                        {"Zm9v", "foo"},
                                                        {"Zm9vYg==", "foob"},
                                                        {"Zm9vYmE=", "fooba"},
                                                        {"Zm9vYmFy", "foobar"},
                                                        {"Zg===", "none"},
                                                        {"Z", "none"},
                                                        {"Zm9v=Zg", "none"},
                                                        {"Zm9-", "none"}})
    EXPECT_EQ(text_in(decode_base64(digits)), text) << digits;
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
  const std::filesystem::path inside = folder.path() / "inside";
  const std::string outside = (folder.path() / "outside.bin").generic_string();
  std::filesystem::create_directories(inside / "parts");
  // Names that no program has encoded, and those of programs for Windows.
  for (const char* name : {"a b.bin", "10%.bin", "parts/a.bin", "../outside.bin"})
    std::ofstream(inside / name, std::ios::binary) << square_chunk();
  const auto read_with = [&](const std::string& uri) {
    std::ofstream(inside / "a.gltf") << replaced(square_json(), R"({"byteLength":60})",
                                                 R"({"byteLength":60,"uri":")" + uri + "\"}");
    return read_mesh(inside / "a.gltf");
  };
  for (const char* uri : {"a%20b.bin", "a b.bin", "10%.bin", "10%25.bin", "parts\\\\a.bin"})
    EXPECT_EQ(read_with(uri).mesh.face_count(), 2) << uri;
  const char *away = "leads away from the folder of the file",
             *elsewhere = "is the address of something elsewhere", *no_name = "names no file";
  for (const auto& [uri, message] : std::vector<std::pair<std::string, std::string>>{
           {"../outside.bin", away},
           {"x/../../outside.bin", away},
           {"%2e%2e/outside.bin", away},
           {outside, outside.starts_with('/') ? away : elsewhere},  // C:/ is none of a folder
           {"..\\\\outside.bin", away},
           {"%2e%2e%5coutside.bin", away},
           {"file://" + outside, elsewhere},
           {"https://a.org/a.bin", elsewhere},
           {"%00", no_name},
           {"", no_name},
           {"no.bin", (inside / "no.bin").string() + ": cannot read: No such file or directory; it "
                                                     "belongs to this file, copy it along"}})
    EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput, [&] { (void)read_with(uri); }),
                testing::AllOf(testing::StartsWith((inside / "a.gltf: buffers[0].uri: ").string()),
                               testing::HasSubstr(message)))
        << uri;
}

// Sparse accessors: elements in the place of others.
using testing::HasSubstr;

const std::string kSparse =
    R"({"count":2,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}})";

// The square with `sparse` in its positions, numbers of vertices in view 2 and two positions in
// view 3.
test::GlbParts sparse_parts(const std::string& numbers, const std::string& sparse = kSparse) {
  test::GlbParts parts = test::square_parts();
  parts.add_view(numbers);
  parts.add_view(values<float>({5, 6, 7, 8, 9, 10}));
  parts.json["accessors"][0]["sparse"] = nlohmann::json::parse(sparse);
  return parts;
}

TEST(ReadGltfSparse, ElementsTakeTheirPlaces) {
  EXPECT_THAT(read_glb(sparse_parts(values<std::uint16_t>({1, 3})).glb()).mesh.positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(5, 6, 7), glm::dvec3(1, 1, 0),
                          glm::dvec3(8, 9, 10)));
  // Indices of one byte, behind others.
  const std::string bytes = replaced(replaced(kSparse, "5123", "5121"), R"("bufferView":2)",
                                     R"("bufferView":2,"byteOffset":2)");
  EXPECT_THAT(
      read_glb(sparse_parts(values<std::uint8_t>({7, 7, 0, 2}), bytes).glb()).mesh.positions,
      ElementsAre(glm::dvec3(5, 6, 7), glm::dvec3(1, 0, 0), glm::dvec3(8, 9, 10),
                  glm::dvec3(0, 1, 0)));
}

TEST(ReadGltfSparse, WithoutABufferViewTheOthersAreZeros) {
  test::GlbParts parts = sparse_parts(values<std::uint16_t>({1, 2}));
  parts.json["accessors"][0].erase("bufferView");
  const PolygonMesh mesh = read_glb(parts.glb()).mesh;
  // Vertices 0 and 3 are welded at the origin, which leaves one triangle.
  EXPECT_THAT(mesh.positions,
              ElementsAre(glm::dvec3(0, 0, 0), glm::dvec3(5, 6, 7), glm::dvec3(8, 9, 10)));
  EXPECT_THAT(mesh.face_vertices, ElementsAre(0, 1, 2));
}

TEST(ReadGltfSparse, IndicesAreReadToo) {
  test::GlbParts parts = test::square_parts();
  parts.add_view(values<std::uint32_t>({0, 4}) + values<std::uint16_t>({3, 1}));
  parts.json["accessors"][1]["sparse"] =
      nlohmann::json::parse(R"({"count":2,"indices":{"bufferView":2,"componentType":5125},)"
                            R"("values":{"bufferView":2,"byteOffset":8}})");
  const PolygonMesh mesh = read_glb(parts.glb()).mesh;
  // 3 1 2 and 0 1 3 of the square, numbered as they come.
  EXPECT_THAT(mesh.face_vertices, ElementsAre(0, 1, 2, 3, 1, 0));
  EXPECT_THAT(mesh.positions, ElementsAre(glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0),
                                          glm::dvec3(1, 1, 0), glm::dvec3(0, 0, 0)));
}

// tinygltf hands the parts on; put together by hand.
TEST(ReadGltfSparse, TinygltfSeesTheSameParts) {
  const std::string glb = sparse_parts(values<std::uint16_t>({1, 3})).glb();
  const tinygltf::Model model = test::parsed(test::bytes_of(glb));
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
  const std::string place = " accessors[0].sparse", count = R"("count":2)";
  std::vector<test::WrongFile> files;
  const auto add = [&](const std::string& numbers, const test::WrongJson& change) {
    files.push_back(
        {sparse_parts(numbers, replaced(kSparse, change.from, change.to)).glb(), change.message});
  };
  add(values<std::uint16_t>({3, 1}),
      {"", "", place + ".indices: entry 1 is 1 behind 3; they must ascend"});
  add(values<std::uint16_t>({1, 1}),
      {"", "", place + ".indices: entry 1 is 1 behind 1; they must ascend"});
  add(values<std::uint16_t>({1, 4}), {"", "", place + ".indices: entry 1 names element 4 of 4"});
  const std::string good = values<std::uint16_t>({1, 3});
  for (const test::WrongJson& change : std::vector<test::WrongJson>{
           {count, R"("count":5)", place + ".count: 5 is more than the accessor has (4)"},
           {count, R"("count":0)", place + ".count: 0 is no integer from 1"},
           {count, R"("count":3)",
            place + ".indices: reaches to byte 6 of bufferViews[2], which has 4"},
           {R"("bufferView":3)", R"("bufferView":3,"byteOffset":4)",
            place + ".values: reaches to byte 28 of bufferViews[3], which has 24"},
           {"5123", "5126", place + ".indices.componentType: 5126 cannot be used for indices"},
           {R"("bufferView":3)", R"("bufferView":4)",
            " bufferViews: entry 4 is asked for, but there are only 4"},
           {R"({"bufferView":3})", "{}", place + ".values: has no `bufferView`"}})
    add(good, change);
  test::GlbParts strided = sparse_parts(good);
  strided.json["bufferViews"][3]["byteStride"] = 12;
  files.push_back(
      {strided.glb(),
       HasSubstr("bufferViews[3].byteStride: the parts of sparse accessors have no stride")});
  test::expect_refused("a.glb", files);
}

// Looked at once.
TEST(ReadGltfSparse, EveryPlaceHasThem) {
  test::GlbParts parts = sparse_parts(values<std::uint16_t>({1, 3}));
  parts.json["scenes"][0]["nodes"] = {0, 1};
  parts.json["nodes"].push_back({{"mesh", 0}, {"translation", {20, 0, 0}}});
  EXPECT_EQ(read_glb(parts.glb()).mesh.positions[5], glm::dvec3(25, 6, 7));
}

}  // namespace
}  // namespace planish
