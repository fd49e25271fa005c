// Extensions of glTF that pass, and those that pack the input.
#include <gmock/gmock.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/asset_fixture.h"
#include "planish/files/gltf/asset/gltf_asset.h"

namespace planish::test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::ElementsAre;
using testing::Not;

class AssetExtensions : public Asset {
 protected:
  // What tinygltf need not read.
  void pass(const FitFileOptions& options) {
    (void)fit_file(write("in.glb", sample_.glb()), folder_ / "out.glb", options);
  }
  // At level 0, for what does not depend on it.
  tinygltf::Model passed() {
    FitFileOptions options;
    options.settings.set_levels({0});
    return fitted(sample_.glb(), options);
  }
};

TEST_F(AssetExtensions, TexturesKeepTheirTransforms) {
  json& material = sample_.json["materials"][0];
  const json transform = {
      {"offset", {0.25, 0.5}}, {"rotation", 0.3}, {"scale", {2, 3}}, {"texCoord", 1}};
  for (json* texture :
       {&material["pbrMetallicRoughness"]["baseColorTexture"], &material["normalTexture"]})
    (*texture)["extensions"]["KHR_texture_transform"] = transform;
  sample_.json["extensionsUsed"].push_back("KHR_texture_transform");
  const json given = sample_.json["materials"];
  (void)passed();
  EXPECT_EQ(written_json()["materials"], given);
  EXPECT_THAT(written_json()["extensionsUsed"], Contains("KHR_texture_transform"));
  // Tangents are those of the set that the transform names.
  EXPECT_EQ(tangent_set(sample_.json, sample_.json["meshes"][0]["primitives"][0]), 1);
  material["normalTexture"]["extensions"]["KHR_texture_transform"].erase("texCoord");
  EXPECT_EQ(tangent_set(sample_.json, sample_.json["meshes"][0]["primitives"][0]), 0);
}

TEST_F(AssetExtensions, CamerasLightsAndVariantsPass) {
  sample_.json["extensionsUsed"].push_back("KHR_materials_variants");
  sample_.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "day"}},
                                                                      {{"name", "night"}}};
  const json mappings = {{"mappings", {{{"material", 1}, {"variants", {1}}}}}};
  sample_.json["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"] = mappings;
  sample_.json["cameras"].push_back(
      {{"type", "orthographic"},
       {"name", "plan"},
       {"orthographic", {{"xmag", 2.5}, {"ymag", 1.5}, {"zfar", 9}, {"znear", 0.5}}}});
  sample_.json["nodes"][2]["camera"] = 1;
  (void)passed();
  const json made = written_json();
  for (const char* key : {"cameras", "extensions", "nodes"})
    EXPECT_EQ(made[key], sample_.json[key]) << key;
  EXPECT_THAT(made["extensionsUsed"], Contains("KHR_materials_variants"));
  EXPECT_EQ(made["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"], mappings);
}

json pointer_to(const std::string& place) {
  return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", place}}}}}};
}

