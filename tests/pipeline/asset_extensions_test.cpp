// Extensions of glTF that pass, and those that pack the input.
#include <gmock/gmock.h>
#include <meshoptimizer.h>

#include <string>
#include <vector>

#include "pipeline/asset_fixture.h"
#include "planish/files/gltf/asset/tangent_sets.h"

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
    options.level = 0;
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
  options.level = 0;
  pass(options);
  EXPECT_EQ(written_json()["animations"], sample_.json["animations"]);
  EXPECT_THAT(written_json()["extensionsUsed"], Contains("KHR_animation_pointer"));
  // With levels of detail, weights move those of every level.
  options.level = 1;
  options.coarser_levels = {0};
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

}  // namespace
}  // namespace planish::test
