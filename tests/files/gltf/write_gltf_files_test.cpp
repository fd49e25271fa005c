// Bytes and files that the glTF writer makes, and what it refuses to write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "files/gltf/parsed_gltf.h"
#include "files/gltf/surfaces.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/write_gltf.h"

namespace planish {
namespace {

using test::flat_polygons;
using test::indices_of;
using test::parsed;
using test::vectors_of;
using test::wavy_grid;
using ::testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

template <class Call>
Error error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was thrown";
  return Error(ErrorCode::Cancelled, "");
}

class WriteGltfFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::size_t file_count() const {
    return std::distance(std::filesystem::directory_iterator(folder_), {});
  }

  std::filesystem::path folder_;
};

TEST_F(WriteGltfFiles, BytesDoNotDependOnThreadsOrRun) {
  const SurfaceMesh surface = wavy_grid(500, 400);
  const auto glb = encode_glb(surface, {});
  oneapi::tbb::task_arena one_thread(1);
  one_thread.execute([&] { EXPECT_EQ(encode_glb(surface, {}), glb); });
  write_gltf(folder_ / "a.glb", surface, {});
  EXPECT_EQ(text_of(folder_ / "a.glb"),
            std::string(reinterpret_cast<const char*>(glb.data()), glb.size()));
}

TEST_F(WriteGltfFiles, GltfHasABufferBesideIt) {
  const SurfaceMesh surface = wavy_grid(20, 10);
  const auto path = folder_ / "two words.GLTF";
  const GltfFile written = write_gltf(path, surface, {});
  EXPECT_EQ(file_count(), 2u);
  EXPECT_EQ(written.byte_count, std::filesystem::file_size(path) +
                                    std::filesystem::file_size(folder_ / "two words.bin"));
  EXPECT_EQ(written.vertex_count, 200u);
  EXPECT_EQ(written.triangle_count, 2u * 19 * 9);
  tinygltf::Model model;
  std::string error, warning;
  ASSERT_TRUE(tinygltf::TinyGLTF().LoadASCIIFromFile(&model, &error, &warning, path.string()))
      << error;
  const auto embedded = parsed(encode_glb(surface, {}));
  EXPECT_EQ(vectors_of(model, 0), vectors_of(embedded, 0));
  EXPECT_EQ(indices_of(model), indices_of(embedded));
}

TEST_F(WriteGltfFiles, GlbIsPaddedAndSized) {
  // One triangle of 16-bit indices: 6 bytes, padded to 8.
  const auto glb = encode_glb(flat_polygons({{{0, 0}, {1, 0}, {0, 1}}}), {});
  std::uint32_t words[5];
  std::memcpy(words, glb.data(), sizeof words);
  EXPECT_EQ(std::memcmp(glb.data(), "glTF", 4), 0);
  EXPECT_EQ(words[1], 2u);
  EXPECT_EQ(words[2], glb.size());
  EXPECT_EQ(words[3] % 4, 0u);
  EXPECT_EQ(glb.size(), 12u + 8 + words[3] + 8 + 2 * 36 + 8);
}

