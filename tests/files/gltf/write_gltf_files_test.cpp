#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <string>

#include "files/gltf/parsed_gltf.h"
#include "files/gltf/surfaces.h"
#include "planish/core/error.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish {
namespace {

// Bytes and files that the glTF writer makes, and what it refuses to write.

using test::flat_polygons;
using test::indices_of;
using test::parsed;
using test::vectors_of;
using test::wavy_grid;
using ::testing::HasSubstr;

class WriteGltfFiles : public testing::Test {
 protected:
  // All files, by name.
  [[nodiscard]] std::map<std::string, std::string> contents() const {
    const auto files = test::files_below(folder_);
    return {files.begin(), files.end()};
  }
  [[nodiscard]] tinygltf::Model document(const std::string& name) const {
    tinygltf::Model model;
    std::string error, warning;
    EXPECT_TRUE(
        tinygltf::TinyGLTF().LoadASCIIFromFile(&model, &error, &warning, (folder_ / name).string()))
        << error;
    return model;
  }

  test::TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
};

TEST_F(WriteGltfFiles, BytesDoNotDependOnThreadsOrRun) {
  const SurfaceMesh surface = wavy_grid(500, 400);
  const auto glb = encode_glb(surface, {});
  oneapi::tbb::task_arena one_thread(1);
  one_thread.execute([&] { EXPECT_EQ(encode_glb(surface, {}), glb); });
  write_gltf(folder_ / "a.glb", surface, {});
  EXPECT_EQ(contents()["a.glb"],
            std::string(reinterpret_cast<const char*>(glb.data()), glb.size()));
}

TEST_F(WriteGltfFiles, GltfHasABufferBesideIt) {
  const SurfaceMesh surface = wavy_grid(20, 10);
  const GltfFile written = write_gltf(folder_ / "two words.GLTF", surface, {});
  auto files = contents();
  EXPECT_EQ(files.size(), 2u);
  EXPECT_EQ(written.byte_count, files["two words.GLTF"].size() + files["two words.bin"].size());
  EXPECT_EQ(written.vertex_count, 200u);
  EXPECT_EQ(written.triangle_count, 2u * 19 * 9);
  const tinygltf::Model model = document("two words.GLTF");
  const auto embedded = parsed(encode_glb(surface, {}));
  EXPECT_EQ(vectors_of(model, 0), vectors_of(embedded, 0));
  EXPECT_EQ(indices_of(model), indices_of(embedded));
}

TEST_F(WriteGltfFiles, FourGibibytesAreRefusedNamingTheWayOut) {
  // 12 + 8 + 8 bytes of headers: the largest multiple of 4 that fits is 2^32 - 4.
  const std::uint64_t largest = (std::uint64_t{1} << 32) - 4;
  EXPECT_EQ(glb_byte_count(1001, largest - 28 - 1004, "a.glb"), largest);
  EXPECT_THAT(
      test::message_of(ErrorCode::InvalidArgument,
                       [&] { (void)glb_byte_count(1001, largest - 28 - 1004 + 1, "a.glb"); }),
      testing::AllOf(HasSubstr("a.glb: 4294967296 bytes"), HasSubstr("write .gltf")));
}

TEST_F(WriteGltfFiles, LargeFilesAreWarnedOf) {
  GltfOptions options;
  options.name = "big";
  std::vector<Warning> warnings;
  options.callbacks.warning = [&](const Warning& warning) { warnings.push_back(warning); };
  const SurfaceMesh surface = wavy_grid(4, 3);
  const auto size = encode_glb(surface, options).size();
  EXPECT_TRUE(warnings.empty());
  options.large_bytes = size;
  (void)write_gltf(folder_ / "a.glb", surface, options);
  EXPECT_TRUE(warnings.empty());
  options.large_bytes = size - 1;
  (void)write_gltf(folder_ / "a.glb", surface, options);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "large-file");
  EXPECT_THAT(warnings[0].message, HasSubstr("big: " + std::to_string(size) + " bytes"));
  options.large_bytes = 1;  // of the buffer
  (void)write_gltf(folder_ / "a.gltf", surface, options);
  EXPECT_EQ(warnings.size(), 2u);
}

