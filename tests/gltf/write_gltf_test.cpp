#include "planish/gltf/write_gltf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>
#include <tiny_gltf.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>

#include "gltf/surfaces.h"
#include "planish/core/version.h"
#include "planish/gltf/gltf_document.h"

namespace planish {
namespace {

using test::flat_polygons;
using test::wavy_grid;
using ::testing::HasSubstr;

tinygltf::Model parsed(const std::vector<std::byte>& glb) {
  tinygltf::Model model;
  std::string error, warning;
  const bool read = tinygltf::TinyGLTF().LoadBinaryFromMemory(
      &model, &error, &warning, reinterpret_cast<const unsigned char*>(glb.data()),
      static_cast<unsigned>(glb.size()));
  EXPECT_TRUE(read) << error;
  EXPECT_EQ(error + warning, "");
  return model;
}

std::vector<glm::vec3> vectors_of(const tinygltf::Model& model, int accessor_index) {
  const auto& accessor = model.accessors.at(accessor_index);
  const auto& view = model.bufferViews.at(accessor.bufferView);
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT);
  EXPECT_EQ(accessor.type, TINYGLTF_TYPE_VEC3);
  EXPECT_EQ(accessor.byteOffset, 0u);
  EXPECT_EQ(view.target, TINYGLTF_TARGET_ARRAY_BUFFER);
  EXPECT_EQ(view.byteLength, accessor.count * sizeof(glm::vec3));
  std::vector<glm::vec3> values(accessor.count);
  std::memcpy(values.data(), model.buffers.at(0).data.data() + view.byteOffset, view.byteLength);
  return values;
}

template <class Index>
std::vector<std::uint32_t> indices_as(const tinygltf::Model& model) {
  const auto& accessor = model.accessors.at(model.meshes.at(0).primitives.at(0).indices);
  const auto& view = model.bufferViews.at(accessor.bufferView);
  EXPECT_EQ(accessor.type, TINYGLTF_TYPE_SCALAR);
  EXPECT_EQ(view.target, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  EXPECT_EQ(view.byteLength, accessor.count * sizeof(Index));
  std::vector<Index> values(accessor.count);
  std::memcpy(values.data(), model.buffers.at(0).data.data() + view.byteOffset, view.byteLength);
  return {values.begin(), values.end()};
}

std::vector<std::uint32_t> indices_of(const tinygltf::Model& model) {
  const auto& accessor = model.accessors.at(model.meshes.at(0).primitives.at(0).indices);
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) {
    return indices_as<std::uint16_t>(model);
  }
  EXPECT_EQ(accessor.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
  return indices_as<std::uint32_t>(model);
}

int attribute(const tinygltf::Model& model, const std::string& name) {
  return model.meshes.at(0).primitives.at(0).attributes.at(name);
}

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

class WriteGltf : public testing::Test {
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

TEST_F(WriteGltf, ValuesAreTheSurfacesRoundedToFloat) {
  const SurfaceMesh surface = wavy_grid(40, 30, {0.1, 0.2, 0.3});
  const auto model = parsed(encode_glb(surface, {}));
  const auto positions = vectors_of(model, attribute(model, "POSITION"));
  ASSERT_EQ(positions.size(), surface.positions.size());
  glm::vec3 minimum(1e30f), maximum(-1e30f);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(positions[i][k], static_cast<float>(surface.positions[i][k])) << i;
      minimum[k] = std::min(minimum[k], positions[i][k]);
      maximum[k] = std::max(maximum[k], positions[i][k]);
    }
  }
  EXPECT_EQ(vectors_of(model, attribute(model, "NORMAL")), surface.normals);
  const auto& accessor = model.accessors[attribute(model, "POSITION")];
  EXPECT_EQ(accessor.minValues, (std::vector<double>{minimum.x, minimum.y, minimum.z}));
  EXPECT_EQ(accessor.maxValues, (std::vector<double>{maximum.x, maximum.y, maximum.z}));
}

TEST_F(WriteGltf, EveryQuadBecomesTwoTrianglesInItsWinding) {
  const SurfaceMesh surface = wavy_grid(9, 7);
  const auto model = parsed(encode_glb(surface, {}));
  EXPECT_EQ(model.meshes[0].primitives[0].mode, TINYGLTF_MODE_TRIANGLES);
  const auto indices = indices_of(model);
  ASSERT_EQ(indices.size(), 6 * surface.face_vertices.size() / 4);
  for (std::size_t q = 0; q < surface.face_vertices.size() / 4; ++q) {
    const std::int32_t* f = surface.face_vertices.data() + 4 * q;
    const auto& at = surface.positions;
    const bool first = glm::distance(at[f[0]], at[f[2]]) <= glm::distance(at[f[1]], at[f[3]]);
    const auto corner = [&](int i) { return static_cast<std::uint32_t>(f[i]); };
    const std::vector<std::uint32_t> expected =
        first ? std::vector{corner(0), corner(1), corner(2), corner(0), corner(2), corner(3)}
              : std::vector{corner(0), corner(1), corner(3), corner(1), corner(2), corner(3)};
    EXPECT_EQ(std::vector(indices.begin() + 6 * q, indices.begin() + 6 * q + 6), expected) << q;
  }
}

TEST_F(WriteGltf, LevelZeroPolygonsAreTriangulated) {
  const SurfaceMesh surface = flat_polygons({{{0, 0}, {1, 0}, {0, 1}},
                                             {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}},
                                             {{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
  const auto indices = indices_of(parsed(encode_glb(surface, {})));
  ASSERT_EQ(indices.size(), 3u * (1 + 4 + 2));
  double doubled_area = 0;
  for (std::size_t t = 0; t < indices.size(); t += 3) {
    const glm::dvec3 a = surface.positions[indices[t]], b = surface.positions[indices[t + 1]],
                     c = surface.positions[indices[t + 2]];
    const double part = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    EXPECT_GT(part, 0);
    doubled_area += part;
  }
  EXPECT_DOUBLE_EQ(doubled_area, 2 * (0.5 + 7 + 1));
}

TEST_F(WriteGltf, ManyPolygonsKeepTheirOrder) {
  // More faces than are converted at once.
  std::vector<std::vector<glm::dvec2>> polygons;
  for (int i = 0; i < 140000; ++i) {
    polygons.push_back({{0, 0}, {1, 0}, {0, 1}});
    if (i % 1000 == 0) polygons.back() = {{0, 0}, {1, 0}, {2, 1}, {1, 2}, {0, 1}};
  }
  const SurfaceMesh surface = flat_polygons(polygons);
  const auto indices = indices_of(parsed(encode_glb(surface, {})));
  std::size_t next = 0;
  for (std::size_t f = 0; f < polygons.size(); ++f) {
    for (std::size_t k = 0; k < 3 * (polygons[f].size() - 2); ++k, ++next) {
      ASSERT_LT(next, indices.size());
      ASSERT_GE(indices[next], static_cast<std::uint32_t>(surface.face_offsets[f]));
      ASSERT_LT(indices[next], static_cast<std::uint32_t>(surface.face_offsets[f + 1]));
    }
  }
  EXPECT_EQ(next, indices.size());
}

TEST_F(WriteGltf, IndicesAreShortUpTo65534Vertices) {
  for (const std::int32_t vertex_count : {65534, 65535}) {
    SurfaceMesh surface = wavy_grid(2, vertex_count / 2);
    while (static_cast<std::int32_t>(surface.positions.size()) < vertex_count) {
      surface.positions.push_back(surface.positions.back());
      surface.normals.push_back(surface.normals.back());
    }
    const auto last = static_cast<std::int32_t>(surface.positions.size()) - 1;
    surface.face_vertices.insert(surface.face_vertices.end(), {0, 1, 2, last});
    const auto model = parsed(encode_glb(surface, {}));
    const auto& primitive = model.meshes[0].primitives[0];
    EXPECT_EQ(model.accessors[primitive.indices].componentType,
              vertex_count == 65534 ? TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                    : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT);
    EXPECT_THAT(indices_of(model), testing::Contains(static_cast<std::uint32_t>(last)));
  }
}

TEST_F(WriteGltf, OriginGoesToTheNodeAndKeepsTheDigits) {
  const glm::dvec3 centre(5e6, -3e6, 1e6);
  const SurfaceMesh surface = wavy_grid(20, 20, centre);
  GltfOptions options;
  options.origin = centre;
  const auto model = parsed(encode_glb(surface, options));
  EXPECT_EQ(model.nodes.at(0).translation, (std::vector<double>{5e6, -3e6, 1e6}));
  const auto positions = vectors_of(model, attribute(model, "POSITION"));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3 read = glm::dvec3(positions[i]) + centre;
    EXPECT_LT(glm::distance(read, surface.positions[i]), 2e-7) << i;
  }
  EXPECT_TRUE(parsed(encode_glb(surface, {})).nodes.at(0).translation.empty());
}

TEST_F(WriteGltf, ZUpIsTurnedUpright) {
  const SurfaceMesh surface = wavy_grid(5, 4, {1, 2, 3});
  GltfOptions options;
  options.z_up = true;
  options.origin = {10, 20, 30};
  const auto model = parsed(encode_glb(surface, options));
  EXPECT_EQ(model.nodes.at(0).translation, (std::vector<double>{10, 30, -20}));
  const auto positions = vectors_of(model, attribute(model, "POSITION"));
  const auto normals = vectors_of(model, attribute(model, "NORMAL"));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3 p = surface.positions[i] - options.origin;
    EXPECT_EQ(positions[i], glm::vec3(glm::dvec3(p.x, p.z, -p.y)));
    const glm::vec3 n = surface.normals[i];
    EXPECT_EQ(normals[i], glm::vec3(n.x, n.z, -n.y));
  }
}

TEST_F(WriteGltf, WrittenPositionsAreThoseInTheFile) {
  const SurfaceMesh surface = wavy_grid(30, 20, {1234.5, 1e-3, -77});
  for (const bool z_up : {false, true}) {
    GltfOptions options;
    options.z_up = z_up;
    options.origin = {1000.1, 0.3, -70.7};
    const auto model = parsed(encode_glb(surface, options));
    const auto stored = vectors_of(model, attribute(model, "POSITION"));
    const auto& t = model.nodes.at(0).translation;
    const auto written = written_positions(surface, options, 123);
    ASSERT_EQ(written.size(), 123u);
    for (std::size_t i = 0; i < written.size(); ++i) {
      const glm::dvec3 p = glm::dvec3(t[0], t[1], t[2]) + glm::dvec3(stored[i]);
      EXPECT_EQ(written[i], z_up ? glm::dvec3(p.x, -p.z, p.y) : p) << i;
    }
  }
  EXPECT_EQ(written_positions(surface, {}, 100000).size(), surface.positions.size());
}

TEST_F(WriteGltf, SaysWhatWasDone) {
  GltfOptions options;
  options.name = "goblet \"\xC3\xA4\"";
  options.double_sided = true;
  options.extras = {{"solver", std::string("chebyshev")},
                    {"converged", true},
                    {"iterations", std::int64_t{7}},
                    {"error", 1.5e-7},
                    {"unknown", std::numeric_limits<double>::quiet_NaN()}};
  const auto model = parsed(encode_glb(wavy_grid(3, 3), options));
  EXPECT_EQ(model.asset.version, "2.0");
  EXPECT_EQ(model.asset.generator, "planish " PLANISH_VERSION);
  EXPECT_EQ(model.asset.extras.Get("solver").Get<std::string>(), "chebyshev");
  EXPECT_TRUE(model.asset.extras.Get("converged").Get<bool>());
  EXPECT_EQ(model.asset.extras.Get("iterations").Get<int>(), 7);
  EXPECT_EQ(model.asset.extras.Get("error").Get<double>(), 1.5e-7);
  EXPECT_EQ(model.nodes.at(0).name, options.name);
  EXPECT_EQ(model.meshes.at(0).name, options.name);
  ASSERT_EQ(model.materials.size(), 1u);
  EXPECT_TRUE(model.materials[0].doubleSided);
  EXPECT_EQ(model.materials[0].pbrMetallicRoughness.metallicFactor, 0.0);
  EXPECT_EQ(model.materials[0].pbrMetallicRoughness.roughnessFactor, 0.5);
  EXPECT_EQ(model.meshes[0].primitives[0].material, 0);
  EXPECT_EQ(model.defaultScene, 0);
}

TEST_F(WriteGltf, NameThatIsNotUtf8IsReplaced) {
  GltfOptions options;
  options.name = "a\xFF";
  EXPECT_EQ(parsed(encode_glb(wavy_grid(2, 2), options)).meshes.at(0).name, "a\xEF\xBF\xBD");
}

TEST_F(WriteGltf, BytesDoNotDependOnThreadsOrRun) {
  const SurfaceMesh surface = wavy_grid(500, 400);
  const auto glb = encode_glb(surface, {});
  oneapi::tbb::task_arena one_thread(1);
  one_thread.execute([&] { EXPECT_EQ(encode_glb(surface, {}), glb); });
  write_gltf(folder_ / "a.glb", surface, {});
  EXPECT_EQ(text_of(folder_ / "a.glb"),
            std::string(reinterpret_cast<const char*>(glb.data()), glb.size()));
}

TEST_F(WriteGltf, GltfHasABufferBesideIt) {
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

TEST_F(WriteGltf, GlbIsPaddedAndSized) {
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

TEST_F(WriteGltf, FourGibibytesAreRefusedNamingTheWayOut) {
  // 12 + 8 + 8 bytes of headers: the largest multiple of 4 that fits is 2^32 - 4.
  const std::uint64_t largest = (std::uint64_t{1} << 32) - 4;
  EXPECT_EQ(glb_byte_count(1001, largest - 28 - 1004, "a.glb"), largest);
  const Error error =
      error_of([&] { (void)glb_byte_count(1001, largest - 28 - 1004 + 1, "a.glb"); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_THAT(error.what(), HasSubstr("a.glb: 4294967296 bytes"));
  EXPECT_THAT(error.what(), HasSubstr("write .gltf"));
}

TEST_F(WriteGltf, LayoutCountsIn64Bits) {
  const GltfLayout layout = gltf_layout(1000000000, 2000000000);
  EXPECT_EQ(layout.attribute_bytes, 12000000000u);
  EXPECT_EQ(layout.index_bytes(0), 24000000000u);
  EXPECT_EQ(layout.buffer_bytes, 48000000000u);
}

TEST_F(WriteGltf, UnusableSurfacesAreRefusedNamingTheElement) {
  const SurfaceMesh good = wavy_grid(4, 4);
  const auto refused = [&](auto change) {
    SurfaceMesh bad = good;
    change(bad);
    const Error error = error_of([&] { write_gltf(folder_ / "bad.glb", bad, {}); });
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

TEST_F(WriteGltf, FailureLeavesTheOldFiles) {
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

TEST_F(WriteGltf, UnwritableFoldersAndExtensionsAreNamed) {
  const Error missing =
      error_of([&] { write_gltf(folder_ / "none" / "a.glb", wavy_grid(2, 2), {}); });
  EXPECT_EQ(missing.code(), ErrorCode::UnwritableOutput);
  EXPECT_THAT(missing.what(), HasSubstr("none/a.glb"));
  const Error other = error_of([&] { write_gltf(folder_ / "a.obj", wavy_grid(2, 2), {}); });
  EXPECT_EQ(other.code(), ErrorCode::InvalidArgument);
  EXPECT_THAT(other.what(), HasSubstr("a.obj"));
}

TEST_F(WriteGltf, ProgressRisesToOne) {
  GltfOptions options;
  std::vector<double> fractions;
  options.callbacks.progress = [&](std::string_view step, double fraction) {
    EXPECT_EQ(step, "write");
    fractions.push_back(fraction);
  };
  (void)encode_glb(wavy_grid(600, 600), options);
  ASSERT_GT(fractions.size(), 3u);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
}

TEST_F(WriteGltf, UriIsPercentEncoded) {
  EXPECT_EQ(encode_uri("Az09-._~.bin"), "Az09-._~.bin");
  EXPECT_EQ(encode_uri("a b%/\xC3\xA4.bin"), "a%20b%25%2F%C3%A4.bin");
}

}  // namespace
}  // namespace planish
