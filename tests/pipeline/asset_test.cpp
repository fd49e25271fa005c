// A glTF that becomes a glTF: everything that is no triangle passes, and what rides on triangles is
// the surface's own.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "pipeline/asset_fixture.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

TEST_F(Asset, EverythingThatIsNoTriangleStaysAsItIs) {
  const tinygltf::Model model = fitted(sample_.glb());
  const json made = written_json(), given = sample_.json;
  for (const auto& [key, value] : given.items()) {
    if (key == "accessors" || key == "bufferViews" || key == "buffers" || key == "meshes" ||
        key == "asset" || key == "images")
      continue;
    EXPECT_EQ(made[key], value) << key;
  }
  EXPECT_EQ(made["asset"]["copyright"], "me");
  EXPECT_EQ(made["asset"]["extras"]["pipeline"], 7);
  EXPECT_THAT(made["asset"]["generator"].get<std::string>(), HasSubstr("planish "));
  // The image, the animation and the places of instances, byte by byte.
  ASSERT_EQ(model.images.size(), 1U);
  const tinygltf::BufferView& image =
      model.bufferViews.at(static_cast<std::size_t>(model.images[0].bufferView));
  EXPECT_EQ(
      std::string(reinterpret_cast<const char*>(model.buffers[0].data.data()) + image.byteOffset,
                  image.byteLength),
      AssetSample::image());
  EXPECT_EQ(made["images"][0]["name"], "checker");
  EXPECT_THAT(numbers_of(model, model.animations.at(0).samplers.at(0).output),
              ElementsAre(0, 0, 0, 1, 0, 0, 0.6F, 0.8F, 0, 0, 0, 1));
  EXPECT_THAT(
      numbers_of(
          model,
          made["nodes"][7]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"]
              .get<int>()),
      ElementsAre(0, 0, 0, 3, 0, 0, 6, 0, 0));
  EXPECT_EQ(numbers_of(model, model.skins.at(0).inverseBindMatrices).at(29), -2);
}

TEST_F(Asset, PrimitivesKeepWhatIsNoVertex) {
  const tinygltf::Model model = fitted(sample_.glb());
  const json meshes = written_json()["meshes"];
  EXPECT_EQ(meshes[0]["name"], "tube");
  EXPECT_EQ(meshes[0]["extras"]["targetNames"], json::array({"fat"}));
  ASSERT_EQ(meshes[0]["primitives"].size(), 2U);
  EXPECT_EQ(meshes[0]["primitives"][0]["material"], 0);
  EXPECT_EQ(meshes[0]["primitives"][1]["material"], 1);
  EXPECT_EQ(meshes[2]["primitives"][0]["extras"]["id"], 4);
  // A line is no surface.
  ASSERT_EQ(meshes[2]["primitives"].size(), 2U);
  EXPECT_EQ(meshes[2]["primitives"][1]["mode"], 1);
  EXPECT_EQ(points_of(model, model.meshes[2].primitives[1].attributes.at("POSITION")),
            (std::vector<glm::dvec3>{{0, 0, 0}, {1, 1, 1}}));
  EXPECT_EQ(result_.further.size(), 2U);
}

