#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "files/gltf/parsed_gltf.h"
#include "files/gltf/surfaces.h"
#include "planish/core/error.h"
#include "planish/core/version.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "support/calls.h"

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

TEST(WriteGltf, OriginGoesToTheNodeAndZUpIsTurnedUpright) {
  const glm::dvec3 origin(5e6, -3e6, 1e6);
  const SurfaceMesh surface = wavy_grid(30, 20, origin + glm::dvec3(1, 2, 3));
  for (const bool z_up : {false, true}) {
    const auto upright = [&](const auto& v) {
      return z_up ? std::decay_t<decltype(v)>(v.x, v.z, -v.y) : v;
    };
    GltfOptions options;
    options.z_up = z_up;
    options.origin = origin;
    const auto model = parsed(encode_glb(surface, options));
    EXPECT_EQ(model.nodes.at(0).translation,
              z_up ? (std::vector<double>{5e6, 1e6, 3e6}) : (std::vector<double>{5e6, -3e6, 1e6}));
    const auto positions = vectors_of(model, attribute(model, "POSITION"));
    const auto normals = vectors_of(model, attribute(model, "NORMAL"));
    const auto written = written_positions(surface, options, 123);
    ASSERT_EQ(written.size(), 123u);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const glm::vec3 rounded(surface.positions[i] - origin);
      EXPECT_EQ(positions[i], upright(rounded));
      EXPECT_EQ(normals[i], upright(surface.normals[i]));
      if (i < written.size()) {
        EXPECT_EQ(written[i], origin + glm::dvec3(rounded)) << i;
      }
    }
  }
  EXPECT_TRUE(parsed(encode_glb(surface, {})).nodes.at(0).translation.empty());
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

// Texture coordinates, colours and groups in the files that the writer makes.

using ::testing::ElementsAre;
using ::testing::HasSubstr;

tinygltf::Model parsed(const SurfaceMesh& surface, const GltfOptions& options = {}) {
  return test::parsed(encode_glb(surface, options));
}

template <class Value>
std::vector<Value> attribute_of(const tinygltf::Model& model, const std::string& name,
                                std::size_t primitive = 0) {
  return test::values_of<Value>(model, attribute(model, name, primitive));
}

bool is_corner(const SurfaceMesh& surface, std::int64_t face, const glm::vec3& place) {
  return std::ranges::any_of(
      surface.face(face), [&](std::int32_t v) { return glm::vec3(surface.positions[v]) == place; });
}

SurfaceMesh charts_without_groups() {
  SurfaceMesh surface = test::two_charts();
  surface.groups.clear();
  surface.face_groups.clear();
  return surface;
}

TEST(GltfAttributes, FieldsBecomeScalarsOfTheirNames) {
  const SurfaceMesh surface = charts_without_groups();
  std::vector<float> values(surface.positions.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.5f * static_cast<float>(i) - 2;
  GltfOptions options;
  options.fields = {{"error", values}, {"mean_curvature", values}};
  const tinygltf::Model model = parsed(surface, options);
  const auto positions = attribute_of<glm::vec3>(model, "POSITION");
  for (const char* name : {"_ERROR", "_MEAN_CURVATURE"}) {
    const auto found = attribute_of<float>(model, name);
    ASSERT_EQ(found.size(), positions.size());
    // The surface's in their order; copies along seams have the value of their place.
    for (std::size_t i = 0; i < found.size(); ++i) {
      const auto original = std::ranges::find(positions, positions[i]);
      EXPECT_EQ(found[i], values.at(static_cast<std::size_t>(original - positions.begin())));
    }
    EXPECT_EQ(model.accessors.at(test::attribute(model, name)).type, TINYGLTF_TYPE_SCALAR);
  }
}

TEST(GltfAttributes, ThoseOfTargetsMoveTheMesh) {
  const SurfaceMesh surface = charts_without_groups();
  std::vector<float> moves(3 * surface.positions.size());
  for (std::size_t i = 0; i < moves.size(); ++i) moves[i] = 0.25f * static_cast<float>(i);
  GltfOptions options;
  options.attributes = {{.name = "target/0/POSITION", .width = 3, .values = moves}};
  const tinygltf::Model model = parsed(surface, options);
  const tinygltf::Primitive& primitive = model.meshes.at(0).primitives.at(0);
  EXPECT_FALSE(primitive.attributes.contains("target/0/POSITION"));
  ASSERT_EQ(primitive.targets.size(), 1u);
  const int accessor = primitive.targets[0].at("POSITION");
  EXPECT_THAT(model.accessors.at(accessor).minValues, ElementsAre(0, 0.25, 0.5));
  EXPECT_EQ(test::values_of<glm::vec3>(model, accessor).at(1), glm::vec3(0.75f, 1.0f, 1.25f));
}

TEST(GltfAttributes, GiveVerticesOnSeamsOneCopyForEachChart) {
  const SurfaceMesh surface = charts_without_groups();
  const tinygltf::Model model = parsed(surface);
  const auto positions = attribute_of<glm::vec3>(model, "POSITION");
  const auto normals = attribute_of<glm::vec3>(model, "NORMAL");
  const auto uvs = attribute_of<glm::vec2>(model, "TEXCOORD_0");
  ASSERT_EQ(positions.size(), surface.positions.size() + 3);
  ASSERT_EQ(uvs.size(), positions.size());
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    EXPECT_EQ(positions[i], glm::vec3(surface.positions[i]));
    EXPECT_EQ(normals[i], surface.normals[i]);
  }
  // Each triangle lies in one chart, at its corners' places.
  const auto indices = indices_of(model);
  EXPECT_EQ(indices.size(), 48u);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const glm::vec3 place = positions[indices[i]];
    const float u = place.x + (i / 6 % 4 < 2 ? 0.0f : 10.0f);
    EXPECT_EQ(uvs[indices[i]], glm::vec2(u, 1.0f - place.y));
  }
}