TEST_F(WriteGltfFiles, LayoutCountsIn64Bits) {
  GltfVertices vertices;
  vertices.parts = {{.vertex_count = 1000000000, .triangle_count = 2000000000}};
  const GltfPayload payload = plain_payload({}, vertices, {});
  EXPECT_EQ(payload.vertex_count, 1000000000u);
  EXPECT_EQ(payload.arrays[payload.primitives[0].indices].bytes, 24000000000u);
  EXPECT_EQ(payload.buffer_bytes, 48000000000u);
}

TEST_F(WriteGltfFiles, UnusableSurfacesAreRefusedNamingTheElement) {
  struct Row {
    const char* message;
    std::int64_t element;
    std::function<void(SurfaceMesh&)> spoil;
  };
  const SurfaceMesh triangle = flat_polygons({{{0, 0}, {1, 0}, {0, 1}}});
  for (const auto& [message, element, spoil] :
       std::vector<Row>{{"vertex 5", 5, [](auto& s) { s.positions[5].y = 1e300; }},
                        {"vertex 6", 6, [](auto& s) { s.positions[6].z = std::nan(""); }},
                        {"vertex 7", 7, [](auto& s) { s.normals[7] = glm::vec3(0); }},
                        {"vertex 8", 8, [](auto& s) { s.normals[8].x = std::nanf(""); }},
                        {"corner 9", 9, [](auto& s) { s.face_vertices[9] = 16; }},
                        {"corner 10", 10, [](auto& s) { s.face_vertices[10] = -1; }},
                        {"15 normals", -1, [](auto& s) { s.normals.pop_back(); }},
                        {"no face", -1, [](auto& s) { s.face_vertices.clear(); }},
                        {"multiple", -1, [](auto& s) { s.face_vertices.pop_back(); }},
                        {"no face", -1, [](auto& s) { s = SurfaceMesh{}; }},
                        {"", 1,
                         [](auto& s) {
                           s = flat_polygons({{{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {1, 0}}});
                         }},
                        {"offsets", -1, [&](auto& s) {
                           s = triangle;
                           s.face_offsets = {0, 2147483647};
                         }}}) {
    SCOPED_TRACE(message);
    SurfaceMesh bad = wavy_grid(4, 4);
    spoil(bad);
    try {
      write_gltf(folder_ / "bad.glb", bad, {});
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), HasSubstr(message));
      if (element >= 0) {
        EXPECT_EQ(error.element(), element);
      }
    }
    EXPECT_THAT(contents(), testing::IsEmpty());
  }
}

TEST_F(WriteGltfFiles, UnwritableFoldersAndExtensionsAreNamed) {
  for (const auto& [name, code] : {std::pair{"none/a.glb", ErrorCode::UnwritableOutput},
                                   {"a.obj", ErrorCode::InvalidArgument}})
    EXPECT_THAT(
        test::message_of(code, [&, n = name] { write_gltf(folder_ / n, wavy_grid(2, 2), {}); }),
        HasSubstr(name));
}

TEST_F(WriteGltfFiles, UriIsPercentEncoded) {
  EXPECT_EQ(encode_uri("Az09-._~.bin"), "Az09-._~.bin");
  EXPECT_EQ(encode_uri("a b%/\xC3\xA4.bin"), "a%20b%25%2F%C3%A4.bin");
}

// A .gltf of several buffers, read back by our reader and by tinygltf.

namespace fs = std::filesystem;
using SeveralBuffers = WriteGltfFiles;

SurfaceMesh laden_grid(std::int32_t columns, std::int32_t rows) {
  SurfaceMesh surface = test::wavy_grid(columns, rows);
  for (const glm::dvec3& p : surface.positions) surface.uvs.emplace_back(p.x, p.y);
  // A seam in the middle, whose vertices have a second texture coordinate.
  for (const glm::dvec3& p : surface.positions) surface.uvs.emplace_back(p.x + 100, p.y);
  const auto count = static_cast<std::int32_t>(surface.positions.size());
  for (std::size_t c = 0; c < surface.face_vertices.size(); ++c) {
    const auto face = static_cast<std::int32_t>(c / 4);
    const bool is_right = face % (columns - 1) >= columns / 2;
    surface.face_uvs.push_back(surface.face_vertices[c] + (is_right ? count : 0));
    if (c % 4 == 0) surface.face_groups.push_back(is_right ? 1 : 0);
  }
  surface.groups = {{"left", "red"}, {"right", "blue"}};
  for (std::int32_t v = 0; v < count; ++v)
    surface.colors.emplace_back(0.25f * static_cast<float>(v % 5), 0.5f, 0.25f, 1.0f);
  return surface;
}

