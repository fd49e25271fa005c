#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>

#include "pipeline/asset_fixture.h"
#include "planish/adaptive/adaptive_blocks.h"
#include "planish/adaptive/decimate.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/solve/backend.h"
#include "support/calls.h"
#include "support/fitted_level.h"

namespace planish::test {
namespace {

// A glTF that becomes a glTF: everything that is no triangle passes, and what rides on triangles is
// the surface's own.

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

// Skins and morph targets on the surface, against surfaces fitted to the moved points.

// With the progressive method the surface is linear in the given points: a morphed surface is the
// surface through the morphed points.
TEST_F(Asset, MorphTargetsAreExact) { expect_exact_morphs(progressive(), 2e-6, 2e-5); }

// With the fair method targets move the rest pose's surface by the linear map: through every moved
// point, and elsewhere near the surface that would be fitted to them.
TEST_F(Asset, MorphedFairSurfacesPassThroughTheMovedPoints) {
  FitFileOptions fair = progressive();
  fair.settings.interpolation = InterpolationChoice::Fair;
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

// On a flat plate of uneven triangles weights that are affine stay so on any surface.
TEST(AssetWeights, StayAffineOnFairSurfaces) {
  constexpr int kCells = 6;
  AssetMesh mesh;
  mesh.vertices.groups = {{}};
  mesh.vertices.joint_sets = 1;
  mesh.vertices.first_influence = {0};
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const bool is_rim = i % kCells == 0 || j % kCells == 0;
      const double moved = is_rim ? 0 : 0.2 * std::sin(5.0 * i + 3 * j);
      mesh.file.mesh.positions.emplace_back(i + moved, j - moved, 0);
      const double second = mesh.file.mesh.positions.back().x / kCells;
      mesh.vertices.influences.push_back({0, static_cast<float>(1 - second)});
      mesh.vertices.influences.push_back({1, static_cast<float>(second)});
      mesh.vertices.first_influence.push_back(std::ssize(mesh.vertices.influences));
    }
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const std::int32_t a = j * (kCells + 1) + i, c = a + kCells + 1;
      mesh.file.mesh.add_face(std::array{a, a + 1, c + 1});
      mesh.file.mesh.add_face(std::array{a, c + 1, c});
    }
  const auto backend = make_cpu_backend({});
  MeshFitOptions how;
  how.method = InterpolationMethod::Fair;
  how.quads = QuadChoice::Off;
  how.refine = RefineChoice::Off;
  const FittedMesh fitted = fit_mesh(mesh.file.mesh, "plate", *backend, how);
  const FittedLevel level(fitted, *backend, 2);
  const AssetAttributes attributes(mesh, fitted, level.blocks(), *backend, {});
  GltfOptions options;
  attributes.add_to(options);
  const auto named = [&](const char* name) {
    return std::ranges::find(options.attributes, name, &GltfAttribute::name)->values;
  };
  std::vector<glm::dvec3> places(static_cast<std::size_t>(level.blocks().info().row_count));
  RowTarget target;
  target.positions = places;
  (void)level.blocks().rows({0, level.blocks().info().row_count}, target);
  for (std::size_t row = 0; row < places.size(); ++row) {
    double second = 0;
    for (std::size_t k = 4 * row; k < 4 * row + 4; ++k)
      if (named("JOINTS_0")[k] == 1) second += named("WEIGHTS_0")[k];
    // Corners of the outline are round, and no weight is below 0.
    ASSERT_NEAR(second, std::clamp(places[row].x / kCells, 0.0, 1.0), 1e-6)
        << places[row].x << ' ' << places[row].y;
  }
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
  // By what rounding leaves of a zero it does not.
  for (const auto& [away, further] : {std::pair{1e-16F, 0}, {1.0F, AssetSample::kRings + 1}}) {
    for (int j = 0; j <= AssetSample::kRings; ++j) {
      const std::size_t v =
          static_cast<std::size_t>(j * (AssetSample::kAround + 1) + AssetSample::kAround);
      std::memcpy(apart.bytes.data() + at + 12 * v + 8, &away, 4);
    }
    (void)fitted(apart.glb(), progressive());
    EXPECT_EQ(result_.fitted.mesh.vertex_count(), before + further) << away;
  }
}

// Nor where an edge joins them, which has no length until they do.
TEST_F(Asset, EdgesThatGetALengthByMovingStay) {
  AssetSample shut = sample_;
  shut.json["meshes"].erase(2);
  shut.json["nodes"].erase(7);
  shut.json["scenes"][0]["nodes"] = {0, 3, 4, 5, 6, 7};
  (void)fitted(shut.glb(), progressive());
  const std::int64_t before = result_.fitted.mesh.vertex_count();
  const std::size_t stays = AssetSample::kRings / 2 * (AssetSample::kAround + 1) + 3,
                    goes = stays + 1;
  shut.move_tube([&](std::size_t v, std::size_t k) {
    return v == goes ? shut.tube[stays][k] - shut.tube[goes][k] : 0;
  });
  (void)fitted(shut.glb(), progressive());
  EXPECT_EQ(result_.fitted.mesh.vertex_count(), before);
  for (const Warning& warning : result_.fitted.warnings) EXPECT_NE(warning.code, "short-edges");
}

// Moves of colours and texture coordinates are linear between vertices as these are: a target that
// has the numbers of another attribute moves by what the surface has of that.
TEST_F(Asset, MorphTargetsMoveColorsAndTextureCoordinates) {
  using nlohmann::json;
  for (json& primitive : sample_.json["meshes"][0]["primitives"])
    primitive["targets"][0]["TEXCOORD_0"] = primitive["attributes"]["TEXCOORD_1"];
  json& ball = sample_.json["meshes"][1]["primitives"][0];
  ball["targets"] = {{{"COLOR_0", ball["attributes"]["COLOR_0"]}}};
  const tinygltf::Model model = fitted(sample_.glb(), progressive());
  const auto expect_same = [&](const tinygltf::Primitive& primitive, const char* moved,
                               const char* by) {
    const auto moves = numbers_of(model, primitive.targets.at(0).at(moved));
    const auto given = numbers_of(model, primitive.attributes.at(by));
    ASSERT_EQ(moves.size(), given.size());
    for (std::size_t i = 0; i < moves.size(); ++i) EXPECT_NEAR(moves[i], given[i], 1e-6);
  };
  for (const tinygltf::Primitive& tube : model.meshes[0].primitives)
    expect_same(tube, "TEXCOORD_0", "TEXCOORD_1");
  expect_same(model.meshes[1].primitives[0], "COLOR_0", "COLOR_0");
}

// What rides on an asset's meshes where the surface is no level of a Doo-Sabin one: triangles as
// fine as it bends, and the other schemes.

class AssetSchemes : public Asset {
 protected:
  static FitFileOptions options_of(Scheme scheme) {
    FitFileOptions options = progressive();
    options.settings.scheme = scheme;
    // Whose tolerance is the target's.
    options.settings.tolerance = 1e-8;
    options.settings.max_iterations = 2000;
    return options;
  }
};

// Linear in the given points as Doo-Sabin's: a morphed surface is that through the morphed points.
TEST_F(AssetSchemes, MorphTargetsAreExact) {
  for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Loop})
    expect_exact_morphs(options_of(scheme), 5e-6, 1e-4);
}

