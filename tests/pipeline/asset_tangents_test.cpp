// TANGENT of written assets, against MikkTSpace's rule in double precision, triangle by triangle,
// for the vertices that a reader finds in the file.
#include <gmock/gmock.h>

#include <oneapi/tbb/task_arena.h>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <map>
#include <numbers>

#include "mesh/test_meshes.h"
#include "pipeline/asset_fixture.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_tangents.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/kept_rows.h"

namespace planish::test {
namespace {

using nlohmann::json;

struct TexturedMesh {
  std::vector<glm::vec3> positions;
  std::vector<std::vector<glm::vec2>> uv_sets;
  std::vector<std::vector<std::uint32_t>> parts;  // triangles, a material each
  std::vector<int> set_of_part;                   // of its normal texture
};

std::string textured_glb(const TexturedMesh& given) {
  std::string bytes;
  json document = {{"asset", {{"version", "2.0"}}},
                   {"scene", 0},
                   {"scenes", {{{"nodes", {0}}}}},
                   {"nodes", {{{"mesh", 0}}}}};
  const auto accessor = [&](const auto& values, int component, const char* type, int width) {
    const std::size_t size = values.size() * sizeof(values[0]);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
    bytes.append(reinterpret_cast<const char*>(values.data()), size);
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"type", type},
                                     {"count", size / 4 / static_cast<std::size_t>(width)}});
    return document["accessors"].size() - 1;
  };
  json attributes = {{"POSITION", accessor(given.positions, 5126, "VEC3", 3)}};
  glm::vec3 least = given.positions[0], most = least;
  for (const glm::vec3& p : given.positions) least = glm::min(least, p), most = glm::max(most, p);
  document["accessors"][0]["min"] = {least.x, least.y, least.z};
  document["accessors"][0]["max"] = {most.x, most.y, most.z};
  for (std::size_t set = 0; set < given.uv_sets.size(); ++set)
    attributes["TEXCOORD_" + std::to_string(set)] = accessor(given.uv_sets[set], 5126, "VEC2", 2);
  for (std::size_t part = 0; part < given.parts.size(); ++part) {
    document["meshes"][0]["primitives"].push_back(
        {{"attributes", attributes},
         {"indices", accessor(given.parts[part], 5125, "SCALAR", 1)},
         {"material", part}});
    document["materials"].push_back(
        {{"normalTexture", {{"index", 0}, {"texCoord", given.set_of_part[part]}}}});
  }
  document["textures"] = {{{"source", 0}}};
  const std::string image = AssetSample::image();
  document["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", image.size()}});
  document["images"] = {
      {{"bufferView", document["bufferViews"].size() - 1}, {"mimeType", "image/png"}}};
  bytes += image;
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  document["buffers"] = {{{"byteLength", bytes.size()}}};
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  const auto add = [&](std::size_t number) {
    const auto small = static_cast<std::uint32_t>(number);
    glb.append(reinterpret_cast<const char*>(&small), 4);
  };
  add(2), add(28 + text.size() + bytes.size());
  add(text.size()), glb += "JSON" + text;
  add(bytes.size()), glb += std::string("BIN\0", 4) + bytes;
  return glb;
}

// A torus whose texture coordinates are cut along both circles.
TexturedMesh textured_torus(int around, int across) {
  TexturedMesh given;
  auto& uvs = given.uv_sets.emplace_back();
  for (int i = 0; i <= around; ++i) {
    for (int j = 0; j <= across; ++j) {
      const double a = 2 * std::numbers::pi * (i % around) / around;
      const double b = 2 * std::numbers::pi * (j % across) / across;
      const double r = 1 + 0.4 * std::cos(b);
      given.positions.emplace_back(r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b));
      uvs.emplace_back(3.0 * i / around + 0.1 * std::sin(a), 1.0 * j / across);
    }
  }
  auto& triangles = given.parts.emplace_back();
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const auto v = [&](int a, int b) {
        return static_cast<std::uint32_t>((i + a) * (across + 1) + j + b);
      };
      for (const std::uint32_t corner : {v(0, 0), v(1, 0), v(1, 1), v(0, 0), v(1, 1), v(0, 1)})
        triangles.push_back(corner);
    }
  }
  given.set_of_part = {0};
  return given;
}

