// Compressed files against plain ones, read back by our reader and by meshoptimizer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "files/gltf/surfaces.h"
#include "files/read_bytes.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"

namespace planish {
namespace {

using testing::HasSubstr;

GltfOptions with(GltfCompression compression, double error) {
  GltfOptions options;
  options.compression = compression;
  options.position_error = error;
  return options;
}

PolygonMesh read_back(const std::vector<std::byte>& glb) {
  return read_mesh(glb, "a.glb", FileFormat::Glb).mesh;
}

nlohmann::json document_of(const std::vector<std::byte>& glb) {
  return test::document_of({reinterpret_cast<const char*>(glb.data()), glb.size()});
}

// The triangles as sorted lists of surface vertices, each corner by the nearest of `vertices`.
std::vector<std::array<std::size_t, 3>> triangles_by_place(const PolygonMesh& mesh,
                                                           std::span<const glm::dvec3> vertices,
                                                           double error) {
  std::vector<std::size_t> nearest(mesh.positions.size());
  for (std::size_t v = 0; v < nearest.size(); ++v) {
    const auto at = std::ranges::min_element(
        vertices, {}, [&](const glm::dvec3& p) { return glm::distance(p, mesh.positions[v]); });
    EXPECT_LE(glm::distance(*at, mesh.positions[v]), error);
    nearest[v] = static_cast<std::size_t>(at - vertices.begin());
  }
  std::vector<std::array<std::size_t, 3>> triangles;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::array<std::size_t, 3> corners{};
    for (int k = 0; k < 3; ++k) corners[k] = nearest[mesh.face_vertices[mesh.face_offsets[f] + k]];
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    triangles.push_back(corners);
  }
  std::ranges::sort(triangles);
  return triangles;
}

TEST(CompressedGltf, HasTheSameTrianglesWithinTheError) {
  const SurfaceMesh surface = test::wavy_grid(40, 30, {3, -2, 1});
  // Plain files are read back to the last bit of float32.
  std::vector<glm::dvec3> rounded;
  for (const glm::dvec3& p : surface.positions) rounded.emplace_back(glm::vec3(p));
  const PolygonMesh whole = read_back(encode_glb(surface, {}));
  EXPECT_EQ(whole.vertex_count(), 40 * 30);
  const auto plain = triangles_by_place(whole, rounded, 0);
  for (const auto compression : {GltfCompression::Quantize, GltfCompression::Meshopt}) {
    for (const double error : {0.0, 1e-5, 1e-3}) {
      SCOPED_TRACE(error);
      GltfOptions options = with(compression, error);
      options.z_up = true;
      options.origin = {3, -2, 0};
      std::vector<glm::dvec3> decoded;
      options.decoded_rows = 1200;
      options.decoded = [&](std::span<const glm::dvec3> positions) {
        decoded.assign(positions.begin(), positions.end());
      };
      const auto glb = encode_glb(surface, options);
      PolygonMesh mesh = read_back(glb);
      // Back from upright.
      for (glm::dvec3& p : mesh.positions) p = {p.x, -p.z, p.y};
      EXPECT_EQ(triangles_by_place(mesh, surface.positions, error + 1e-6), plain);
      // Readers have the very positions that are said to be decoded.
      ASSERT_EQ(decoded.size(), surface.positions.size());
      EXPECT_NO_FATAL_FAILURE(triangles_by_place(mesh, decoded, 1e-12));
      for (std::size_t i = 0; i < decoded.size(); ++i)
        EXPECT_LE(glm::distance(decoded[i], surface.positions[i]), error + 1e-6);
    }
  }
}

// glTF-Transform writes no translation that is within 1e-5 of zero.
TEST(CompressedGltf, TinyModelsNeedNoTranslation) {
  for (const double scale : {1.0, 1e-7}) {
    SurfaceMesh surface = test::wavy_grid(40, 30, {3, -2, 1});
    for (glm::dvec3& p : surface.positions) p *= scale;
    for (const auto compression : {GltfCompression::Quantize, GltfCompression::Meshopt}) {
      std::vector<double> kept_float;
      GltfOptions options = with(compression, 1e-3 * scale);
      options.kept_float = [&](double moved) { kept_float.push_back(moved); };
      const auto glb = encode_glb(surface, options);
      EXPECT_NO_FATAL_FAILURE(
          triangles_by_place(read_back(glb), surface.positions, 1.01e-3 * scale));
      const bool is_tiny = scale < 1, is_packed = compression == GltfCompression::Meshopt;
      const nlohmann::json document = document_of(glb), node = document["nodes"][0];
      EXPECT_EQ(node.contains("translation"), !is_tiny);
      EXPECT_EQ(node.contains("scale"), is_packed || !is_tiny);
      EXPECT_EQ(kept_float, is_tiny && !is_packed ? std::vector{0.0} : std::vector<double>{});
    }
  }
}

TEST(CompressedGltf, IsSmallerAndSaysWhatItIs) {
  const SurfaceMesh surface = test::wavy_grid(200, 200);
  const auto plain = encode_glb(surface, {});
  const auto floats = encode_glb(surface, with(GltfCompression::Meshopt, 0));
  const auto fine = encode_glb(surface, with(GltfCompression::Meshopt, 1e-5));
  const auto coarse = encode_glb(surface, with(GltfCompression::Meshopt, 1e-3));
  EXPECT_LT(floats.size(), plain.size() / 2);
  EXPECT_LT(fine.size(), floats.size());
  EXPECT_LT(coarse.size(), fine.size());
  const nlohmann::json document = document_of(fine);
  EXPECT_EQ(document["extensionsRequired"],
            nlohmann::json({"EXT_meshopt_compression", "KHR_mesh_quantization"}));
  EXPECT_EQ(document["asset"]["extras"]["vertex_order"], "as triangles first use them");
  EXPECT_EQ(document["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"], true);
  EXPECT_FALSE(document["buffers"][1].contains("uri"));

  // 16 bits over 20 units do for 1e-3, and not for 1e-4.
  const auto shorts = document_of(encode_glb(surface, with(GltfCompression::Quantize, 1e-3)));
  EXPECT_EQ(shorts["accessors"][0]["componentType"], 5123);
  EXPECT_EQ(shorts["accessors"][0]["max"][0], 65535);
  const auto kept = document_of(encode_glb(surface, with(GltfCompression::Quantize, 1e-4)));
  EXPECT_EQ(kept["accessors"][0]["componentType"], 5126);
  EXPECT_EQ(kept["accessors"][1]["componentType"], 5122);
  EXPECT_EQ(kept["extensionsRequired"], nlohmann::json({"KHR_mesh_quantization"}));
}

// Those of the buffer, too, that streams stand for.
TEST(CompressedGltf, ViewsLieWithinTheirBuffers) {
  const nlohmann::json document =
      document_of(encode_glb(test::wavy_grid(40, 30), with(GltfCompression::Meshopt, 1e-4)));
  ASSERT_EQ(document["buffers"].size(), 2u);
  const auto expect_within = [&](const nlohmann::json& place) {
    const std::uint64_t first = place.value("byteOffset", std::uint64_t{0});
    const std::uint64_t bytes = place["byteLength"];
    const std::uint64_t all = document["buffers"][place["buffer"].get<int>()]["byteLength"];
    EXPECT_LE(first, all) << place;
    EXPECT_LE(bytes, all - first) << place;
  };
  for (const nlohmann::json& view : document["bufferViews"]) {
    expect_within(view);
    if (view.contains("extensions")) expect_within(view["extensions"]["EXT_meshopt_compression"]);
  }
}

// Above 2^19 faces.
TEST(CompressedGltf, BlocksOfALargeSurfaceMeet) {
  const SurfaceMesh surface = test::wavy_grid(750, 705, {3, -2, 1});
  for (const auto compression : {GltfCompression::Quantize, GltfCompression::Meshopt}) {
    GltfOptions options = with(compression, 1e-4);
    std::vector<glm::dvec3> decoded;
    options.decoded_rows = 1000;
    options.decoded = [&](std::span<const glm::dvec3> positions) {
      decoded.assign(positions.begin(), positions.end());
    };
    const auto glb = encode_glb(surface, options);
    oneapi::tbb::task_arena(1).execute([&] { EXPECT_EQ(encode_glb(surface, options), glb); });
    const nlohmann::json document = document_of(glb);
    EXPECT_EQ(document["meshes"].size(), 1u);
    EXPECT_EQ(document["meshes"][0]["primitives"].size(), 2u);
    EXPECT_EQ(document["materials"].size(), 1u);
    // Vertices of both blocks have the same places: nothing stays apart.
    const PolygonMesh mesh = read_back(glb);
    EXPECT_EQ(mesh.positions.size(), surface.positions.size());
    EXPECT_EQ(mesh.face_count(), 2 * 749 * 704);
    ASSERT_EQ(decoded.size(), 1000u);
    for (std::size_t i = 0; i < decoded.size(); ++i)
      EXPECT_LE(glm::distance(decoded[i], surface.positions[i]), 1e-4 + 1e-6);
  }
}

TEST(CompressedGltf, AttributesComeBackByPrimitive) {
  SurfaceMesh surface = test::two_charts();
  for (std::size_t v = 0; v < surface.positions.size(); ++v)
    surface.colors.emplace_back(0.03125f * static_cast<float>(v), 0.5f, 0.25f, 1.0f);
  for (const auto& [compression, error, color_error] :
       {std::tuple{GltfCompression::None, 1e-6, 0.0},
        {GltfCompression::Quantize, 2e-4, 1e-5},
        {GltfCompression::Meshopt, 2e-4, 1e-5}}) {
    const PolygonMesh mesh = read_back(encode_glb(surface, with(compression, 1e-4)));
    ASSERT_EQ(mesh.positions.size(), 15u);
    ASSERT_EQ(mesh.face_count(), 16);
    for (std::int32_t f = 0; f < 16; ++f) {
      const FaceGroup& group = mesh.groups[mesh.face_groups[f]];
      const bool is_left = group.name == "left";
      EXPECT_EQ(group.material, is_left ? "red" : "blue");
      for (std::int32_t c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
        const glm::dvec3& place = mesh.positions[mesh.face_vertices[c]];
        EXPECT_LE(place.x, is_left ? 0.5001 : 1.0001);
        EXPECT_NEAR(mesh.uvs[mesh.face_uvs[c]].x, place.x + (is_left ? 0 : 10), error);
        EXPECT_NEAR(mesh.uvs[mesh.face_uvs[c]].y, place.y, error);
        const double row = std::round(place.x * 4) + 5 * std::round(place.y * 2);
        const glm::vec4& color = mesh.colors[mesh.face_vertices[c]];
        EXPECT_NEAR(color.r, 0.03125 * row, color_error);
        EXPECT_NEAR(color.g, 0.5, color_error);
        EXPECT_NEAR(color.b, 0.25, color_error);
        EXPECT_EQ(color.a, 1);
      }
    }
  }
}

TEST(PackedNumbers, GridsKeepTheError) {
  std::vector<float> numbers;
  for (int i = 0; i < 3000; ++i) numbers.push_back(7 * std::sin(0.37f * static_cast<float>(i)));
  for (const double error : {1e-5, 3e-4, 0.2}) {
    const auto exponent = grid_exponent(numbers, error);
    ASSERT_TRUE(exponent);
    const auto words = on_grid(numbers, *exponent);
    const auto decoded = decode_grid(encode_vertices(std::as_bytes(std::span(words)), 12), 1000);
    double worst = 0;
    for (std::size_t i = 0; i < 1000; ++i)
      worst = std::max<double>(
          worst, glm::distance(glm::dvec3(decoded[i]),
                               glm::dvec3(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2])));
    EXPECT_LE(worst, error);
    EXPECT_GT(worst, error / 8);
  }
  // 24 bits end at 7 / 2^23, where float32 is as good.
  EXPECT_FALSE(grid_exponent(numbers, 1e-7));
  EXPECT_FALSE(grid_exponent(numbers, 0));
}