// Of the material with a normal texture alone, around the tube as its u; where the texture is
// mirrored the other way. A reader's own, MikkTSpace's, are compared by
// files.gltf_khronos_validator.
TEST_F(Asset, TangentsFollowTheNormalTexture) {
  for (const bool is_mirrored : {false, true}) {
    if (is_mirrored) sample_.mirror_texture();
    const tinygltf::Model model = fitted(sample_.glb(), progressive());
    EXPECT_FALSE(model.meshes[0].primitives[1].attributes.contains("TANGENT"));
    const auto& attributes = model.meshes[0].primitives[0].attributes;
    const auto points = points_of(model, attributes.at("POSITION"));
    const auto normals = points_of(model, attributes.at("NORMAL"));
    const auto tangents = numbers_of(model, attributes.at("TANGENT"));
    ASSERT_EQ(tangents.size(), 4 * points.size());
    int turned = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const glm::dvec3 tangent(tangents[4 * i], tangents[4 * i + 1], tangents[4 * i + 2]);
      EXPECT_NEAR(glm::length(tangent), 1, 1e-6);
      EXPECT_NEAR(glm::dot(tangent, normals[i]), 0, 1e-6);
      const glm::dvec3 around = glm::normalize(glm::dvec3(-points[i].z, 0, points[i].x));
      const double along = glm::dot(tangent, around);
      EXPECT_GT(std::abs(along), 0.97);
      turned += along < 0 ? 1 : 0;
      // u runs against the clock seen from above, v up: from outside to the left.
      EXPECT_EQ(tangents[4 * i + 3], along < 0 ? -1 : 1);
    }
    EXPECT_EQ(turned > 0, is_mirrored);
    EXPECT_LT(turned, std::ssize(points));
  }
}

// Two primitives of one mesh that touch are one surface: where they meet positions and normals are
// equal, and the rim there is no boundary.
TEST_F(Asset, MaterialsShareOneSurface) {
  const tinygltf::Model model = fitted(sample_.glb(), progressive());
  std::map<std::array<double, 3>, glm::dvec3> normals;
  int shared = 0;
  for (const tinygltf::Primitive& part : model.meshes[0].primitives) {
    const auto positions = points_of(model, part.attributes.at("POSITION"));
    const auto of = points_of(model, part.attributes.at("NORMAL"));
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (std::abs(positions[i].y - 2) > 1e-6) continue;
      const auto [known, is_new] =
          normals.try_emplace({positions[i].x, positions[i].y, positions[i].z}, of[i]);
      if (!is_new) {
        EXPECT_EQ(known->second, of[i]);
      }
      shared += is_new ? 0 : 1;
    }
  }
  EXPECT_GE(shared, 4 * AssetSample::kAround);
}

TEST_F(Asset, EverySetOfTextureCoordinatesIsCarried) {
  const tinygltf::Model model = fitted(sample_.glb(), progressive());
  for (const tinygltf::Primitive& part : model.meshes[0].primitives) {
    const auto first = numbers_of(model, part.attributes.at("TEXCOORD_0"));
    const auto second = numbers_of(model, part.attributes.at("TEXCOORD_1"));
    ASSERT_EQ(first.size(), second.size());
    for (std::size_t i = 0; i < first.size(); i += 2) {
      EXPECT_NEAR(second[i], 0.5 * first[i], 1e-6);
      EXPECT_NEAR(second[i + 1], 0.25 + 0.5 * first[i + 1], 1e-6);
    }
  }
  const tinygltf::Primitive& ball = model.meshes[1].primitives[0];
  EXPECT_FALSE(ball.attributes.contains("TEXCOORD_0"));
  const auto heights = points_of(model, ball.attributes.at("POSITION"));
  const auto heat = numbers_of(model, ball.attributes.at("_HEAT"));
  const auto colors = numbers_of(model, ball.attributes.at("COLOR_0"));
  ASSERT_EQ(heat.size(), heights.size());
  // Both were given linear in the height: they are so at the 86 vertices, and nearly so between.
  int given = 0;
  for (std::size_t i = 0; i < heat.size(); ++i) {
    EXPECT_NEAR(colors[4 * i + 2], 0.5 - 0.5 * heights[i].y, 0.05);
    EXPECT_NEAR(heat[i], 10 * heights[i].y, 0.6);
    given += std::abs(colors[4 * i + 2] - (0.5 - 0.5 * heights[i].y)) < 1e-5 ? 1 : 0;
  }
  EXPECT_GE(given, 86);
}

