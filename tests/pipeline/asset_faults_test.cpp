// Assets that are wrong: whatever names what is not there, or has another number of things than it
// should, is said with its place and what to do; nothing is written.
#include <gmock/gmock.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/asset_fixture.h"
#include "support/calls.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

class AssetFaults : public Asset {
 protected:
  using Change = std::function<void(json&)>;

  std::string refusal(const Change& change) {
    AssetSample broken;
    change(broken.json);
    const fs::path input = write("in.glb", broken.glb());
    std::string message;
    // As a GLB, and as a document with a buffer beside it.
    for (const char* name : {"out.glb", "out.gltf"}) {
      message =
          message_of(ErrorCode::UnreadableInput, [&] { (void)fit_file(input, folder_ / name); });
      EXPECT_FALSE(fs::exists(folder_ / name)) << message;
      EXPECT_FALSE(fs::exists(folder_ / "out.bin")) << message;
    }
    EXPECT_THAT(message, HasSubstr("in.glb: "));
    return message;
  }
  // With the remedy of what a program wrote wrongly.
  void expect(const Change& change, const std::string& what) {
    EXPECT_THAT(refusal(change),
                AllOf(HasSubstr(what), HasSubstr("save it anew with the program that wrote it")));
  }
};

json& first_target(json& all) { return all["meshes"][0]["primitives"][0]["targets"][0]; }

