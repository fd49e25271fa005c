#include "planish/files/gltf/write_gltf.h"
#include "planish/files/gltf/gltf_vertices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "files/gltf/parsed_gltf.h"
#include "files/gltf/surfaces.h"
#include "planish/core/version.h"

namespace planish {
namespace {

using test::attribute;
using test::flat_polygons;
using test::indices_of;
using test::parsed;
using test::vectors_of;
using test::wavy_grid;

TEST(WriteGltf, ValuesAreTheSurfacesRoundedToFloat) {
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

TEST(WriteGltf, EveryQuadBecomesTwoTrianglesInItsWinding) {
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

TEST(WriteGltf, LevelZeroPolygonsAreTriangulated) {
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

TEST(WriteGltf, ManyPolygonsKeepTheirOrder) {
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

TEST(WriteGltf, IndicesAreShortUpTo65534Vertices) {
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

TEST(WriteGltf, OriginGoesToTheNodeAndKeepsTheDigits) {
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

TEST(WriteGltf, ZUpIsTurnedUpright) {
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

TEST(WriteGltf, WrittenPositionsAreThoseInTheFile) {
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

TEST(WriteGltf, SaysWhatWasDone) {
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

TEST(WriteGltf, NameThatIsNotUtf8IsReplaced) {
  GltfOptions options;
  options.name = "a\xFF";
  EXPECT_EQ(parsed(encode_glb(wavy_grid(2, 2), options)).meshes.at(0).name, "a\xEF\xBF\xBD");
}

TEST(FloatBox, HoldsEveryPointAndSeesWhatIsNotFinite) {
  for (std::size_t count = 1; count <= 9; ++count) {
    for (std::size_t at = 0; at < count; ++at) {
      std::vector<glm::vec3> points(count, glm::vec3(1, 2, 3));
      points[at] = {-4, 7, 3.5f};
      const FloatBox box = box_of(points);
      EXPECT_TRUE(box.is_finite);
      EXPECT_EQ(box.maximum, glm::vec3(count > 1 ? 1 : -4, 7, 3.5f));
      EXPECT_EQ(box.minimum, glm::vec3(-4, count > 1 ? 2 : 7, count > 1 ? 3 : 3.5f));
      for (const float wrong :
           {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
        for (int d = 0; d < 3; ++d) {
          std::vector<glm::vec3> bad = points;
          bad[at][d] = wrong;
          EXPECT_FALSE(box_of(bad).is_finite) << at << " of " << count;
        }
      }
    }
  }
}

TEST(FloatBox, TakesNoLengthBeyondTheToleranceForAUnit) {
  for (const float length : {1.0f, 1.0004f, 0.9996f, 1.00051f, 0.99949f, 0.0f, 2.0f,
                             std::numeric_limits<float>::quiet_NaN()}) {
    const std::vector<glm::vec3> vectors{{1, 0, 0}, {0, length, 0}};
    const bool is_near = std::abs(length - 1.0f) < 4.5e-4f;
    EXPECT_EQ(are_surely_units(vectors, 5e-4f), is_near) << length;
  }
}

}  // namespace
}  // namespace planish