TEST_F(Asset, FilesBesideComeAlong) {
  write("buffer.bin", sample_.bytes);
  write("picture.png", AssetSample::image());
  const fs::path input = write("in.gltf", sample_.gltf("buffer.bin", "picture.png"));
  // In the same folder the image stays where it is.
  (void)fit_file(input, folder_ / "out.gltf");
  json made = json::parse(read("out.gltf"));
  EXPECT_EQ(made["images"][0]["uri"], "picture.png");
  EXPECT_EQ(made["buffers"][0]["uri"], "out.bin");
  EXPECT_EQ(made["buffers"][0]["byteLength"], read("out.bin").size());
  // A GLB takes it in.
  (void)fit_file(input, folder_ / "out.glb");
  made = written_json();
  EXPECT_EQ(made["images"][0]["mimeType"], "image/png");
  EXPECT_EQ(made["images"][0]["name"], "picture.png");
  EXPECT_THAT(read("out.glb"), HasSubstr(AssetSample::image()));
  EXPECT_FALSE(made["images"][0].contains("uri"));
  // So it does with one that stands in the document.
  const std::string data = "data:image/png,%89PNG";
  (void)fit_file(write("in.gltf", sample_.gltf("buffer.bin", data)), folder_ / "out.glb");
  made = written_json();
  EXPECT_EQ(made["images"][0]["mimeType"], "image/png");
  EXPECT_FALSE(made["images"][0].contains("name"));
  EXPECT_FALSE(made["images"][0].contains("uri"));
}

// Nobody can show one that is missing: in its place is a pixel that changes nothing, so that what
// names images, textures and materials by number stays as it is.
TEST_F(Asset, AMissingImageIsAWarning) {
  write("parts.bin", sample_.bytes);
  FitFileOptions options;
  std::vector<Warning> warnings;
  options.callbacks.warning = [&](const Warning& one) { warnings.push_back(one); };
  const auto pixel_of = [&](const std::string& output) {
    warnings.clear();
    (void)fit_file(write("in.gltf", sample_.gltf("parts.bin", "gone.png")), folder_ / output,
                   options);
    const bool is_glb = output.ends_with(".glb");
    const json made = is_glb ? written_json() : json::parse(read(output));
    EXPECT_EQ(made["materials"].size(), sample_.json["materials"].size());
    EXPECT_EQ(made["textures"], sample_.json["textures"]);
    const json& image = made["images"][0];
    EXPECT_EQ(image["name"], "gone.png");
    EXPECT_EQ(image["mimeType"], "image/png");
    EXPECT_FALSE(image.contains("uri"));
    const json& view = made["bufferViews"][image["bufferView"].get<std::size_t>()];
    const std::string bytes = read(is_glb ? output : "out.bin");
    const std::size_t begin = is_glb ? bytes.find("BIN\0", 0, 4) + 4 : 0;
    return bytes.substr(begin + view.value("byteOffset", std::size_t{0}),
                        view["byteLength"].get<std::size_t>());
  };
  for (const char* output : {"out.glb", "out.gltf"}) {
    const std::string flat = pixel_of(output);
    EXPECT_TRUE(flat.starts_with("\x89PNG"));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].code, "missing-images");
    EXPECT_THAT(warnings[0].message, HasSubstr("gone.png: cannot read: No such file"));
    // The sample's is a texture of normals, too.
    sample_.json["materials"][0].erase("normalTexture");
    EXPECT_NE(pixel_of(output), flat);
    sample_.json["materials"][0]["normalTexture"] = {{"index", 0}};
  }
}

TEST_F(Asset, MergedTheSceneIsOneMesh) {
  FitFileOptions options;
  options.settings.asset = AssetChoice::Merge;
  // Whose instances nobody reads.
  sample_.json["nodes"].erase(7);
  sample_.json["scenes"][0]["nodes"] = {0, 3, 4, 5, 6, 7};
  (void)fit_file(write("in.glb", sample_.glb()), folder_ / "out.glb", options);
  const json made = written_json();
  EXPECT_EQ(made["meshes"].size(), 1U);
  EXPECT_FALSE(made.contains("skins"));
}

}  // namespace
}  // namespace planish::test
