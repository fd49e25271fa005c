// A glTF that becomes a glTF: everything that is no triangle passes, and what rides on triangles is
// the surface's own. The reader of the output is tinygltf.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>

#include "files/gltf/asset_sample.h"
#include "files/gltf/parsed_gltf.h"
#include "planish/files/gltf/read_gltf.h"
#include "planish/pipeline/fit_file.h"
#include "planish/pipeline/settings.h"
#include "support/expect_error.h"
#include "support/temporary_folder.h"

namespace planish {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::AssetSample;
using testing::ElementsAre;
using testing::HasSubstr;

// Numbers of an accessor, one after another.
std::vector<double> numbers_of(const tinygltf::Model& model, int accessor) {
  const tinygltf::Accessor& of = model.accessors.at(static_cast<std::size_t>(accessor));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(of.bufferView));
  const auto width = static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(of.type)));
  const auto size = static_cast<std::size_t>(
      tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(of.componentType)));
  const std::size_t stride = view.byteStride > 0 ? view.byteStride : width * size;
  std::vector<double> numbers;
  for (std::size_t i = 0; i < of.count; ++i) {
    for (std::size_t k = 0; k < width; ++k) {
      const unsigned char* at =
          model.buffers.at(0).data.data() + view.byteOffset + of.byteOffset + i * stride + k * size;
      if (of.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) {
        float value = 0;
        std::memcpy(&value, at, size);
        numbers.push_back(value);
      } else {
        std::uint16_t value = 0;
        std::memcpy(&value, at, size);
        numbers.push_back(value);
      }
    }
  }
  return numbers;
}

std::vector<glm::dvec3> points_of(const tinygltf::Model& model, int accessor) {
  const std::vector<double> numbers = numbers_of(model, accessor);
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    points.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return points;
}

class Asset : public testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  tinygltf::Model fitted(const std::string& glb, const FitFileOptions& options = {}) {
    result_ = fit_file(write("in.glb", glb), folder_ / "out.glb", options);
    const std::string bytes = read("out.glb");
    const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
    return test::parsed({begin, begin + bytes.size()});
  }
  json written_json() const {
    const std::string bytes = read("out.glb");
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + 12, sizeof(length));
    return json::parse(bytes.substr(20, length));
  }
  static FitFileOptions progressive() {
    FitFileOptions options;
    options.mesh.method = InterpolationMethod::Progressive;
    options.mesh.quads = QuadChoice::Off;
    options.mesh.chooses_creases = false;
    return options;
  }

  test::TemporaryFolder temporary_;
  const fs::path& folder_ = temporary_.path();
  AssetSample sample_;
  FileFit result_;
};

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
      if (!is_new) EXPECT_EQ(known->second, of[i]);
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
      EXPECT_NEAR(second[i + 1], 0.25, 1e-6);
    }
  }
  const tinygltf::Primitive& ball = model.meshes[1].primitives[0];
  EXPECT_FALSE(ball.attributes.contains("TEXCOORD_0"));
  const auto heights = points_of(model, ball.attributes.at("POSITION"));
  const auto heat = numbers_of(model, ball.attributes.at("_HEAT"));
  const auto colors = numbers_of(model, ball.attributes.at("COLOR_0"));
  ASSERT_EQ(heat.size(), heights.size());
  // Both were given linear in the height, and are linear between vertices.
  for (std::size_t i = 0; i < heat.size(); ++i)
    EXPECT_NEAR(colors[4 * i + 2], 0.5 - 0.05 * heat[i], 1e-5);
}

// With the progressive method the surface is linear in the given points: a morphed surface is the
// surface through the morphed points.
TEST_F(Asset, MorphTargetsAreExact) {
  const tinygltf::Model model = fitted(sample_.glb(), progressive());
  AssetSample posed = sample_;
  // The same file whose rest pose is the morphed one.
  posed.move_tube([&](std::size_t v, std::size_t k) { return posed.moves[v][k]; });
  const tinygltf::Model wanted = fitted(posed.glb(), progressive());
  for (int p = 0; p < 2; ++p) {
    const tinygltf::Primitive &rest = model.meshes[0].primitives[p],
                              &there = wanted.meshes[0].primitives[p];
    const auto from = points_of(model, rest.attributes.at("POSITION"));
    const auto by = points_of(model, rest.targets.at(0).at("POSITION"));
    const auto to = points_of(wanted, there.attributes.at("POSITION"));
    const auto from_normals = points_of(model, rest.attributes.at("NORMAL"));
    const auto by_normals = points_of(model, rest.targets.at(0).at("NORMAL"));
    const auto to_normals = points_of(wanted, there.attributes.at("NORMAL"));
    ASSERT_EQ(from.size(), to.size());
    double moved_by = 0;
    for (std::size_t i = 0; i < to.size(); ++i) {
      EXPECT_LE(glm::length(from[i] + by[i] - to[i]), 2e-6);
      EXPECT_LE(glm::length(from_normals[i] + by_normals[i] - to_normals[i]), 2e-5);
      moved_by = std::max(moved_by, glm::length(by[i]));
    }
    EXPECT_GT(moved_by, 0.3);
  }
}