TEST_F(WriteGltfFiles, FourGibibytesAreRefusedNamingTheWayOut) {
  // 12 + 8 + 8 bytes of headers: the largest multiple of 4 that fits is 2^32 - 4.
  const std::uint64_t largest = (std::uint64_t{1} << 32) - 4;
  EXPECT_EQ(glb_byte_count(1001, largest - 28 - 1004, "a.glb"), largest);
  const Error error =
      error_of([&] { (void)glb_byte_count(1001, largest - 28 - 1004 + 1, "a.glb"); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_THAT(error.what(), HasSubstr("a.glb: 4294967296 bytes"));
  EXPECT_THAT(error.what(), HasSubstr("write .gltf"));
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
  const SurfaceMesh good = wavy_grid(4, 4);
  const auto refused = [&](auto change) {
    SurfaceMesh bad = good;
    change(bad);
    Error error = error_of([&] { write_gltf(folder_ / "bad.glb", bad, {}); });
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(file_count(), 0u);
    return error;
  };
  EXPECT_EQ(refused([](auto& s) { s.positions[5].y = 1e300; }).element(), 5);
  EXPECT_EQ(refused([](auto& s) { s.positions[6].z = std::nan(""); }).element(), 6);
  EXPECT_EQ(refused([](auto& s) { s.normals[7] = glm::vec3(0); }).element(), 7);
  EXPECT_EQ(refused([](auto& s) { s.normals[8].x = std::nanf(""); }).element(), 8);
  EXPECT_EQ(refused([](auto& s) { s.face_vertices[9] = 16; }).element(), 9);
  EXPECT_EQ(refused([](auto& s) { s.face_vertices[10] = -1; }).element(), 10);
  EXPECT_THAT(refused([](auto& s) { s.normals.pop_back(); }).what(), HasSubstr("15 normals"));
  EXPECT_THAT(refused([](auto& s) { s.face_vertices.clear(); }).what(), HasSubstr("no face"));
  EXPECT_THAT(refused([](auto& s) { s.face_vertices.pop_back(); }).what(), HasSubstr("multiple"));
  EXPECT_THAT(refused([](auto& s) { s = SurfaceMesh{}; }).what(), HasSubstr("no face"));
  EXPECT_EQ(refused([](auto& s) {
              s = flat_polygons({{{0, 0}, {1, 0}, {0, 1}}, {{0, 0}, {1, 0}}});
            }).element(),
            1);
  EXPECT_THAT(refused([](auto& s) {
                s = flat_polygons({{{0, 0}, {1, 0}, {0, 1}}});
                s.face_offsets = {0, 2147483647};
              }).what(),
              HasSubstr("offsets"));
}

TEST_F(WriteGltfFiles, FailureLeavesTheOldFiles) {
  std::ofstream(folder_ / "a.gltf") << "old";
  std::ofstream(folder_ / "a.bin") << "old buffer";
  GltfOptions options;
  options.callbacks.cancelled = [] { return true; };
  const Error error = error_of([&] { write_gltf(folder_ / "a.gltf", wavy_grid(9, 9), options); });
  EXPECT_EQ(error.code(), ErrorCode::Cancelled);
  EXPECT_EQ(file_count(), 2u);
  EXPECT_EQ(text_of(folder_ / "a.gltf"), "old");
  EXPECT_EQ(text_of(folder_ / "a.bin"), "old buffer");
}

TEST_F(WriteGltfFiles, UnwritableFoldersAndExtensionsAreNamed) {
  const Error missing =
      error_of([&] { write_gltf(folder_ / "none" / "a.glb", wavy_grid(2, 2), {}); });
  EXPECT_EQ(missing.code(), ErrorCode::UnwritableOutput);
  EXPECT_THAT(missing.what(), HasSubstr("none/a.glb"));
  const Error other = error_of([&] { write_gltf(folder_ / "a.obj", wavy_grid(2, 2), {}); });
  EXPECT_EQ(other.code(), ErrorCode::InvalidArgument);
  EXPECT_THAT(other.what(), HasSubstr("a.obj"));
}

TEST_F(WriteGltfFiles, ProgressRisesToOne) {
  GltfOptions options;
  std::vector<double> fractions;
  options.callbacks.progress = [&](std::string_view step, double fraction) {
    EXPECT_EQ(step, "write");
    fractions.push_back(fraction);
  };
  (void)encode_glb(wavy_grid(600, 600), options);
  // The two loops' starts and the end, however fast the machine; what is told between them depends
  // on time (LoopProgress.*).
  ASSERT_GE(fractions.size(), 3u);
  EXPECT_EQ(fractions.front(), 0.0);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST_F(WriteGltfFiles, UriIsPercentEncoded) {
  EXPECT_EQ(encode_uri("Az09-._~.bin"), "Az09-._~.bin");
  EXPECT_EQ(encode_uri("a b%/\xC3\xA4.bin"), "a%20b%25%2F%C3%A4.bin");
}

}  // namespace
}  // namespace planish