// A box of no normals, whose faces share vertices and texture coordinates across the edges that
// turn out sharp.
TexturedMesh textured_box(int n) {
  TexturedMesh given;
  std::map<std::array<int, 3>, std::uint32_t> known;
  auto& triangles = given.parts.emplace_back();
  auto& uvs = given.uv_sets.emplace_back();
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [found, is_new] =
        known.try_emplace(p, static_cast<std::uint32_t>(given.positions.size()));
    if (is_new) {
      given.positions.emplace_back(p[0], p[1], p[2]);
      uvs.emplace_back(static_cast<float>(p[0]) + 0.37F * static_cast<float>(p[1]) +
                           0.21F * static_cast<float>(p[2]),
                       static_cast<float>(p[1]) - 0.4F * static_cast<float>(p[2]));
    }
    return found->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool is_far : {false, true}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int a, int b) {
            std::array<int, 3> p{};
            p[axis] = is_far ? n : 0;
            p[(axis + 1) % 3] = is_far ? i + a : i + b;
            p[(axis + 2) % 3] = is_far ? j + b : j + a;
            return vertex(p);
          };
          for (const std::uint32_t corner :
               {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)})
            triangles.push_back(corner);
        }
      }
    }
  }
  given.set_of_part = {0};
  return given;
}

std::vector<std::uint32_t> triangle_corners(const tinygltf::Model& model, int accessor) {
  const tinygltf::Accessor& of = model.accessors.at(static_cast<std::size_t>(accessor));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(of.bufferView));
  const std::size_t size = of.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT ? 4 : 2;
  std::vector<std::uint32_t> corners(of.count, 0);
  for (std::size_t i = 0; i < of.count; ++i)
    std::memcpy(&corners[i], model.buffers.at(0).data.data() + view.byteOffset + i * size, size);
  return corners;
}

glm::dvec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : glm::dvec3(0.0);
}

// What MikkTSpace adds to a corner.
glm::dvec3 added_at_corner(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                           const glm::dvec3& normal, const glm::dvec3& along) {
  const auto flat = [&](const glm::dvec3& v) {
    return unit_or_zero(v - normal * glm::dot(normal, v));
  };
  return std::acos(std::clamp(glm::dot(flat(b - a), flat(c - a)), -1.0, 1.0)) * flat(along);
}