using Numbers = std::array<double, 8>;  // of a corner: position, texture coordinate, colour

// Triangles by what they have, in an order that does not depend on the file's.
std::vector<std::pair<std::string, std::array<Numbers, 3>>> placed_triangles(
    const PolygonMesh& mesh) {
  std::vector<std::pair<std::string, std::array<Numbers, 3>>> triangles;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    auto& [group, corners] = triangles.emplace_back();
    group = mesh.groups.at(static_cast<std::size_t>(mesh.face_groups[f])).name;
    for (std::int32_t k = 0; k < 3; ++k) {
      const std::int32_t c = mesh.face_offsets[f] + k, v = mesh.face_vertices[c];
      const glm::dvec3& p = mesh.positions[v];
      const glm::dvec2& uv = mesh.uvs.at(static_cast<std::size_t>(mesh.face_uvs[c]));
      const glm::vec4& color = mesh.colors.at(static_cast<std::size_t>(v));
      corners[k] = {p.x, p.y, p.z, uv.x, uv.y, color.x, color.y, color.z};
    }
    std::ranges::rotate(corners, std::ranges::min_element(corners));
  }
  std::ranges::sort(triangles);
  return triangles;
}

TEST_F(SeveralBuffers, HaveTheTrianglesOfOne) {
  const SurfaceMesh surface = laden_grid(41, 30);
  GltfOptions options;
  options.name = "grid";
  const GltfFile one = write_gltf(folder_ / "one.gltf", surface, options);
  EXPECT_EQ(one.buffer_count, 1u);
  options.buffer_bytes = 20000;
  const GltfFile several = write_gltf(folder_ / "two words.gltf", surface, options);
  EXPECT_GT(several.buffer_count, 4u);
  EXPECT_EQ(several.triangle_count, one.triangle_count);
  EXPECT_GT(several.vertex_count, one.vertex_count);
  std::uint64_t bytes = fs::file_size(folder_ / "two words.gltf");
  for (std::size_t i = 0; i < several.buffer_count; ++i) {
    const fs::path buffer = gltf_buffer_path(folder_ / "two words.gltf", i);
    ASSERT_TRUE(fs::exists(buffer)) << buffer;
    EXPECT_LE(fs::file_size(buffer), 20000u);
    // All but the last are rather full.
    if (i + 1 < several.buffer_count) {
      EXPECT_GT(fs::file_size(buffer), 10000u);
    }
    bytes += fs::file_size(buffer);
  }
  EXPECT_EQ(several.byte_count, bytes);
  EXPECT_EQ(contents().size(), 2 + 1 + several.buffer_count);
  const MeshFile plain = read_mesh(folder_ / "one.gltf"),
                 parts = read_mesh(folder_ / "two words.gltf");
  EXPECT_EQ(plain.mesh.positions.size(), surface.positions.size());
  EXPECT_EQ(parts.mesh.positions.size(), surface.positions.size());
  EXPECT_EQ(placed_triangles(parts.mesh), placed_triangles(plain.mesh));
}