TEST_F(AssetExtensions, AnimationsByPointersPass) {
  sample_.json["extensionsUsed"].push_back("KHR_animation_pointer");
  json& channels = sample_.json["animations"][0]["channels"];
  channels[0]["target"] = pointer_to("/materials/0/pbrMetallicRoughness/roughnessFactor");
  channels[1]["target"] = pointer_to("/nodes/0/weights");
  FitFileOptions options;
  options.settings.set_levels({0});
  pass(options);
  EXPECT_EQ(written_json()["animations"], sample_.json["animations"]);
  EXPECT_THAT(written_json()["extensionsUsed"], Contains("KHR_animation_pointer"));
  // With levels of detail, weights move those of every level.
  options.settings.set_levels({1, 0});
  options.settings.lods = LodChoice::Msft;
  pass(options);
  const json made = written_json();
  ASSERT_EQ(made["animations"][0]["channels"].size(), 3u);
  std::vector<std::string> places;
  for (const json& channel : made["animations"][0]["channels"])
    places.push_back(channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"]);
  const json coarser = made["nodes"][0]["extensions"]["MSFT_lod"]["ids"];
  ASSERT_EQ(coarser.size(), 1u);
  EXPECT_THAT(places,
              ElementsAre("/materials/0/pbrMetallicRoughness/roughnessFactor", "/nodes/0/weights",
                          "/nodes/" + std::to_string(coarser[0].get<int>()) + "/weights"));
}

// What meshopt packed of key frames and of a mesh comes as it was before.
TEST_F(AssetExtensions, WhatMeshoptPackedComesUnpacked) {
  const tinygltf::Model plain = passed();
  const auto pack = [&](int accessor) {
    json& view = sample_.json["bufferViews"]
                             [sample_.json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    const auto count = sample_.json["accessors"][accessor]["count"].get<std::size_t>();
    const auto begin = view["byteOffset"].get<std::size_t>();
    const std::size_t stride = view["byteLength"].get<std::size_t>() / count;
    std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(count, stride));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(),
                                             sample_.bytes.data() + begin, count, stride));
    sample_.bytes.replace(begin, count * stride, count * stride, '\0');
    sample_.bytes.resize((sample_.bytes.size() + 3) / 4 * 4);
    view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                     {"byteOffset", sample_.bytes.size()},
                                                     {"byteLength", packed.size()},
                                                     {"byteStride", stride},
                                                     {"count", count},
                                                     {"mode", "ATTRIBUTES"}};
    sample_.bytes.append(packed.begin(), packed.end());
  };
  const auto turns = sample_.json["animations"][0]["samplers"][0]["output"].get<int>();
  pack(turns);
  pack(sample_.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"].get<int>());
  for (const char* key : {"extensionsUsed", "extensionsRequired"})
    sample_.json[key].push_back("EXT_meshopt_compression");
  const tinygltf::Model model = passed();
  EXPECT_EQ(numbers_of(model, model.animations.at(0).samplers.at(0).output),
            numbers_of(plain, plain.animations.at(0).samplers.at(0).output));
  EXPECT_EQ(points_of(model, model.meshes.at(1).primitives.at(0).attributes.at("POSITION")),
            points_of(plain, plain.meshes.at(1).primitives.at(0).attributes.at("POSITION")));
  const json made = written_json();
  EXPECT_THAT(made["extensionsUsed"], Not(Contains("EXT_meshopt_compression")));
  EXPECT_FALSE(made.contains("extensionsRequired"));
  for (const json& view : made["bufferViews"]) EXPECT_FALSE(view.contains("extensions")) << view;
}

// Numbers of things ride on the ball, one a vertex.
class AssetThings : public AssetExtensions {
 protected:
  std::vector<glm::dvec3> add_ids(const std::function<int(std::size_t)>& id_of, int component) {
    json& ball = sample_.json["meshes"][1]["primitives"][0];
    const json positions =
        sample_.json["accessors"][ball["attributes"]["POSITION"].get<std::size_t>()];
    const json& view = sample_.json["bufferViews"][positions["bufferView"].get<std::size_t>()];
    std::vector<glm::dvec3> points;
    std::string ids;
    for (std::size_t v = 0; v < positions["count"].get<std::size_t>(); ++v) {
      std::array<float, 3> point;
      std::memcpy(point.data(),
                  sample_.bytes.data() + view["byteOffset"].get<std::size_t>() + 12 * v, 12);
      points.emplace_back(point[0], point[1], point[2]);
      if (component == 5126) {
        append<float>(ids, static_cast<float>(id_of(v)));
      } else {
        append<std::uint16_t>(ids, static_cast<std::uint16_t>(id_of(v)));
        append<std::uint16_t>(ids, 0);
      }
    }
    sample_.json["bufferViews"].push_back({{"buffer", 0},
                                           {"byteOffset", sample_.bytes.size()},
                                           {"byteLength", ids.size()},
                                           {"byteStride", 4}});
    sample_.bytes += ids;
    sample_.json["accessors"].push_back({{"bufferView", sample_.json["bufferViews"].size() - 1},
                                         {"componentType", component},
                                         {"count", points.size()},
                                         {"type", "SCALAR"}});
    ball["attributes"]["_FEATURE_ID_0"] = sample_.json["accessors"].size() - 1;
    ball["extensions"]["EXT_mesh_features"] = {
        {"featureIds", {{{"featureCount", 9}, {"attribute", 0}}}}};
    sample_.json["extensionsUsed"].push_back("EXT_mesh_features");
    return points;
  }
};