// Three rows of five vertices, cut in the middle: three of a row on either side.
TEST(GltfAttributes, EachPrimitiveHasVerticesOfItsOwn) {
  SurfaceMesh surface = test::two_charts();
  std::vector<float> values(surface.positions.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>(i);
    surface.colors.emplace_back(0.05f * static_cast<float>(i), 0.5f, 0.25f, 1.0f);
  }
  GltfOptions options;
  options.fields = {{"error", values}};
  const tinygltf::Model model = parsed(surface, options);
  for (std::size_t part = 0; part < 2; ++part) {
    SCOPED_TRACE(part);
    const auto& primitive = model.meshes[0].primitives[part];
    const auto positions = attribute_of<glm::vec3>(model, "POSITION", part);
    const auto uvs = attribute_of<glm::vec2>(model, "TEXCOORD_0", part);
    const auto colors = attribute_of<glm::vec4>(model, "COLOR_0", part);
    const auto fields = attribute_of<float>(model, "_ERROR", part);
    ASSERT_EQ(positions.size(), 9u);
    for (std::size_t i = 0; i < 9; ++i) {
      // In the surface's order.
      const std::size_t row = 5 * (i / 3) + i % 3 + 2 * part;
      EXPECT_EQ(positions[i], glm::vec3(surface.positions[row]));
      EXPECT_EQ(uvs[i],
                glm::vec2(positions[i].x + 10.0f * static_cast<float>(part), 1 - positions[i].y));
      EXPECT_EQ(colors[i], surface.colors[row]);
      EXPECT_EQ(fields[i], values[row]);
    }
    const auto& accessor = model.accessors.at(primitive.attributes.at("POSITION"));
    const double left = 0.5 * static_cast<double>(part);
    EXPECT_THAT(accessor.minValues, ElementsAre(left, 0, 0));
    EXPECT_THAT(accessor.maxValues, ElementsAre(left + 0.5, 1, 0));
    const auto indices = indices_of(model, part);
    ASSERT_EQ(indices.size(), 24u);
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto face = static_cast<std::int64_t>(4 * (i / 12) + 2 * part + i / 6 % 2);
      EXPECT_TRUE(is_corner(surface, face, positions[indices[i]])) << i;
    }
  }
}

TEST(GltfAttributes, PrimitivesWithoutTextureCoordinatesSaySo) {
  SurfaceMesh surface = test::two_charts();
  for (std::size_t uv = 15; uv < 30; ++uv) surface.uvs[uv] = glm::dvec2(0.0);
  const tinygltf::Model model = parsed(surface);
  const auto& primitives = model.meshes.at(0).primitives;
  EXPECT_EQ(attribute_of<glm::vec2>(model, "TEXCOORD_0").size(), 9u);
  EXPECT_EQ(primitives.at(1).attributes.count("TEXCOORD_0"), 0u);
  EXPECT_EQ(attribute_of<glm::vec3>(model, "POSITION", 1).size(), 9u);
}

TEST(GltfAttributes, GroupsBecomePrimitivesWithMaterials) {
  SurfaceMesh surface = test::two_charts();
  surface.groups = {{"unused", ""}, {"side", "blue"}, {"rest", ""}};
  surface.face_groups = {2, 1, 2, 1, 2, 1, 1, 1};
  const tinygltf::Model model = parsed(surface);
  const auto& primitives = model.meshes.at(0).primitives;
  ASSERT_EQ(primitives.size(), 2u);
  ASSERT_EQ(model.materials.size(), 2u);
  EXPECT_EQ(model.materials[primitives[0].material].name, "blue");
  EXPECT_EQ(model.materials[primitives[1].material].name, "rest");
  EXPECT_EQ(primitives[0].extras.Get("group").Get<std::string>(), "side");
  EXPECT_NE(primitives[0].attributes, primitives[1].attributes);
  EXPECT_EQ(indices_of(model).size(), 30u);
  // Faces keep their order within a group: 0, 2 and 4 are the second primitive's.
  const auto indices = indices_of(model, 1);
  const auto positions = attribute_of<glm::vec3>(model, "POSITION", 1);
  ASSERT_EQ(indices.size(), 18u);
  for (std::size_t i = 0; i < 18; ++i) {
    const auto face = static_cast<std::int64_t>(2 * (i / 6));
    EXPECT_TRUE(is_corner(surface, face, positions[indices[i]])) << i;
  }
}