TEST_F(SeveralBuffers, ADocumentHasAMeshForEach) {
  GltfOptions options;
  options.name = "grid";
  options.origin = {4, 5, 6};
  options.buffer_bytes = 20000;
  const SurfaceMesh surface = laden_grid(41, 30);
  const std::vector<float> height(surface.positions.size(), 0.5f);
  options.fields = {{"error", height}};
  const GltfFile written = write_gltf(folder_ / "a.gltf", surface, options);
  const tinygltf::Model model = document("a.gltf");
  ASSERT_EQ(model.buffers.size(), written.buffer_count);
  ASSERT_EQ(model.meshes.size(), written.buffer_count);
  ASSERT_EQ(model.nodes.size(), written.buffer_count);
  EXPECT_EQ(model.scenes.at(0).nodes.size(), written.buffer_count);
  EXPECT_EQ(model.materials.size(), 2u);
  std::uint64_t vertices = 0;
  for (std::size_t m = 0; m < model.meshes.size(); ++m) {
    EXPECT_EQ(model.nodes[m].mesh, static_cast<int>(m));
    EXPECT_EQ(model.nodes[m].translation, (std::vector<double>{4, 5, 6}));
    EXPECT_EQ(model.meshes[m].name, "grid " + std::to_string(m + 1));
    for (const tinygltf::Primitive& primitive : model.meshes[m].primitives) {
      EXPECT_EQ(model.materials.at(primitive.material).name,
                primitive.extras.Get("group").Get<std::string>() == "left" ? "red" : "blue");
      EXPECT_TRUE(primitive.attributes.contains("_ERROR"));
      for (const auto& [name, accessor] : primitive.attributes) {
        const auto& view = model.bufferViews.at(model.accessors.at(accessor).bufferView);
        EXPECT_EQ(view.buffer, static_cast<int>(m));
        EXPECT_LE(view.byteOffset + view.byteLength, model.buffers[m].data.size());
      }
      vertices += model.accessors.at(primitive.attributes.at("POSITION")).count;
    }
  }
  EXPECT_EQ(vertices, written.vertex_count);
}

TEST_F(SeveralBuffers, BytesDoNotDependOnThreads) {
  const SurfaceMesh surface = laden_grid(300, 200);
  GltfOptions options;
  options.buffer_bytes = 1000000;
  (void)write_gltf(folder_ / "a.gltf", surface, options);
  const auto all_threads = contents();
  oneapi::tbb::task_arena(1).execute([&] { write_gltf(folder_ / "a.gltf", surface, options); });
  EXPECT_EQ(contents(), all_threads);
}

// Also of one buffer, and files of others.
TEST_F(SeveralBuffers, FailureLeavesTheOldFiles) {
  struct Row {
    std::uint64_t buffer_bytes;
    int asked;  // so often, every few milliseconds: the second time some buffers stand there
  };
  const SurfaceMesh surface = laden_grid(41, 30);
  for (const auto& [buffer_bytes, most] : {Row{20000, 1}, Row{1 << 30, 0}}) {
    GltfOptions options;
    options.buffer_bytes = buffer_bytes;
    (void)write_gltf(folder_ / "a.gltf", surface, options);
    std::ofstream(folder_ / "b.gltf") << "old";
    std::ofstream(folder_ / "b.bin") << "old buffer";
    const auto before = contents();
    options.name = "another";
    for (const char* name : {"a.gltf", "b.gltf"}) {
      int asked = 0;
      options.callbacks.cancelled = [&, limit = most] { return ++asked > limit; };
      EXPECT_NE(
          test::message_of(ErrorCode::Cancelled,
                           [&] { write_gltf(folder_ / name, laden_grid(600, 400), options); }),
          "no error");
      EXPECT_EQ(contents(), before);
    }
    // In the third buffer, by the vertex's number in the surface.
    SurfaceMesh bad = surface;
    bad.positions[700].x = 1e300;
    options.callbacks = {};
    try {
      (void)write_gltf(folder_ / "a.gltf", bad, options);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& refusal) {
      EXPECT_EQ(refusal.element(), 700);
    }
    EXPECT_EQ(contents(), before);
  }
}

TEST_F(SeveralBuffers, ProgressRisesToOne) {
  for (const std::uint64_t buffer_bytes : {20000, 1 << 30}) {
    GltfOptions options;
    options.buffer_bytes = buffer_bytes;
    std::vector<double> fractions;
    options.callbacks.progress = [&](std::string_view step, double fraction) {
      EXPECT_EQ(step, "write");
      fractions.push_back(fraction);
    };
    (void)write_gltf(folder_ / "a.gltf", laden_grid(41, 30), options);
    // The two loops' starts and the end, however fast the machine; what is told between them
    // depends on time (LoopProgress.*).
    ASSERT_GE(fractions.size(), 3u);
    EXPECT_EQ(fractions.front(), 0.0);
    EXPECT_TRUE(std::ranges::is_sorted(fractions));
    EXPECT_NEAR(fractions.back(), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace planish