// With the fair method targets move the rest pose's surface by the linear map: through every moved
// point, and elsewhere near the surface that would be fitted to them.
TEST_F(Asset, MorphedFairSurfacesPassThroughTheMovedPoints) {
  FitFileOptions fair = progressive();
  fair.mesh.method = InterpolationMethod::Fair;
  const tinygltf::Model model = fitted(sample_.glb(), fair);
  AssetSample posed = sample_;
  posed.move_tube([&](std::size_t v, std::size_t k) { return posed.moves[v][k]; });
  const tinygltf::Model wanted = fitted(posed.glb(), fair);
  const double diagonal = result_.fitted.fit.placement.diagonal;
  std::map<std::array<float, 3>, bool> is_met;
  for (std::size_t v = 0; v < posed.tube.size(); ++v) is_met[posed.stored(v)] = false;
  double farthest = 0;
  for (int p = 0; p < 2; ++p) {
    const tinygltf::Primitive& rest = model.meshes[0].primitives[p];
    const auto from = points_of(model, rest.attributes.at("POSITION"));
    const auto by = points_of(model, rest.targets.at(0).at("POSITION"));
    const auto to = points_of(wanted, wanted.meshes[0].primitives[p].attributes.at("POSITION"));
    ASSERT_EQ(from.size(), to.size());
    for (std::size_t i = 0; i < to.size(); ++i) {
      farthest = std::max(farthest, glm::length(from[i] + by[i] - to[i]) / diagonal);
      for (auto& [point, met] : is_met)
        met =
            met || glm::length(from[i] + by[i] - glm::dvec3(point[0], point[1], point[2])) <= 2e-6;
    }
  }
  for (const auto& [point, met] : is_met) EXPECT_TRUE(met) << point[0] << " " << point[1];
  EXPECT_LE(farthest, 0.01);
}

// Joints that only shift are linear too: the skinned surface is the surface through the skinned
// points. Weights sum to 1 and no vertex names a joint twice.
TEST_F(Asset, JointsShiftTheSurfaceAsTheyShiftThePoints) {
  const tinygltf::Model model = fitted(sample_.glb(), progressive());
  constexpr double kShift = 3.0;
  AssetSample posed = sample_;
  posed.move_tube(
      [&](std::size_t v, std::size_t k) { return k == 0 ? kShift * posed.weights[v][1] : 0.0; });
  const tinygltf::Model wanted = fitted(posed.glb(), progressive());
  for (int p = 0; p < 2; ++p) {
    const tinygltf::Primitive& rest = model.meshes[0].primitives[p];
    const auto from = points_of(model, rest.attributes.at("POSITION"));
    const auto to = points_of(wanted, wanted.meshes[0].primitives[p].attributes.at("POSITION"));
    const auto joints = numbers_of(model, rest.attributes.at("JOINTS_0"));
    const auto weights = numbers_of(model, rest.attributes.at("WEIGHTS_0"));
    ASSERT_EQ(from.size(), to.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
      double second = 0, sum = 0;
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
        sum += weights[k];
        if (joints[k] == 1 && weights[k] > 0) second = weights[k];
      }
      EXPECT_NEAR(sum, 1, 1e-6);
      // Weights that would be below 0 are left out, by less than a hundredth.
      EXPECT_NEAR(from[i].x + kShift * second, to[i].x, 0.02) << i;
    }
  }
}

// Joints that turn are not linear: a point of the surface has one product of weights and places, a
// fitted pose another. They are near each other.
TEST_F(Asset, JointsThatTurnComeNearTheFittedPose) {
  const tinygltf::Model model = fitted(sample_.glb(), progressive());
  const double angle = 0.6;
  const auto posed_by = [&](const glm::dvec3& at, double second) {
    const double x = at.x, y = at.y - 2;
    const glm::dvec3 turned(std::cos(angle) * x - std::sin(angle) * y,
                            2 + std::sin(angle) * x + std::cos(angle) * y, at.z);
    return glm::mix(at, turned, second);
  };
  AssetSample posed = sample_;
  posed.move_tube([&](std::size_t v, std::size_t k) {
    const auto& at = posed.tube[v];
    const auto axis = static_cast<int>(k);
    return posed_by({at[0], at[1], at[2]}, posed.weights[v][1])[axis] - at[k];
  });
  const tinygltf::Model wanted = fitted(posed.glb(), progressive());
  double farthest = 0;
  for (int p = 0; p < 2; ++p) {
    const tinygltf::Primitive& rest = model.meshes[0].primitives[p];
    const auto from = points_of(model, rest.attributes.at("POSITION"));
    const auto to = points_of(wanted, wanted.meshes[0].primitives[p].attributes.at("POSITION"));
    const auto joints = numbers_of(model, rest.attributes.at("JOINTS_0"));
    const auto weights = numbers_of(model, rest.attributes.at("WEIGHTS_0"));
    for (std::size_t i = 0; i < from.size(); ++i) {
      double second = 0;
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
        if (joints[k] == 1 && weights[k] > 0) second = weights[k];
      farthest = std::max(farthest, glm::length(posed_by(from[i], second) - to[i]));
    }
  }
  const double off = farthest / result_.fitted.fit.placement.diagonal;
  EXPECT_LE(off, 2e-3) << off;
}