TEST_F(AssetFaults, TexturesAndMaterialsThatAreNotThere) {
  expect(
      [](json& all) {
        all["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 3;
      },
      "materials[0].pbrMetallicRoughness.baseColorTexture.index: names textures[3], and the file "
      "has 1");
  expect([](json& all) { all["textures"][0]["source"] = 9; },
         "textures[0].source: names images[9]");
  expect([](json& all) { all["textures"][0]["sampler"] = 1; },
         "textures[0].sampler: names samplers[1], and the file has 1");
  expect([](json& all) { all["images"][0]["bufferView"] = 99; },
         "images[0].bufferView: names bufferViews[99]");
  expect([](json& all) { all["meshes"][1]["primitives"][0]["material"] = 3; },
         "meshes[1].primitives[0].material: names materials[3]");
  expect(
      [](json& all) {
        all["meshes"][1]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = {
            {{"material", 5}, {"variants", {0}}}};
      },
      "mappings[0].material: names materials[5]");
}

TEST_F(AssetFaults, BytesThatAreNotThere) {
  EXPECT_THAT(refusal([](json& all) {
                all["bufferViews"][all["images"][0]["bufferView"].get<int>()]["byteLength"] = 1
                                                                                              << 30;
              }),
              HasSubstr("; fetch the file anew, it may be cut short"));
  expect([](json& all) { all["bufferViews"][0]["buffer"] = 1; },
         "bufferViews[0].buffer: names buffers[1], and the file has 1");
  // Of what only passes.
  const auto times = [](json& all) -> json& {
    return all["accessors"][all["animations"][0]["samplers"][0]["input"].get<int>()];
  };
  expect([&](json& all) { times(all)["byteOffset"] = 4; },
         "3 elements of 4 bytes reach beyond bufferViews[");
  expect([&](json& all) { times(all)["byteOffset"] = 1LL << 52; }, "reach beyond bufferViews[");
  expect([&](json& all) { times(all)["bufferView"] = 99; }, "names bufferViews[99]");
  expect([](json& all) { all["animations"][0]["samplers"][1]["output"] = 99; },
         "animations[0].samplers[1].output: names accessors[99]");
  expect([](json& all) { all["meshes"][2]["primitives"][1]["attributes"]["POSITION"] = 99; },
         "meshes[2].primitives[1].attributes.POSITION: names accessors[99]");
  expect([](json& all) { all["meshes"][0]["primitives"][0]["indices"] = 99; },
         "meshes[0].primitives[0].indices: names accessors[99]");
}

TEST_F(AssetFaults, Skins) {
  EXPECT_THAT(refusal([](json& all) { all["skins"][0]["joints"] = json::array(); }),
              HasSubstr("skins[0].joints: a skin needs a joint; remove the skin"));
  expect(
      [](json& all) {
        all["skins"][0]["joints"] = {1, 40};
      },
      "skins[0].joints[1]: names nodes[40], and the file has 9");
  expect(
      [](json& all) {
        all["skins"][0]["joints"] = {1, 2, 3};
      },
      "skins[0].inverseBindMatrices: 2 matrices for 3 joints");
  expect([](json& all) { all["skins"][0]["skeleton"] = 9; }, "skins[0].skeleton: names nodes[9]");
  expect([](json& all) { all["nodes"][0]["skin"] = 4; }, "nodes[0].skin: names skins[4]");
  EXPECT_THAT(
      refusal([](json& all) { all["skins"][0]["joints"] = {1}; }),
      HasSubstr("nodes[0].skin: its mesh names joint 1, and the skin has 1; take the skin"));
  for (const char* missing : {"WEIGHTS_0", "JOINTS_0"})
    EXPECT_THAT(
        refusal([&](json& all) { all["meshes"][0]["primitives"][0]["attributes"].erase(missing); }),
        HasSubstr("joints and weights come in pairs, and one is missing"));
}

TEST_F(AssetFaults, MorphTargets) {
  EXPECT_THAT(
      refusal([](json& all) { all["meshes"][0]["primitives"][1]["targets"] = json::array(); }),
      HasSubstr("0 morph targets, and another primitive of the mesh has 1"));
  expect([](json& all) { all["accessors"][first_target(all)["POSITION"].get<int>()]["count"] = 7; },
         "meshes[0].primitives[0].targets[0].POSITION: 7 moves for 221 vertices");
  expect([](json& all) { first_target(all)["NORMAL"] = 99; }, "NORMAL: names accessors[99]");
  expect(
      [](json& all) {
        all["meshes"][0]["weights"] = {0.0, 1.0};
      },
      "meshes[0].weights: 2 for 1 morph targets");
  expect(
      [](json& all) {
        all["nodes"][0]["weights"] = json::array({0.0, 1.0, 0.5});
      },
      "nodes[0].weights: 3 for 1 morph targets");
  expect([](json& all) { all["animations"][0]["samplers"][1]["interpolation"] = "CUBICSPLINE"; },
         "animations[0].samplers[1].output: 3 values for 3 key frames of 3");
}

// Of nodes without a mesh, too: who reads the surface's file asks all of them.
TEST_F(AssetFaults, Transforms) {
  EXPECT_THAT(refusal([](json& all) { all["nodes"][3]["matrix"] = std::vector<double>(15, 1.0); }),
              HasSubstr("nodes[3].matrix: has 15 numbers, 16 are needed"));
  EXPECT_THAT(refusal([](json& all) {
                all["nodes"][3]["rotation"] = {0, 0, 0, 0};
              }),
              HasSubstr("nodes[3].rotation: is no rotation"));
}

TEST_F(AssetFaults, Nodes) {
  EXPECT_THAT(refusal([](json& all) { all["nodes"][2]["children"] = {1}; }),
              HasSubstr("nodes must form trees; save it anew with"));
  EXPECT_THAT(refusal([](json& all) {
                all["nodes"][3]["children"] = {1, 2};
              }),
              HasSubstr("is a child of node"));
  expect([](json& all) { all["nodes"][3]["children"] = {9}; },
         "nodes[3].children[0]: names nodes[9], and the file has 9");
  expect([](json& all) { all["scenes"][0]["nodes"][2] = 12; },
         "scenes[0].nodes[2]: names nodes[12]");
  expect([](json& all) { all["scene"] = 1; }, "scene: names scenes[1], and the file has 1");
  expect([](json& all) { all["nodes"][4]["mesh"] = 3; }, "nodes[4].mesh: names meshes[3]");
  expect([](json& all) { all["nodes"][8]["camera"] = 1; }, "nodes[8].camera: names cameras[1]");
  expect([](json& all) { all["nodes"][6]["extensions"]["KHR_lights_punctual"]["light"] = 1; },
         "nodes[6].extensions.KHR_lights_punctual.light: names lights[1], and the file has 1");
  expect(
      [](json& all) {
        all["nodes"][4]["extensions"]["MSFT_lod"]["ids"] = {5, 10};
      },
      "nodes[4].extensions.MSFT_lod.ids[1]: names nodes[10]");
  expect(
      [](json& all) {
        all["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = 77;
      },
      "attributes.SCALE: names accessors[77]");
  expect(
      [](json& all) {
        all["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
            all["meshes"][1]["primitives"][0]["attributes"]["POSITION"];
      },
      "attributes.TRANSLATION: 3 values, and another attribute has 86; each place needs one");
  expect(
      [](json& all) {
        json& places = all["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        places["ROTATION"] = places["TRANSLATION"];
      },
      "attributes.ROTATION: is no VEC4, as each place needs one; save it anew");
}

TEST_F(AssetFaults, Animations) {
  EXPECT_THAT(refusal([](json& all) { all["animations"][0]["channels"][0]["sampler"] = 7; }),
              HasSubstr("animations[0].channels[0].sampler: names samplers[7], and the "
                        "animation has 2; save it anew"));
  expect([](json& all) { all["animations"][0]["channels"][0]["target"]["node"] = 9; },
         "animations[0].channels[0].target.node: names nodes[9]");
  expect(
      [](json& all) {
        all["accessors"][all["animations"][0]["samplers"][0]["output"].get<int>()]["count"] = 2;
      },
      "animations[0].samplers[0].output: 2 values for 3 key frames of 1");
}

TEST_F(AssetFaults, PointersOfAnimations) {
  const auto aim = [](json& all, const char* pointer) {
    all["extensionsUsed"].push_back("KHR_animation_pointer");
    all["animations"][0]["channels"][0]["target"] = {
        {"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
  };
  for (const auto& [pointer, why] : std::vector<std::pair<const char*, const char*>>{
           {"/materials/3/alphaCutoff", "the file has 3 of materials"},
           {"/nodes/9/translation", "the file has 9 of nodes"},
           {"/meshes/0/weights/1", "the file has 1 of meshes[0].weights"},
           {"/sounds/0/volume", "the file has no sounds"},
           {"nodes/0", "it begins with no /"}})
    expect([&](json& all) { aim(all, pointer); },
           "`" + std::string(pointer) + "` names nothing: " + why);
  // Members that have a default need not stand there.
  for (const char* pointer : {"/materials/2/alphaCutoff", "/nodes/0/weights/0", "/nodes/8/rotation",
                              "/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor",
                              "/extensions/KHR_lights_punctual/lights/0/intensity"}) {
    AssetSample sample;
    aim(sample.json, pointer);
    FitFileOptions options;
    options.settings.set_levels({0});
    EXPECT_NO_THROW((void)fit_file(write("in.glb", sample.glb()), folder_ / "out.glb", options))
        << pointer;
  }
}

TEST_F(AssetFaults, Extensions) {
  EXPECT_THAT(refusal([](json& all) {
                all["extensionsUsed"] = {1, 2};
              }),
              HasSubstr("in.glb: a value is not of the kind that glTF has there"));
  EXPECT_THAT(refusal([](json& all) { all["extensionsRequired"] = {"VENDOR_secret"}; }),
              HasSubstr("VENDOR_secret"));
}

}  // namespace
}  // namespace planish::test