// Each vertex of the surface has the number of a given one beside it, as it is: at given vertices
// their own, elsewhere no one's who is much farther than the nearest.
TEST_F(AssetThings, NumbersOfThingsAreTheNearestVertexs) {
  for (const int component : {5126, 5123}) {
    sample_ = AssetSample();
    const auto id_of = [](std::size_t v) { return static_cast<int>(v % 5) * 1000; };
    const std::vector<glm::dvec3> given = add_ids(id_of, component);
    const tinygltf::Model model = fitted(sample_.glb());
    const auto& attributes = model.meshes.at(1).primitives.at(0).attributes;
    EXPECT_EQ(model.accessors.at(attributes.at("_FEATURE_ID_0")).componentType, component);
    const std::vector<double> ids = numbers_of(model, attributes.at("_FEATURE_ID_0"));
    const std::vector<glm::dvec3> points = points_of(model, attributes.at("POSITION"));
    ASSERT_EQ(ids.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      double nearest = 9, nearest_of_id = 9;
      for (std::size_t v = 0; v < given.size(); ++v) {
        const double distance = glm::length(points[i] - given[v]);
        nearest = std::min(nearest, distance);
        if (id_of(v) == ids[i]) nearest_of_id = std::min(nearest_of_id, distance);
      }
      EXPECT_LE(nearest_of_id, 1.5 * nearest + 1e-6) << i;
    }
    EXPECT_EQ(written_json()["meshes"][1]["primitives"][0]["extensions"],
              sample_.json["meshes"][1]["primitives"][0]["extensions"]);
  }
}

// What describes the triangles that give way goes with them, known or not; other things stay.
TEST_F(AssetExtensions, WhatDescribesOldTrianglesGoesWithThem) {
  json& mesh = sample_.json["meshes"][1];
  json& ball = mesh["primitives"][0];
  mesh["extensions"]["EXT_mesh_manifold"] = {
      {"manifoldPrimitive", {{"indices", ball["indices"]}, {"attributes", ball["attributes"]}}}};
  ball["extensions"] = {{"CESIUM_primitive_outline", {{"indices", ball["indices"]}}},
                        {"ACME_wires", {{"wires", {{{"accessor", ball["indices"]}}}}}},
                        {"ACME_price", {{"price", 12}}}};
  sample_.json["scenes"][0]["extensions"]["FB_geometry_metadata"] = {{"vertexCount", 634}};
  for (const char* name : {"EXT_mesh_manifold", "CESIUM_primitive_outline", "ACME_wires",
                           "ACME_price", "FB_geometry_metadata"})
    sample_.json["extensionsUsed"].push_back(name);
  FitFileOptions options;
  std::string said;
  options.callbacks.warning = [&](const Warning& one) {
    EXPECT_EQ(one.code, "left-out-extensions");
    EXPECT_EQ(one.count, 4);
    said = one.message;
  };
  pass(options);
  EXPECT_TRUE(
      said.ends_with("left out, since they describe the triangles that give way: "
                     "ACME_wires, CESIUM_primitive_outline, EXT_mesh_manifold, "
                     "FB_geometry_metadata"))
      << said;
  const json made = written_json();
  EXPECT_FALSE(made["meshes"][1].contains("extensions"));
  EXPECT_EQ(made["meshes"][1]["primitives"][0]["extensions"],
            json({{"ACME_price", {{"price", 12}}}}));
  EXPECT_FALSE(made["scenes"][0].contains("extensions"));
  EXPECT_THAT(made["extensionsUsed"],
              ElementsAre("ACME_price", "EXT_mesh_gpu_instancing", "KHR_lights_punctual",
                          "KHR_materials_clearcoat", "VENDOR_secret"));
}

// FB_ngon_encoding: triangles that follow each other and begin with one vertex are one polygon.
TEST_F(AssetExtensions, TrianglesEncodeTheQuadsOfTheSurface) {
  const auto quads_of = [&](bool encodes) {
    for (json& primitive : sample_.json["meshes"][0]["primitives"]) {
      primitive.erase("extensions");
      if (encodes) primitive["extensions"]["FB_ngon_encoding"] = json::object();
    }
    const tinygltf::Model model = fitted(sample_.glb());
    std::vector<std::vector<double>> quads;
    for (const tinygltf::Primitive& primitive : model.meshes[0].primitives) {
      const std::vector<double> corners = numbers_of(model, primitive.indices);
      for (std::size_t i = 0; i < corners.size(); i += 6) {
        std::vector<double> quad(corners.begin() + static_cast<std::ptrdiff_t>(i),
                                 corners.begin() + static_cast<std::ptrdiff_t>(i) + 6);
        if (encodes) {
          EXPECT_EQ(quad[0], quad[3]);
          EXPECT_EQ(quad[2], quad[4]);
          if (i > 0) {
            EXPECT_NE(quad[0], corners[i - 6]);
          }
        }
        std::ranges::sort(quad);
        quad.erase(std::unique(quad.begin(), quad.end()), quad.end());
        EXPECT_EQ(quad.size(), 4u);
        quads.push_back(quad);
      }
    }
    return quads;
  };
  EXPECT_FALSE(quads_of(true).empty());  // of polygons, which the plain triangles are not
  EXPECT_TRUE(sample_.json["meshes"][0]["primitives"][0].contains("material"));
}

}  // namespace
}  // namespace planish::test
