// Primitives on triangles that others have: their materials are layers of one surface.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <set>
#include <utility>

#include "pipeline/asset_fixture.h"
#include "pipeline/glb_draft.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

// A primitive of a GLB, by its vertices.
struct Part {
  int material = 0;
  std::vector<glm::dvec3> positions;
  std::map<std::string, std::vector<std::vector<double>>> attributes;
  std::vector<std::int32_t> indices;
};

std::string glb_of_parts(const std::vector<Part>& parts, int materials) {
  GlbDraft draft;
  for (const Part& part : parts) {
    json primitive = {{"material", part.material}};
    primitive["attributes"]["POSITION"] = draft.add_positions(part.positions);
    for (const auto& [name, values] : part.attributes) {
      std::vector<double> all;
      for (const std::vector<double>& of : values) all.insert(all.end(), of.begin(), of.end());
      const std::size_t number = draft.add_floats(all, values.front().size());
      if (name.starts_with("target/")) {
        primitive["targets"] = {{{name.substr(9), number}}};
      } else {
        primitive["attributes"][name] = number;
      }
    }
    primitive["indices"] = draft.add_indices(part.indices);
    draft.add_primitive(primitive);
  }
  for (int m = 0; m < materials; ++m)
    draft.document["materials"].push_back({{"name", "material " + std::to_string(m)}});
  return draft.glb();
}

constexpr int kSide = 6;

// Cells [first, last) of a flat plate of kSide by kSide cells both ways, each of two triangles that
// begin with their corner number `turn`; uv = scale * (x, y).
Part cut_plate(int material, int first, int last, std::size_t turn, double scale) {
  Part made{.material = material, .positions = {}, .attributes = {}, .indices = {}};
  const int across = last - first + 1;
  for (int j = first; j <= last; ++j)
    for (int i = first; i <= last; ++i) {
      const double moved = i % kSide == 0 || j % kSide == 0 ? 0 : 0.15 * std::sin(5.0 * i + 3 * j);
      made.positions.emplace_back(i + moved, j - moved, 0);
      const glm::dvec3& p = made.positions.back();
      made.attributes["TEXCOORD_0"].push_back({scale * p.x, scale * p.y});
    }
  const auto add = [&](std::array<int, 3> triangle) {
    for (std::size_t k = 0; k < 3; ++k) made.indices.push_back(triangle[(k + turn) % 3]);
  };
  for (int j = 0; j + 1 < across; ++j)
    for (int i = 0; i + 1 < across; ++i) {
      const int a = j * across + i;
      add({a, a + 1, a + across + 1});
      add({a, a + across + 1, a + across});
    }
  return made;
}

class AssetLayersTest : public Asset {
 protected:
  static const tinygltf::Primitive& of_material(const tinygltf::Model& model, int material) {
    const auto& primitives = model.meshes.at(0).primitives;
    const auto found = std::ranges::find(primitives, material, &tinygltf::Primitive::material);
    if (found == primitives.end()) throw std::runtime_error("no primitive has the material");
    return *found;
  }
  static std::vector<int> materials_of(const tinygltf::Model& model) {
    std::vector<int> materials;
    for (const tinygltf::Primitive& primitive : model.meshes.at(0).primitives)
      materials.push_back(primitive.material);
    return materials;
  }
  // The largest distance of texture coordinates from scale * (x, y), in parts of the plate's.
  static double worst_uv(const tinygltf::Model& model, const tinygltf::Primitive& of,
                         double scale) {
    const auto points = points_of(model, of.attributes.at("POSITION"));
    const auto uvs = numbers_of(model, of.attributes.at("TEXCOORD_0"));
    double worst = 0;
    for (const double index : numbers_of(model, of.indices)) {
      const auto i = static_cast<std::size_t>(index);
      worst = std::max({worst, std::abs(uvs[2 * i] - scale * points[i].x),
                        std::abs(uvs[2 * i + 1] - scale * points[i].y)});
    }
    return worst / (scale * kSide);
  }
  tinygltf::Model fitted_parts(const std::vector<Part>& parts, int materials = 3, int level = 2) {
    FitFileOptions options;
    options.settings.set_levels({level});
    warnings_.clear();
    options.callbacks.warning = [&](const Warning& one) { warnings_.insert(one.code); };
    return fitted(glb_of_parts(parts, materials), options);
  }
  std::set<std::string> warnings_;
};

