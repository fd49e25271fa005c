// What becomes of the things in an asset, one by one: our column of the table in
// files/gltf/asset/measurements.md.
#include <gmock/gmock.h>

#include <functional>
#include <string>
#include <vector>

#include "cli/planish_process.h"
#include "cli/test_files.h"
#include "files/gltf/asset_sample.h"

namespace planish::test {
namespace {

using nlohmann::json;

struct Check {
  std::string what, wanted;
  std::function<std::string()> made;
};

struct Glb {
  explicit Glb(std::string file) : bytes(std::move(file)), document(document_of(bytes)) {}

  // Of an accessor that lies in a view without gaps.
  [[nodiscard]] std::string bytes_of(const json& accessor) const {
    const json& view =
        document["bufferViews"][document["accessors"][accessor.get<std::size_t>()]["bufferView"]
                                    .get<std::size_t>()];
    return view_bytes(view);
  }
  [[nodiscard]] std::string view_bytes(const json& view) const {
    return bytes.substr(bytes.find("BIN\0", 0, 4) + 4 + view.value("byteOffset", std::size_t{0}),
                        view["byteLength"].get<std::size_t>());
  }
  [[nodiscard]] std::int64_t count_of(const json& accessor) const {
    return document["accessors"][accessor.get<std::size_t>()]["count"];
  }

  std::string bytes;
  json document;
};

TEST_F(FolderTest, AnAssetKeepsWhatItHas) {
  AssetSample sample;
  const std::string input = write("asset.glb", sample.glb());
  const ProcessResult result =
      run_planish({"fit", input, "-o", path("out.glb"), "--device", "cpu"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Glb from(read("asset.glb")), to(read("out.glb"));
  const json &given = from.document, &made = to.document;
  const auto same = [](bool is_same) { return std::string(is_same ? "=" : "changed"); };
  // Attributes of the first primitive of a mesh, one for each vertex of its surface.
  const auto carried = [&](std::size_t mesh, std::initializer_list<const char*> names) {
    const json& attributes = made["meshes"][mesh]["primitives"][0]["attributes"];
    const std::int64_t rows = to.count_of(attributes["POSITION"]);
    for (const char* name : names)
      if (!attributes.contains(name) || to.count_of(attributes[name]) != rows ||
          rows <= from.count_of(given["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"]))
        return std::string("not on the surface: ") + name;
    return std::string("on the surface");
  };
  const auto same_accessors = [&](const json& a, const json& b) {
    return from.bytes_of(a) == to.bytes_of(b);
  };
  const auto key_frames = [&] {
    bool is_same = made["animations"] == given["animations"];
    for (const json& sampler : given["animations"][0]["samplers"])
      for (const char* key : {"input", "output"})
        is_same = is_same && same_accessors(sampler[key], sampler[key]);
    return same(is_same);
  };
  const auto line = [&] {
    const json &a = given["meshes"][2]["primitives"][1], &b = made["meshes"][2]["primitives"][1];
    return same(a == b && same_accessors(a["attributes"]["POSITION"], b["attributes"]["POSITION"]));
  };
  const auto mesh_names = [&] {
    bool is_same = true;
    for (std::size_t m = 0; m < given["meshes"].size(); ++m)
      is_same = is_same && made["meshes"][m]["name"] == given["meshes"][m]["name"];
    return same(is_same);
  };
  const auto images = [&] {
    const auto bytes = [](const Glb& of) {
      return of.view_bytes(
          of.document["bufferViews"][of.document["images"][0]["bufferView"].get<std::size_t>()]);
    };
    return made["materials"] == given["materials"] && made["textures"] == given["textures"] &&
           bytes(from) == bytes(to);
  };
  const std::vector<Check> checks{
      {"copyright, asset.extras", "=",
       [&] {
         return same(made["asset"]["copyright"] == "me" &&
                     made["asset"]["extras"]["pipeline"] == 7);
       }},
      {"nodes, names, order", "=", [&] { return same(made["nodes"] == given["nodes"]); }},
      {"extras of nodes and primitives", "=",
       [&] {
         return same(made["nodes"][4]["extras"] == given["nodes"][4]["extras"] &&
                     made["meshes"][2]["primitives"][0]["extras"] ==
                         given["meshes"][2]["primitives"][0]["extras"]);
       }},
      {"materials, KHR_materials_clearcoat, image bytes", "=", [&] { return same(images()); }},
      {"samplers", "=", [&] { return same(made["samplers"] == given["samplers"]); }},
      {"an extension that nobody knows", "=",
       [&] {
         return same(made["extensions"]["VENDOR_secret"] == given["extensions"]["VENDOR_secret"]);
       }},
      {"TEXCOORD_0, TEXCOORD_1", "on the surface",
       [&] {
         return carried(0, {"TEXCOORD_0", "TEXCOORD_1"});
       }},
      {"COLOR_0, numbers of one's own", "on the surface",
       [&] {
         return carried(1, {"COLOR_0", "_HEAT"});
       }},
      {"skin: joints, inverse bind matrices", "=",
       [&] {
         const json &a = given["skins"], &b = made["skins"];
         return same(a == b &&
                     same_accessors(a[0]["inverseBindMatrices"], b[0]["inverseBindMatrices"]));
       }},
      {"JOINTS_0, WEIGHTS_0", "on the surface",
       [&] {
         return carried(0, {"JOINTS_0", "WEIGHTS_0"});
       }},
      {"morph targets, their names", "on the surface, with normals",
       [&] {
         const json& mesh = made["meshes"][0];
         const bool has_names = mesh["extras"] == given["meshes"][0]["extras"];
         const json& target = mesh["primitives"][0]["targets"][0];
         const bool is_carried =
             has_names && to.count_of(target["POSITION"]) ==
                              to.count_of(mesh["primitives"][0]["attributes"]["POSITION"]);
         return is_carried && target.contains("NORMAL")
                    ? std::string("on the surface, with normals")
                    : std::string("changed");
       }},
      {"animation: key frames", "=", key_frames},
      {"lights, instancing", "=",
       [&] {
         const json& places = given["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]
                                   ["attributes"]["TRANSLATION"];
         return same(made["extensions"]["KHR_lights_punctual"] ==
                         given["extensions"]["KHR_lights_punctual"] &&
                     made["nodes"][7] == given["nodes"][7] && same_accessors(places, places));
       }},
      {"line primitive", "=", line},
      {"names of meshes", "=", mesh_names},
  };
  for (const Check& check : checks) EXPECT_EQ(check.made(), check.wanted) << check.what;
}

}  // namespace
}  // namespace planish::test