TEST_F(AssetSchemes, WeightsSumToOneAndAttributesAreLinear) {
  for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Loop}) {
    const tinygltf::Model model = fitted(sample_.glb(), options_of(scheme));
    for (const tinygltf::Primitive& part : model.meshes[0].primitives) {
      const auto positions = points_of(model, part.attributes.at("POSITION"));
      const auto joints = numbers_of(model, part.attributes.at("JOINTS_0"));
      const auto weights = numbers_of(model, part.attributes.at("WEIGHTS_0"));
      const auto first = numbers_of(model, part.attributes.at("TEXCOORD_0"));
      const auto second = numbers_of(model, part.attributes.at("TEXCOORD_1"));
      ASSERT_EQ(weights.size(), 4 * positions.size());
      for (std::size_t i = 0; i < positions.size(); ++i) {
        double upper = 0, sum = 0;
        for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
          sum += weights[k];
          if (joints[k] == 1) upper += weights[k];
        }
        EXPECT_NEAR(sum, 1, 1e-6);
        // As the sample has them, by the height alone.
        const double t = std::clamp((positions[i].y - 1) / 2, 0.0, 1.0);
        EXPECT_NEAR(upper, t * t * (3 - 2 * t), 0.02) << positions[i].y;
        EXPECT_NEAR(second[2 * i], 0.5 * first[2 * i], 1e-6);
        EXPECT_NEAR(second[2 * i + 1], 0.25 + 0.5 * first[2 * i + 1], 1e-6);
      }
    }
    const tinygltf::Primitive& ball = model.meshes[1].primitives[0];
    const auto heat = numbers_of(model, ball.attributes.at("_HEAT"));
    const auto colors = numbers_of(model, ball.attributes.at("COLOR_0"));
    ASSERT_EQ(colors.size(), 4 * heat.size());
    for (std::size_t i = 0; i < heat.size(); ++i)
      EXPECT_NEAR(colors[4 * i + 2], 0.5 - 0.05 * heat[i], 1e-5);
  }
}