TEST_F(AssetLayersTest, ADecalLiesOnTheSurfaceOfWhatItCovers) {
  for (const std::size_t turn : {0U, 1U, 2U}) {
    const tinygltf::Model model =
        fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), cut_plate(1, 2, 4, turn, 0.5)});
    // What is covered, what is not, and the decal.
    ASSERT_THAT(materials_of(model), ElementsAre(0, 0, 1));
    const auto& primitives = model.meshes[0].primitives;
    const tinygltf::Primitive& decal = primitives[2];
    const auto under = std::ranges::find(primitives, decal.indices, &tinygltf::Primitive::indices);
    ASSERT_LT(under - primitives.begin(), 2);
    for (const char* const shared : {"POSITION", "NORMAL"})
      EXPECT_EQ(decal.attributes.at(shared), under->attributes.at(shared));
    for (const tinygltf::Primitive& base : {primitives[0], primitives[1]}) {
      EXPECT_LT(worst_uv(model, base, 0.125), 1e-6);
      EXPECT_EQ(base.attributes.size(), 3U);
    }
    EXPECT_LT(worst_uv(model, decal, 0.5), 1e-6);
    EXPECT_EQ(decal.attributes.size(), 3U);
    const double covered = static_cast<double>(numbers_of(model, decal.indices).size());
    double all = 0;
    for (const tinygltf::Primitive& base : {primitives[0], primitives[1]})
      all += static_cast<double>(numbers_of(model, base.indices).size());
    EXPECT_NEAR(covered / all, 4.0 / 36, 0.02);
    EXPECT_FALSE(warnings_.contains("duplicate-faces"));
  }
}

TEST_F(AssetLayersTest, ACoatOverAllChangesNothingUnderIt) {
  const Part base = cut_plate(0, 0, kSide, 0, 0.125);
  Part coat = cut_plate(1, 0, kSide, 1, 3);
  for (std::size_t i = 0; i < coat.positions.size(); ++i)
    coat.attributes["COLOR_0"].push_back({i % 2 == 0 ? 1.0 : 0.25, 0.5, 0, 1});
  const tinygltf::Model alone = fitted_parts({base}), both = fitted_parts({base, coat});
  ASSERT_THAT(materials_of(both), ElementsAre(0, 1));
  const auto &before = alone.meshes[0].primitives[0], &after = both.meshes[0].primitives[0];
  EXPECT_EQ(numbers_of(alone, before.indices), numbers_of(both, after.indices));
  ASSERT_EQ(before.attributes.size(), after.attributes.size());
  for (const auto& [name, accessor] : before.attributes)
    EXPECT_EQ(numbers_of(alone, accessor), numbers_of(both, after.attributes.at(name))) << name;
  const tinygltf::Primitive& layer = both.meshes[0].primitives[1];
  EXPECT_EQ(layer.indices, after.indices);
  EXPECT_LT(worst_uv(both, layer, 3), 1e-6);
  const std::vector<double> colours = numbers_of(both, layer.attributes.at("COLOR_0"));
  EXPECT_EQ(*std::ranges::min_element(colours), 0);
  std::set<double> reds;
  for (std::size_t i = 0; i < colours.size(); i += 4) reds.insert(colours[i]);
  EXPECT_EQ(*reds.begin(), 0.25);
  EXPECT_EQ(*reds.rbegin(), 1);
}

TEST_F(AssetLayersTest, LayersLieOnLayers) {
  const tinygltf::Model model =
      fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), cut_plate(1, 1, 5, 1, 0.25),
                    cut_plate(2, 2, 4, 2, 0.5), cut_plate(3, 0, 1, 2, 2)},
                   4);
  ASSERT_THAT(materials_of(model), testing::UnorderedElementsAre(0, 0, 0, 0, 1, 1, 2, 3));
  const std::map<int, double> scales = {{0, 0.125}, {1, 0.25}, {2, 0.5}, {3, 2}};
  std::map<int, std::size_t> corners;
  for (const tinygltf::Primitive& primitive : model.meshes[0].primitives) {
    EXPECT_EQ(primitive.attributes.size(), 3U);
    EXPECT_LT(worst_uv(model, primitive, scales.at(primitive.material)), 1e-6);
    corners[primitive.material] += numbers_of(model, primitive.indices).size();
  }
  EXPECT_GT(corners[0], corners[1]);
  EXPECT_GT(corners[1], corners[2]);
  EXPECT_GT(corners[2], corners[3]);
  // What lies on others comes after them.
  const std::vector<int> order = materials_of(model);
  EXPECT_EQ(order.back(), 2);
}

