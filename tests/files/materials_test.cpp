#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiny_obj_loader.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "files/gltf/asset_sample.h"
#include "files/read_bytes.h"
#include "mesh/test_meshes.h"
#include "planish/core/platform/files.h"
#include "planish/files/formats.h"
#include "planish/files/materials.h"
#include "planish/files/mesh_file.h"
#include "planish/files/obj/material_library.h"
#include "planish/files/read_file.h"
#include "support/files.h"

namespace planish {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

PolygonMesh painted_cube() {
  PolygonMesh mesh = test::cube();
  mesh.groups = {{"lid", "red_wood"}, {"", "paint"}, {"walls", "tin"}, {"floor", "red_wood"}};
  mesh.face_groups = {0, 1, 2, 2, 3, 2};
  return mesh;
}

TEST(WriteMtl, AnotherReaderFindsNamesAndColours) {
  const test::TemporaryFolder folder;
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, painted_cube());
  tinyobj::ObjReader reader;
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;
  ASSERT_TRUE(reader.ParseFromFile((folder.path() / "a.obj").string(), config));
  EXPECT_TRUE(reader.Warning().empty()) << reader.Warning();
  std::vector<std::string> names;
  std::set<std::array<double, 3>> colors;
  for (const tinyobj::material_t& material : reader.GetMaterials()) {
    names.push_back(material.name);
    colors.insert({material.diffuse[0], material.diffuse[1], material.diffuse[2]});
    for (const double part : material.diffuse)
      EXPECT_THAT(part, testing::AllOf(testing::Ge(0.3), testing::Le(0.801)));
  }
  EXPECT_THAT(names, testing::ElementsAre("red_wood", "paint", "tin"));
  EXPECT_EQ(colors.size(), 3u);
}

TEST(WriteMtl, IsWrittenOnlyWhereThereAreMaterials) {
  const test::TemporaryFolder folder;
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, test::cube());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.mtl"));
  EXPECT_EQ(test::content_of(folder.path() / "a.obj").find("mtllib"), std::string::npos);
  write_mesh(folder.path() / "a.ply", FileFormat::Ply, painted_cube());
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.mtl"));
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, painted_cube());
  EXPECT_EQ(test::content_of(folder.path() / "a.mtl"),
            "newmtl red_wood\nKd 0.8 0.35 0.35\nnewmtl paint\nKd 0.35 0.48 0.8\nnewmtl tin\n"
            "Kd 0.61 0.8 0.35\n");
  EXPECT_TRUE(test::content_of(folder.path() / "a.obj").starts_with("mtllib a.mtl\n"));
}

TEST(WriteMtl, NamesAreThoseOfTheFaces) {
  const test::TemporaryFolder folder;
  PolygonMesh mesh = painted_cube();
  mesh.groups[0].material = "a #b\\";
  mesh.groups[3].material = "a _b_";
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, mesh);
  const std::string text = test::content_of(folder.path() / "a.mtl");
  EXPECT_THAT(text, HasSubstr("newmtl a _b_\n"));
  EXPECT_EQ(text.find("newmtl a _b_\n"), text.rfind("newmtl a _b_\n"));
  EXPECT_THAT(test::content_of(folder.path() / "a.obj"), HasSubstr("usemtl a _b_\n"));
}

// The OBJ's own name, too: its MTL gets one that a line can hold.
TEST(WriteMtl, IsFoundWhateverTheObjIsCalled) {
  for (const char* name : {"a\nb.obj", "a #b.obj", "\ta.obj", "a b.obj", "plain.obj"}) {
    if (!platform::objection_to_name(name).empty()) continue;
    const test::TemporaryFolder folder;
    const std::filesystem::path obj = folder.path() / name;
    write_mesh(obj, FileFormat::Obj, painted_cube());
    const MaterialLibrary library(obj);
    EXPECT_TRUE(library.warnings().empty()) << library.warnings()[0].message;
    EXPECT_EQ(library.names(), (std::vector<std::string>{"paint", "red_wood", "tin"})) << name;
    EXPECT_TRUE(std::filesystem::exists(companion_of(obj, FileFormat::Obj)));
  }
}

// As the specification has it, and as programs write it.
TEST(MaterialLibraries, ALineNamesOneWithBlanksOrSeveral) {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder.path() / name, std::ios::binary) << text;
  };
  write("a.mtl", "newmtl a\nKd 1 0 0\n");
  write("b.mtl", "newmtl b\nKd 0 1 0\n");
  const auto expect = [&](const std::string& line, const std::vector<std::string>& names,
                          const std::string& missing) {
    write("m.obj", line + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const MaterialLibrary library(folder.path() / "m.obj");
    EXPECT_EQ(library.names(), names);
    ASSERT_EQ(library.warnings().size(), missing.empty() ? 0U : 1U);
    if (!missing.empty()) {
      EXPECT_THAT(library.warnings()[0].message, HasSubstr(missing));
    }
  };
  expect("mtllib a.mtl b.mtl", {"a", "b"}, "");
  expect("mtllib a.mtl c.mtl", {"a"}, "c.mtl");
  expect("mtllib d.mtl e.mtl", {}, "d.mtl e.mtl");
  write("a.mtl b.mtl", "newmtl whole\nKd 0 0 1\n");
  expect("mtllib a.mtl b.mtl", {"whole"}, "");
}

// Line ends of Unicode, which Python's readers split at, and overrides of the direction.
TEST(WriteMtl, NamesEndNoLine) {
  const test::TemporaryFolder folder;
  PolygonMesh mesh = painted_cube();
  mesh.groups[0] = {"li\u2028d", "re\u2029d\u0085"};
  mesh.groups[1] = {"\u202etnorf", "pa\u2067int K\u00e4se"};
  mesh.groups[2] = {"a\nf 1 2 3", "#b #c\\"};
  write_mesh(folder.path() / "a.obj", FileFormat::Obj, mesh);
  EXPECT_THAT(
      test::content_of(folder.path() / "a.obj"),
      AllOf(HasSubstr("\ng li_d\n"), HasSubstr("\nusemtl re_d_\n"), HasSubstr("\ng _tnorf\n"),
            HasSubstr("\ng a_f 1 2 3\nusemtl _b _c_\n"), HasSubstr("\nusemtl pa_int K\u00e4se\n")));
  EXPECT_THAT(test::content_of(folder.path() / "a.mtl"),
              AllOf(HasSubstr("newmtl re_d_\n"), HasSubstr("newmtl pa_int K\u00e4se\n")));
}

// Materials of an OBJ in a glTF.

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
  ASSERT_THAT(test::codes_of(made.warnings), testing::ElementsAre("left-out-textures"));
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

// Materials of a glTF or an MTL in USD.

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
