// Materials of a glTF or an MTL in USD.
#include "planish/files/materials.h"

#include <gmock/gmock.h>

namespace planish {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

GltfMaterials materials(const std::string& lists) {
  GltfMaterials made;
  made.lists = nlohmann::json::parse(lists);
  return made;
}

UsdMaterials converted(const GltfMaterials& given, const std::vector<std::string>& names) {
  return usd_materials(given, names, "/out");
}

TEST(UsdMaterials, FactorsBecomeInputs) {
  const GltfMaterials given = materials(R"({"materials": [
    {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0.25, 0.5],
     "metallicFactor": 0.5, "roughnessFactor": 0.75}, "alphaMode": "BLEND",
     "emissiveFactor": [0, 0.5, 1],
     "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4}}},
    {"name": "leaf", "alphaMode": "MASK", "alphaCutoff": 0.25}, {"name": "unused"}]})");
  const UsdMaterials made = converted(given, {"red", "leaf", "unknown"});
  EXPECT_EQ(made.paths, (std::map<std::string, std::string>{{"red", "/surface/materials/red"},
                                                            {"leaf", "/surface/materials/leaf"}}));
  EXPECT_THAT(
      made.text,
      AllOf(HasSubstr("color3f inputs:diffuseColor = (1, 0, 0.25)\n"),
            HasSubstr("float inputs:opacity = 0.5\n"), HasSubstr("float inputs:metallic = 0.5\n"),
            HasSubstr("float inputs:roughness = 0.75\n"),
            HasSubstr("color3f inputs:emissiveColor = (0, 2, 4)\n"),
            HasSubstr("float inputs:opacityThreshold = 0.25\n"), Not(HasSubstr("unused"))));
  EXPECT_THAT(made.warnings, IsEmpty());
}

TEST(UsdMaterials, NamesAreValidAndTheirOwn) {
  const GltfMaterials given =
      materials(R"({"materials": [{"name": "a b"}, {"name": "a\nb"}, {"name": "7\"{"}]})");
  const UsdMaterials made = converted(given, {"a b", "a\nb", "7\"{"});
  EXPECT_EQ(made.paths.at("a b"), "/surface/materials/a_b");
  EXPECT_EQ(made.paths.at("a\nb"), "/surface/materials/a_b_1");
  EXPECT_EQ(made.paths.at("7\"{"), "/surface/materials/_7__");
}

// v of glTF runs down, that of USD up: a point (s, t) is sampled at the same place of the image.
TEST(UsdMaterials, TexturesNameTheirFilesFromTheOutput) {
  GltfMaterials given = materials(R"({"materials": [{"name": "m", "alphaMode": "BLEND",
    "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {
      "KHR_texture_transform": {"scale": [4, 2], "offset": [0.5, -1.25]}}}},
    "normalTexture": {"index": 1, "scale": 0.5}, "emissiveTexture": {"index": 2},
    "occlusionTexture": {"index": 9}}],
    "textures": [{"source": 0, "sampler": 0}, {"source": 1}, {"source": 2}],
    "samplers": [{"wrapS": 33071}], "images": [{}, {}, {"name": "glow"}]})");
  given.images = {{"image/png", {}, "/out/sub/a@b.png"},
                  {"image/jpeg", {}, "/in/n.jpg"},
                  {"image/png", {}, {}}};
  const UsdMaterials made = converted(given, {"m"});
  EXPECT_THAT(
      made.text,
      AllOf(HasSubstr("asset inputs:file = @@@./sub/a@b.png@@@\n"),
            HasSubstr("asset inputs:file = @../in/n.jpg@\n"),
            HasSubstr("inputs:diffuseColor.connect = </surface/materials/m/baseColor.outputs:rgb>"),
            HasSubstr("inputs:opacity.connect = </surface/materials/m/baseColor.outputs:a>"),
            HasSubstr("token inputs:wrapS = \"clamp\"\n"),
            HasSubstr("token inputs:wrapT = \"repeat\"\n"),
            HasSubstr("float2 inputs:scale = (4, 2)\n"),
            HasSubstr("float2 inputs:translation = (0.5, 0.25)\n"),
            HasSubstr("float4 inputs:scale = (1, 1, 2, 1)\n"),
            HasSubstr("float4 inputs:bias = (-0.5, -0.5, -1, 0)\n"), Not(HasSubstr("emissive"))));
  ASSERT_EQ(made.warnings.size(), 1u);
  EXPECT_EQ(made.warnings[0].code, "left-out-textures");
  EXPECT_THAT(made.warnings[0].message, HasSubstr("glow"));
}

// What is not as glTF has it is as if it were not there.
TEST(UsdMaterials, OddValuesAreNone) {
  const GltfMaterials given = materials(R"({"materials": [{"name": "m", "alphaMode": 3,
    "pbrMetallicRoughness": {"baseColorFactor": "red", "metallicFactor": [],
    "baseColorTexture": {"index": -1}}, "emissiveFactor": [1], "normalTexture": 7,
    "extensions": 5}], "textures": 4})");
  EXPECT_THAT(converted(given, {"m"}).text,
              AllOf(HasSubstr("diffuseColor = (1, 1, 1)"), HasSubstr("metallic = 1\n")));
  EXPECT_THAT(converted({}, {"m"}).text, IsEmpty());
}

}  // namespace
}  // namespace planish