class AssetTangents : public Asset {
 protected:
  // Of all triangles of the written file; how many vertices were compared.
  std::size_t compare(const tinygltf::Model& model, const std::vector<int>& set_of_part = {0}) {
    std::size_t compared = 0;
    for (std::size_t part = 0; part < model.meshes.at(0).primitives.size(); ++part) {
      const tinygltf::Primitive& primitive = model.meshes[0].primitives[part];
      const int set = set_of_part.at(part);
      const auto positions = points_of(model, primitive.attributes.at("POSITION"));
      const auto normals = points_of(model, primitive.attributes.at("NORMAL"));
      const auto uvs =
          numbers_of(model, primitive.attributes.at("TEXCOORD_" + std::to_string(set)));
      const auto tangents = numbers_of(model, primitive.attributes.at("TANGENT"));
      const std::vector<std::uint32_t> corners = triangle_corners(model, primitive.indices);
      using Key = std::array<double, 9>;
      std::map<Key, glm::dvec3> sums;
      std::vector<std::pair<std::size_t, Key>> keys;
      for (std::size_t t = 0; t < corners.size(); t += 3) {
        const std::size_t v[3] = {corners[t], corners[t + 1], corners[t + 2]};
        const auto uv = [&](std::size_t k) {
          return glm::dvec2(uvs[2 * v[k]], -uvs[2 * v[k] + 1]);
        };
        const glm::dvec2 s = uv(1) - uv(0), q = uv(2) - uv(0);
        const double area = s.x * q.y - s.y * q.x;
        const glm::dvec3 along =
            (area < 0 ? -1.0 : 1.0) *
            (q.y * (positions[v[1]] - positions[v[0]]) - s.y * (positions[v[2]] - positions[v[0]]));
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t at = v[k];
          const glm::dvec3 &p = positions[at], &n = normals[at];
          const Key key{
              p.x, p.y, p.z, n.x, n.y, n.z, uvs[2 * at], uvs[2 * at + 1], area < 0 ? -1.0 : 1.0};
          sums[key] +=
              added_at_corner(p, positions[v[(k + 1) % 3]], positions[v[(k + 2) % 3]], n, along);
          keys.emplace_back(at, key);
        }
      }
      for (const auto& [at, key] : keys) {
        const glm::dvec3 found(tangents[4 * at], tangents[4 * at + 1], tangents[4 * at + 2]);
        EXPECT_NEAR(glm::length(found), 1, 1e-6);
        EXPECT_NEAR(glm::dot(found, normals[at]), 0, 1e-6);
        const glm::dvec3 sum = sums.at(key);
        if (glm::length(sum) == 0) continue;
        EXPECT_LT(glm::length(found - unit_or_zero(sum)), 2e-5)
            << "vertex " << at << " of part " << part;
        EXPECT_EQ(tangents[4 * at + 3], key[8]) << at;
        if (HasFailure()) return 0;
        ++compared;
      }
    }
    return compared;
  }

  static FitFileOptions at_level(int level) {
    FitFileOptions options;
    options.settings.set_levels({level});
    return options;
  }
};

// Triangles at level 0 too, where some are left beside joined quads.
TEST_F(AssetTangents, AreMikkTSpacesAtAnyLevel) {
  TexturedMesh given = textured_torus(20, 12);
  given.parts[0].resize(given.parts[0].size() - 3);  // a triangle beside a hole
  for (const int level : {0, 1, 2, 3, 4})
    EXPECT_GT(compare(fitted(textured_glb(given), at_level(level))), 1000U << level) << level;
}

TEST_F(AssetTangents, DoNotMixAcrossSharpEdges) {
  for (const int level : {0, 1, 2})
    EXPECT_GT(compare(fitted(textured_glb(textured_box(4)), at_level(level))), 500U) << level;
}

TEST_F(AssetTangents, OfTinyAndHugeModelsAndTextures) {
  for (const float size : {1e-12F, 1e12F}) {
    TexturedMesh given = textured_torus(20, 12);
    for (glm::vec3& p : given.positions) p *= size;
    for (glm::vec2& t : given.uv_sets[0]) t /= size;
    EXPECT_GT(compare(fitted(textured_glb(given), at_level(1))), 1000U) << size;
  }
}

TEST_F(AssetTangents, ATextureWithoutExtentHasSomeSquareToTheNormal) {
  TexturedMesh given = textured_torus(12, 8);
  for (glm::vec2& t : given.uv_sets[0]) t = {0.25F, 0.5F};
  const tinygltf::Model model = fitted(textured_glb(given), at_level(2));
  (void)compare(model);
}

// Two charts beside each other, of which the second has its tangents by the second set.
TEST_F(AssetTangents, EachMaterialFollowsItsOwnSet) {
  TexturedMesh given = textured_torus(20, 12);
  const TexturedMesh other = textured_torus(20, 12);
  const auto first = static_cast<std::uint32_t>(given.positions.size());
  for (const glm::vec3& p : other.positions) given.positions.push_back(p + glm::vec3(0, 0, 2));
  auto& second = given.uv_sets.emplace_back();
  for (const glm::vec2& t : other.uv_sets[0]) given.uv_sets[0].push_back(t);
  for (const glm::vec2& t : given.uv_sets[0]) second.emplace_back(t.y - t.x, 2 * t.y);
  given.parts.push_back(other.parts[0]);
  for (std::uint32_t& corner : given.parts[1]) corner += first;
  for (const auto& [set_of_first, set_of_second] : {std::pair{1, 0}, std::pair{0, 1}}) {
    given.set_of_part = {set_of_first, set_of_second};
    const tinygltf::Model model = fitted(textured_glb(given), at_level(1));
    ASSERT_EQ(model.meshes.at(0).primitives.size(), 2U);
    EXPECT_GT(compare(model, given.set_of_part), 2000U);
  }
}