TEST(PackedNumbers, NormalsTurnByAFiftiethOfADegree) {
  std::vector<glm::vec3> normals;
  for (int i = 0; i < 5000; ++i) {
    const double z = 1 - 2 * (i + 0.5) / 5000, angle = 2.399963 * i, r = std::sqrt(1 - z * z);
    normals.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  const std::span numbers(&normals[0].x, 3 * normals.size());
  auto packed = octahedral(numbers, 3);
  meshopt_decodeFilterOct(packed.data(), normals.size(), 8);
  auto shorts = short_vectors(numbers, 3);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::int16_t* values : {packed.data(), shorts.data()}) {
      const glm::dvec3 found(values[4 * i], values[4 * i + 1], values[4 * i + 2]);
      const double turn =
          std::asin(glm::length(glm::cross(glm::normalize(found), glm::dvec3(normals[i]))));
      EXPECT_LE(turn * 57.2958, 0.02);
      EXPECT_GT(glm::dot(found, glm::dvec3(normals[i])), 0);
    }
  }
}

TEST(StripOrder, NamesEveryVertexOnceAndKeepsTriangles) {
  const std::vector<std::uint32_t> indices{5, 1, 2, 2, 1, 3, 3, 1, 0, 0, 5, 3};
  const StripOrder order = strip_order(indices, 7);
  std::vector<std::uint32_t> sorted(order.new_vertices.begin(), order.new_vertices.end());
  std::ranges::sort(sorted);
  EXPECT_THAT(sorted, testing::ElementsAre(0, 1, 2, 3, 4, 5, 6));
  const auto canonical = [](auto corners) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      std::array<std::uint32_t, 3> t{corners[i], corners[i + 1], corners[i + 2]};
      std::ranges::rotate(t, std::ranges::min_element(t));
      triangles.push_back(t);
    }
    std::ranges::sort(triangles);
    return triangles;
  };
  std::vector<std::uint32_t> renamed;
  for (const std::uint32_t v : indices) renamed.push_back(order.new_vertices[v]);
  EXPECT_EQ(canonical(renamed),
            canonical(std::vector<std::uint32_t>(order.indices.begin(), order.indices.end())));
  EXPECT_EQ(order.indices[0], 0u);
}