TEST(GltfAttributes, ColoursFollowTheirVertices) {
  SurfaceMesh surface = charts_without_groups();
  for (std::size_t i = 0; i < surface.positions.size(); ++i)
    surface.colors.emplace_back(0.05f * i, 1.5f, -1.0f, 0.5f);
  const tinygltf::Model model = parsed(surface);
  const auto colors = attribute_of<glm::vec4>(model, "COLOR_0");
  const auto positions = attribute_of<glm::vec3>(model, "POSITION");
  ASSERT_EQ(colors.size(), positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t own = 0; own < surface.positions.size(); ++own) {
      if (glm::vec3(surface.positions[own]) != positions[i]) continue;
      EXPECT_EQ(colors[i], glm::vec4(0.05f * own, 1, 0, 0.5f));
    }
  }
}

TEST(GltfAttributes, PolygonsKeepTheirCornersTextureCoordinates) {
  SurfaceMesh surface = test::flat_polygons({{{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}}});
  for (int i = 5; i >= 0; --i) {
    surface.uvs.emplace_back(surface.positions[i].x / 8, surface.positions[i].y / 8);
    surface.face_uvs.push_back(i);
  }
  const tinygltf::Model model = parsed(surface);
  const auto positions = attribute_of<glm::vec3>(model, "POSITION");
  const auto uvs = attribute_of<glm::vec2>(model, "TEXCOORD_0");
  ASSERT_EQ(positions.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(uvs[i], glm::vec2(positions[i].x / 8, 1 - positions[i].y / 8));
}

// Written down from the bytes that earlier versions wrote.
TEST(GltfAttributes, SurfacesWithoutAnyHaveAPlainDocument) {
  const std::vector<std::byte> glb =
      encode_glb(test::flat_polygons({{{0, 0}, {1, 0}, {0, 1}}}), {});
  const std::string json =
      R"({"accessors":[{"bufferView":0,"componentType":5126,"count":3,"max":[1.0,1.0,0.0],)"
      R"("min":[0.0,0.0,0.0],"type":"VEC3"},{"bufferView":1,"componentType":5126,"count":3,)"
      R"("type":"VEC3"},{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}],)"
      R"("asset":{"generator":"planish )" PLANISH_VERSION
      R"(","version":"2.0"},"bufferViews":[{"buffer":0,"byteLength":36,)"
      R"("target":34962},{"buffer":0,"byteLength":36,"byteOffset":36,"target":34962},)"
      R"({"buffer":0,"byteLength":6,"byteOffset":72,"target":34963}],)"
      R"("buffers":[{"byteLength":80}],"materials":[{"pbrMetallicRoughness":)"
      R"({"metallicFactor":0.0,"roughnessFactor":0.5}}],"meshes":[{"name":"surface",)"
      R"("primitives":[{"attributes":{"NORMAL":1,"POSITION":0},"indices":2,"material":0,)"
      R"("mode":4}]}],"nodes":[{"mesh":0,"name":"surface"}],"scene":0,"scenes":[{"nodes":[0]}]})";
  const std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
  // The header, the JSON in whole words, its size, two vectors a vertex and 6 bytes of indices
  // padded to 8.
  std::uint32_t words[5];
  std::memcpy(words, text.data(), sizeof words);
  EXPECT_EQ(text.substr(0, 4), "glTF");
  EXPECT_EQ(words[1], 2u);
  EXPECT_EQ(words[2], text.size());
  EXPECT_EQ(words[3], (json.size() + 3) / 4 * 4);
  EXPECT_EQ(text.size(), 12u + 8 + words[3] + 8 + 2 * 36 + 8);
  EXPECT_EQ(text.substr(20, json.size()), json);
  EXPECT_EQ(text.substr(text.size() - 8), std::string("\0\0\1\0\2\0\0\0", 8));
}

TEST(GltfAttributes, WrongOnesAreRefused) {
  struct Row {
    const char* message;
    void (*spoil)(SurfaceMesh&);
  };
  GltfOptions options;
  const auto refusal_of = [&](const SurfaceMesh& surface) {
    return test::message_of(ErrorCode::InvalidArgument,
                            [&] { (void)encode_glb(surface, options); });
  };
  for (const auto& [message, spoil] :
       {Row{"corner 5 has number 99 of", [](auto& s) { s.face_uvs[5] = 99; }},
        Row{"31 corners of the texture where 32 are needed",
            [](auto& s) { s.face_uvs.pop_back(); }},
        Row{"texture coordinate 1 is not finite", [](auto& s) { s.uvs[1].y = 1e300; }},
        Row{"the group of face 3 has number 2 of 2", [](auto& s) { s.face_groups[3] = 2; }}}) {
    SurfaceMesh surface = test::two_charts();
    spoil(surface);
    EXPECT_THAT(refusal_of(surface), HasSubstr(message));
  }
  const std::vector<float> few(3);
  options.fields = {{"error", few}};
  EXPECT_THAT(refusal_of(test::two_charts()), HasSubstr("3 values of error for 15 positions"));
}

}  // namespace
}  // namespace planish