// Sets of texture coordinates, morphed ones among them, and none.
TEST_F(AssetLayersTest, EachHasSetsOfItsOwn) {
  Part base = cut_plate(0, 0, kSide, 0, 0.125), decal = cut_plate(1, 2, 4, 0, 0.5);
  base.attributes.erase("TEXCOORD_0");
  decal.attributes["TEXCOORD_1"] = decal.attributes["TEXCOORD_0"];
  for (Part* part : {&base, &decal})
    for (const glm::dvec3& p : part->positions)
      part->attributes["target/0/POSITION"].push_back({0, 0, 0.1 * p.x});
  tinygltf::Model model = fitted_parts({base, decal});
  const auto names = [&](const tinygltf::Primitive& of) {
    std::set<std::string> found;
    for (const auto& [name, accessor] : of.attributes) found.insert(name);
    for (const auto& target : of.targets)
      for (const auto& [name, accessor] : target) found.insert("target " + name);
    return found;
  };
  EXPECT_THAT(names(of_material(model, 0)),
              ElementsAre("NORMAL", "POSITION", "target NORMAL", "target POSITION"));
  EXPECT_THAT(names(of_material(model, 1)),
              ElementsAre("NORMAL", "POSITION", "TEXCOORD_0", "TEXCOORD_1", "target NORMAL",
                          "target POSITION"));
  EXPECT_LT(worst_uv(model, of_material(model, 1), 0.5), 1e-6);

  // And a layer without any on a base of two.
  base = cut_plate(0, 0, kSide, 0, 0.125), decal = cut_plate(1, 2, 4, 0, 0.5);
  base.attributes["TEXCOORD_1"] = base.attributes["TEXCOORD_0"];
  decal.attributes.erase("TEXCOORD_0");
  model = fitted_parts({base, decal});
  EXPECT_THAT(names(of_material(model, 0)),
              ElementsAre("NORMAL", "POSITION", "TEXCOORD_0", "TEXCOORD_1"));
  EXPECT_THAT(names(of_material(model, 1)), ElementsAre("NORMAL", "POSITION"));
}

TEST_F(AssetLayersTest, OtherTrianglesAreNone) {
  // The same material once more: faces are repeated.
  EXPECT_THAT(
      materials_of(fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), cut_plate(0, 2, 4, 1, 0.5)})),
      ElementsAre(0));
  EXPECT_TRUE(warnings_.contains("duplicate-faces"));
  // Turned round, and only in part on others: as they were before.
  Part back = cut_plate(1, 2, 4, 0, 0.5);
  for (std::size_t i = 0; i < back.indices.size(); i += 3)
    std::swap(back.indices[i], back.indices[i + 1]);
  fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), back});
  EXPECT_TRUE(warnings_.contains("duplicate-faces"));
  Part wider = cut_plate(1, 2, 4, 0, 0.5);
  const auto next = static_cast<std::int32_t>(wider.positions.size());
  wider.positions.emplace_back(3, 3, 5);
  wider.attributes["TEXCOORD_0"].push_back({0, 0});
  for (const std::int32_t v : {0, 1, next}) wider.indices.push_back(v);
  EXPECT_THAT(materials_of(fitted_parts({cut_plate(0, 0, kSide, 0, 0.125), wider})),
              ElementsAre(0, 1));
  EXPECT_TRUE(warnings_.contains("duplicate-faces"));
}

// Whatever has no face shifts no material.
TEST_F(AssetLayersTest, PrimitivesWithoutAreaShiftNoMaterial) {
  Part flat = cut_plate(1, 0, 1, 0, 1);
  for (std::size_t i = 0; i < flat.indices.size(); i += 3) flat.indices[i + 1] = flat.indices[i];
  const tinygltf::Model model =
      fitted_parts({flat, cut_plate(0, 0, kSide, 0, 0.125), cut_plate(2, 2, 4, 1, 0.5)});
  EXPECT_THAT(materials_of(model), UnorderedElementsAre(0, 0, 2));
}

}  // namespace
}  // namespace planish::test
