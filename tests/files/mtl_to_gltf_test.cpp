// Materials of an OBJ in a glTF.
#include "planish/files/materials.h"

#include <gmock/gmock.h>

#include <fstream>

#include "files/gltf/asset_sample.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class MtlToGltf : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << text;
  }
  [[nodiscard]] GltfMaterials converted(const std::string& mtl) const {
    write("a.obj", "mtllib a.mtl\n");
    write("a.mtl", mtl);
    return materials_of(MaterialLibrary(folder_.path() / "a.obj"));
  }

  test::TemporaryFolder folder_;
};

TEST_F(MtlToGltf, FactorsAreThoseOfThePhysicalModel) {
  const GltfMaterials made = converted(
      "newmtl glass\nKd 0.2 0.4 0.9\nd 0.5\nKe 0 4 1\nNs 250\n"
      "newmtl metal\nKd 2 nan -1\nTr 0\nPr 0.3\nPm 1\nNs 250\nnewmtl bare\n");
  EXPECT_EQ(made.lists["materials"], nlohmann::json::parse(R"([
    {"name": "bare", "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.5}},
    {"name": "glass", "alphaMode": "BLEND", "emissiveFactor": [0.0, 1.0, 0.25],
     "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
     "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.9, 0.5], "metallicFactor": 0.0,
                              "roughnessFactor": 0.5}},
    {"name": "metal", "pbrMetallicRoughness": {"metallicFactor": 1.0, "roughnessFactor": 0.3}}])"));
  EXPECT_EQ(made.lists["extensionsUsed"],
            nlohmann::json::parse(R"(["KHR_materials_emissive_strength"])"));
  EXPECT_THAT(made.warnings, IsEmpty());
}

// u and v of the file are size * u + offset, v upwards.
TEST_F(MtlToGltf, TexturesComeWithTheirPlacesEachImageOnce) {
  write("a b.png", test::AssetSample::image());
  const GltfMaterials made = converted(
      "newmtl a\nKd 0 0 0\nmap_Kd -s 4 2 1 -o 0.5 0.25 -clamp on a b.png\n"
      "map_Bump -bm 0.5 a b.png\nnewmtl b\nmap_Ke .\\a b.png\nnorm a b.png\n");
  const nlohmann::json& a = made.lists["materials"][0];
  const nlohmann::json color = a["pbrMetallicRoughness"]["baseColorTexture"];
  EXPECT_FALSE(a["pbrMetallicRoughness"].contains("baseColorFactor")) << "white";
  EXPECT_EQ(color["extensions"]["KHR_texture_transform"],
            nlohmann::json::parse(R"({"scale": [4.0, 2.0], "offset": [0.5, -1.25]})"));
  const nlohmann::json texture = made.lists["textures"][color["index"].get<std::size_t>()];
  EXPECT_EQ(made.lists["samplers"][texture["sampler"].get<std::size_t>()]["wrapS"], 33071);
  EXPECT_EQ(a["normalTexture"]["scale"], 0.5);
  const nlohmann::json& b = made.lists["materials"][1];
  EXPECT_EQ(b["emissiveFactor"], nlohmann::json::parse("[1.0, 1.0, 1.0]"));
  EXPECT_EQ(b["normalTexture"]["index"], b["emissiveTexture"]["index"]);
  ASSERT_EQ(made.images.size(), 1U);
  EXPECT_EQ(made.images[0].bytes.size(), test::AssetSample::image().size());
  EXPECT_EQ(made.image_name(0), "0.png");
}

TEST_F(MtlToGltf, WhatGltfCannotHoldIsSaid) {
  write("a.tga", "not a PNG");
  const GltfMaterials made = converted("newmtl a\nmap_Kd a.tga\nmap_Ke gone.png\nmap_d\n");
  EXPECT_FALSE(made.lists.contains("textures"));
  EXPECT_THAT(made.images, IsEmpty());
  ASSERT_EQ(made.warnings.size(), 1U);
  EXPECT_EQ(made.warnings[0].code, "left-out-textures");
  EXPECT_EQ(made.warnings[0].count, 2);
  EXPECT_THAT(made.warnings[0].message, HasSubstr("a.tga"));
}

TEST_F(MtlToGltf, NamesTexturesThatHaveNoPlace) {
  const GltfMaterials made =
      converted("newmtl a\nmap_d a.png\nmap_Ks a.png\nmap_Pr a.png\nmap_d b.png\n");
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_EQ(made.warnings[0].code, "left-out-textures");
  EXPECT_THAT(made.warnings[0].message, HasSubstr("map_d, map_ks, map_pr;"));
}

// And back: numbers and places are the same.
TEST_F(MtlToGltf, AnObjHasTheMaterialsOfAGltf) {
  write("a b.png", test::AssetSample::image());
  const GltfMaterials given = converted(
      "newmtl glass\nKd 0.2 0.4 0.9\nd 0.5\nKe 0 4 1\nPr 0.25\nPm 1\nnewmtl wood\nPr 0.5\n"
      "map_Kd -s 4 2 1 -o 0.5 0.25 -clamp on a b.png\nnorm -bm 0.5 a b.png\n");
  const MaterialLibrary library = library_of(given);
  EXPECT_EQ(library.statements("glass", folder_.path()),
            "Kd 0.2 0.4 0.9\nd 0.5\nPr 0.25\nPm 1\nKe 0 4 1\n");
  EXPECT_EQ(library.statements("wood", folder_.path()),
            "Kd 1 1 1\nPr 0.5\nPm 0\nmap_Kd -s 4 2 1 -o 0.5 0.25 0 -clamp on a b.png\n"
            "norm -bm 0.5 a b.png\n");
  EXPECT_THAT(library.warnings(), IsEmpty());
  const GltfMaterials again =
      converted("newmtl glass\n" + library.statements("glass", folder_.path()) + "newmtl wood\n" +
                library.statements("wood", folder_.path()));
  EXPECT_EQ(again.lists, given.lists);
}

TEST_F(MtlToGltf, SaysWhatAnObjHasNoWordFor) {
  GltfMaterials given;
  given.lists = nlohmann::json::parse(R"({"materials": [{"name": "a", "alphaMode": "MASK",
      "occlusionTexture": {"index": 0}, "extensions": {"KHR_materials_clearcoat": {}},
      "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    "textures": [{"source": 0}], "images": [{"name": "inside"}]})");
  given.images = {{.type = "image/png", .bytes = {}}};
  const MaterialLibrary library = library_of(given);
  EXPECT_EQ(library.statements("a", {}), "Kd 1 1 1\nPr 1\nPm 1\n");
  ASSERT_EQ(library.warnings().size(), 2u);
  EXPECT_THAT(library.warnings()[0].message, HasSubstr("textures are left out: inside;"));
  EXPECT_THAT(library.warnings()[1].message,
              HasSubstr("KHR_materials_clearcoat, alphaMode MASK, occlusionTexture"));
}

}  // namespace
}  // namespace planish
