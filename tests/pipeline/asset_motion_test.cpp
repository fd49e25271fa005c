// Skins and morph targets on the surface, against surfaces fitted to the moved points.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>

#include "pipeline/asset_fixture.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/solve/backend.h"
#include "support/fitted_level.h"

namespace planish::test {
namespace {

using nlohmann::json;

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

}  // namespace
}  // namespace planish::test