// Points at one place that joints or targets move apart, as lips do, are two.
TEST_F(Asset, WhatMovesApartIsNotWelded) {
  AssetSample apart = sample_;
  apart.json["meshes"].erase(2);
  apart.json["nodes"].erase(7);
  apart.json["scenes"][0]["nodes"] = {0, 3, 4, 5, 6, 7};
  const tinygltf::Model together = fitted(apart.glb(), progressive());
  const std::int64_t before = result_.fitted.mesh.vertex_count();
  // The seam of the tube: its last column morphs away.
  const json target = apart.json["meshes"][0]["primitives"][0]["targets"][0];
  const json accessor = apart.json["accessors"][target["POSITION"].get<int>()];
  const std::size_t at =
      apart.json["bufferViews"][accessor["bufferView"].get<int>()]["byteOffset"].get<std::size_t>();
  for (int j = 0; j <= AssetSample::kRings; ++j) {
    const float away = 1;
    const std::size_t v =
        static_cast<std::size_t>(j * (AssetSample::kAround + 1) + AssetSample::kAround);
    std::memcpy(apart.bytes.data() + at + 12 * v + 8, &away, 4);
  }
  (void)fitted(apart.glb(), progressive());
  EXPECT_EQ(result_.fitted.mesh.vertex_count(), before + AssetSample::kRings + 1);
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
  // One that is missing is an error, before anything is written.
  fs::remove(folder_ / "picture.png");
  fs::remove(folder_ / "out.glb");
  EXPECT_THAT(test::message_of(ErrorCode::UnreadableInput,
                               [&] { (void)fit_file(input, folder_ / "out.glb"); }),
              HasSubstr("in.gltf: images[0].uri: "));
  EXPECT_FALSE(fs::exists(folder_ / "out.glb"));
}

TEST_F(Asset, MergedTheSceneIsOneMesh) {
  FitFileOptions options;
  options.keeps_asset = false;
  // Whose instances nobody reads.
  sample_.json["nodes"].erase(7);
  sample_.json["scenes"][0]["nodes"] = {0, 3, 4, 5, 6, 7};
  (void)fit_file(write("in.glb", sample_.glb()), folder_ / "out.glb", options);
  const json made = written_json();
  EXPECT_EQ(made["meshes"].size(), 1U);
  EXPECT_FALSE(made.contains("skins"));
}

// Whatever names what is not there is said with its place, and nothing is written.
TEST_F(Asset, BrokenAssetsAreRefused) {
  const auto refusal = [&](const std::function<void(json&)>& change) {
    AssetSample broken;
    change(broken.json);
    const fs::path input = write("in.glb", broken.glb());
    fs::remove(folder_ / "out.glb");
    const std::string message = test::message_of(
        ErrorCode::UnreadableInput, [&] { (void)fit_file(input, folder_ / "out.glb"); });
    EXPECT_FALSE(fs::exists(folder_ / "out.glb"));
    return message;
  };
  EXPECT_THAT(refusal([](json& all) {
                all["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 3;
              }),
              HasSubstr("materials[0].pbrMetallicRoughness.baseColorTexture.index: names "
                        "textures[3], and the file has 1"));
  EXPECT_THAT(refusal([](json& all) { all["textures"][0]["source"] = 9; }),
              HasSubstr("textures[0].source: names images[9]"));
  EXPECT_THAT(refusal([](json& all) {
                all["bufferViews"][all["images"][0]["bufferView"].get<int>()]["byteLength"] = 1
                                                                                              << 30;
              }),
              HasSubstr("are asked of a buffer of"));
  EXPECT_THAT(refusal([](json& all) { all["skins"][0]["joints"] = json::array(); }),
              HasSubstr("skins[0].joints: a skin needs a joint"));
  EXPECT_THAT(
      refusal([](json& all) { all["meshes"][0]["primitives"][1]["targets"] = json::array(); }),
      HasSubstr("0 morph targets, and another primitive of the mesh has 1"));
  EXPECT_THAT(refusal([](json& all) { all["nodes"][2]["children"] = {1}; }),
              HasSubstr("nodes must form trees"));
  EXPECT_THAT(refusal([](json& all) {
                all["nodes"][3]["children"] = {1, 2};
              }),
              HasSubstr("is a child of node"));
  EXPECT_THAT(refusal([](json& all) { all["animations"][0]["channels"][0]["sampler"] = 7; }),
              HasSubstr("animations[0].channels[0].sampler"));
  EXPECT_THAT(refusal([](json& all) { all["nodes"][0]["skin"] = 4; }),
              HasSubstr("nodes[0].skin: names skins[4]"));
  EXPECT_THAT(refusal([](json& all) {
                all["extensionsUsed"] = {1, 2};
              }),
              HasSubstr("in.glb: a value is not of the kind that glTF has there"));
  EXPECT_THAT(refusal([](json& all) { all["extensionsRequired"] = {"VENDOR_secret"}; }),
              HasSubstr("VENDOR_secret"));
}

}  // namespace
}  // namespace planish