// Triangles as fine as the surface is curved, and few of them.
class Adaptive : public Asset, public testing::WithParamInterface<bool> {
 protected:
  // The tube of a sample, fitted, and its tessellation.
  struct Tube {
    std::string bytes;
    std::unique_ptr<const GltfAsset> asset;
    AssetMesh mesh;
    FittedMesh fitted;
    std::unique_ptr<const LimitSurface> limit;
    AdaptiveSurface surface;
    std::unique_ptr<const AdaptiveBlocks> blocks;
  };
  std::unique_ptr<Tube> tube_of(AssetSample& sample, InterpolationMethod method) {
    auto tube = std::make_unique<Tube>();
    tube->bytes = sample.glb();
    tube->asset = std::make_unique<const GltfAsset>(
        FileBytes{.bytes = std::as_bytes(std::span(tube->bytes)), .name = "tube.glb", .path = {}});
    tube->mesh = tube->asset->read(0);
    MeshFitOptions options = mesh_fit_options(progressive().settings);
    options.method = method;
    tube->fitted = fit_mesh(tube->mesh.file.mesh, "tube", *backend_, options);
    tube->limit = std::make_unique<const LimitSurface>(
        fitted_surface(tube->fitted.mesh, tube->fitted.fit, tube->fitted.evaluate_options()));
    const double diagonal = tube->fitted.fit.placement.diagonal;
    tube->surface =
        GetParam()
            ? decimate(*tube->limit, {.target = {.triangles = 40}, .diagonal = diagonal}).surface
            : tessellate(*tube->limit, {.chord_error = 1e-3, .diagonal = diagonal});
    tube->blocks = std::make_unique<const AdaptiveBlocks>(tube->surface, *tube->limit);
    return tube;
  }

  std::unique_ptr<Backend> backend_ = make_cpu_backend({});
};

INSTANTIATE_TEST_SUITE_P(Triangles, Adaptive, testing::Bool(),
                         [](const auto& info) { return info.param ? "Few" : "AsFineAsCurved"; });

TEST_P(Adaptive, RowsLieWhereTheySay) {
  const auto tube = tube_of(sample_, InterpolationMethod::Progressive);
  const SurfaceMesh again = tube->blocks->rows_on(*tube->limit);
  ASSERT_EQ(again.positions.size(), tube->surface.mesh.positions.size());
  for (std::size_t i = 0; i < again.positions.size(); ++i) {
    EXPECT_LE(glm::length(again.positions[i] - tube->surface.mesh.positions[i]), 1e-12) << i;
    EXPECT_LE(glm::length(again.normals[i] - tube->surface.mesh.normals[i]), 1e-6F) << i;
  }
  // What is linear in the first texture coordinates is so everywhere.
  std::vector<glm::dvec2> values(tube->surface.mesh.uvs.size());
  ASSERT_TRUE(tube->blocks->uvs_of(tube->mesh.vertices.further_uvs.at(0), values));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::dvec2 first = tube->surface.mesh.uvs[i];
    EXPECT_NEAR(values[i].x, 0.5 * first.x, 1e-6);
    // Upwards, as meshes have them.
    EXPECT_NEAR(1 - values[i].y, 0.25 + 0.5 * (1 - first.y), 1e-6);
  }
}

TEST_P(Adaptive, MorphTargetsAreExact) {
  const auto tube = tube_of(sample_, InterpolationMethod::Progressive);
  const AssetAttributes attributes(tube->mesh, tube->fitted, *tube->blocks, *backend_, {});
  AssetSample posed = sample_;
  posed.move_tube([&](std::size_t v, std::size_t k) { return posed.moves[v][k]; });
  const auto there = tube_of(posed, InterpolationMethod::Progressive);
  const SurfaceMesh wanted = tube->blocks->rows_on(*there->limit);
  GltfOptions options;
  attributes.add_to(options);
  int found = 0;
  for (const GltfAttribute& attribute : options.attributes) {
    if (!attribute.name.starts_with("target/0/")) continue;
    ++found;
    ASSERT_EQ(attribute.values.size(), 3 * wanted.positions.size());
    for (std::size_t i = 0; i < wanted.positions.size(); ++i) {
      const glm::dvec3 by(attribute.values[3 * i], attribute.values[3 * i + 1],
                          attribute.values[3 * i + 2]);
      const bool is_position = attribute.name == "target/0/POSITION";
      const glm::dvec3 from =
          is_position ? tube->surface.mesh.positions[i] : glm::dvec3(tube->surface.mesh.normals[i]);
      const glm::dvec3 to = is_position ? wanted.positions[i] : glm::dvec3(wanted.normals[i]);
      EXPECT_LE(glm::length(from + by - to), is_position ? 2e-6 : 2e-5) << attribute.name << i;
    }
  }
  EXPECT_EQ(found, 2);
}

}  // namespace
}  // namespace planish::test