// A stream of six bytes cannot stand for a gigabyte.
TEST(ReadMeshopt, SizesAreBoundedBeforeMemoryIsTaken) {
  struct Row {
    int stride;
    const char *count, *mode, *message;
  };
  std::vector<test::WrongJson> files;
  for (const auto& [stride, count, mode, message] :
       {Row{12, "9000000000", "ATTRIBUTES", "count: 9000000000 elements cannot come from 48 bytes"},
        Row{12, "257", "ATTRIBUTES", "257 elements cannot come"},
        Row{12, "4", "ATTRIBUTES",
            "bufferViews[0].extensions.EXT_meshopt_compression: the stream is no"},
        Row{10, "4", "ATTRIBUTES", "byteStride: 10 is no multiple of 4 up to 256"},
        Row{2, "147", "TRIANGLES", "count: 147 elements cannot come from 48 bytes"},
        Row{2, "4", "TRIANGLES", "4 corners make no whole triangles"},
        Row{3, "3", "INDICES", "3 is neither 2 nor 4"},
        Row{12, "4", "LINES", "`LINES` is not ATTRIBUTES, TRIANGLES or INDICES"}})
    files.push_back({R"({"buffer":0,"byteLength":48})",
                     R"({"buffer":0,"byteLength":48,"extensions":{"EXT_meshopt_compression":)"
                     R"({"buffer":0,"byteLength":48,"byteStride":)" +
                         std::to_string(stride) + R"(,"count":)" + count + R"(,"mode":")" + mode +
                         "\"}}}",
                     HasSubstr(message)});
  test::expect_squares_refused(files);
}

TEST(ReadMeshopt, DamagedFilesAreReadOrRefused) {
  SurfaceMesh surface = test::two_charts();
  surface.colors.assign(surface.positions.size(), glm::vec4(0.5f));
  const auto good = encode_glb(surface, with(GltfCompression::Meshopt, 1e-4));
  std::mt19937 random(5);
  int refused = 0;
  for (int round = 0; round < 20000; ++round) {
    auto bytes = good;
    for (unsigned i = random() % 3; i < 3; ++i)
      bytes[12 + random() % (bytes.size() - 12)] = static_cast<std::byte>(random());
    try {
      const PolygonMesh mesh = read_back(bytes);
      for (const std::int32_t vertex : mesh.face_vertices) ASSERT_LT(vertex, mesh.vertex_count());
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::UnreadableInput);
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace planish