// Rows that are kept, made again, or looked at by one thread.
TEST(SurfaceTangents, AreTheSameBitsOfKeptRowsAndForAnyNumberOfThreads) {
  PolygonMesh mesh = test::torus(70, 40);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto left = static_cast<double>(f % 40), low = static_cast<double>(f / 40);
    for (const glm::dvec2 corner : {glm::dvec2(0, 0), {0, 1}, {1, 1}, {1, 0}}) {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.push_back(corner + glm::dvec2(left, low));
    }
  }
  const DooSabinSurface base(mesh, {});
  for (const int level : {0, 1, 2, 3}) {
    const auto blocks = base.level(level);
    const auto kept = keep_rows(*blocks, {});
    const auto rounded = keep_rows(*blocks, {.origin = glm::dvec3(1, 2, 3)});
    std::vector<glm::dvec2> uvs(static_cast<std::size_t>(blocks->info().uv_count));
    blocks->uvs({0, blocks->info().uv_count}, uvs);
    const TangentSource source{.sets = {uvs}, .set_of_group = {0}};
    const RawVector<float> made = surface_tangents(*blocks, source).values;
    EXPECT_THAT(made, testing::Each(testing::Not(testing::IsNan())));
    EXPECT_EQ(surface_tangents(*kept, source).values, made) << level;
    EXPECT_EQ(surface_tangents(*rounded, source).values, made) << level;
    oneapi::tbb::task_arena(1).execute(
        [&] { EXPECT_EQ(surface_tangents(*kept, source).values, made) << level; });
  }
}

TEST(SurfaceTangents, ABlockHasItsOwnUnderItsNumbers) {
  PolygonMesh mesh = test::torus(12, 8);
  mesh.face_uvs = mesh.face_vertices;
  mesh.uvs.assign(mesh.positions.size(), glm::dvec2(0.25, 0.5));
  const DooSabinSurface base(mesh, {});
  const auto blocks = base.level(1);
  std::vector<float> values(static_cast<std::size_t>(blocks->info().uv_count));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  std::vector<UvOnRow> further;
  std::vector<float> further_values;
  for (std::int32_t uv = 0; uv < blocks->info().uv_count; uv += 3) {
    further.push_back({uv, uv % 2 == 0 ? uv : 0});  // half of them on rows that are not theirs
    further_values.push_back(static_cast<float>(1000 + uv));
  }
  GltfOptions options;
  options.attributes = {{.name = "_OF_UVS",
                         .values = values,
                         .of_uvs = true,
                         .further = further,
                         .further_values = further_values}};
  GltfBlock block(*blocks, {40, 100}, options);
  std::vector<std::int32_t> rows(400), uvs(400);
  block.surface().face_vertices({0, 100}, rows);
  block.surface().face_uvs({0, 100}, uvs);
  const GltfAttribute& own = block.options().attributes.at(0);
  int found_further = 0;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const auto uv = block.surface().surface_uvs()[uvs[c]];
    const auto row = block.surface().surface_rows()[rows[c]];
    const float wanted =
        uv % 6 == 0 && row == uv ? 1000.0F + static_cast<float>(uv) : static_cast<float>(uv);
    EXPECT_EQ(*own.numbers(uvs[c], rows[c]), wanted);
    found_further += wanted >= 1000 ? 1 : 0;
  }
  EXPECT_GT(found_further, 20);
}

}  // namespace
}  // namespace planish::test
