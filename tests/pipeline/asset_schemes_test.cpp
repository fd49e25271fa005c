// What rides on an asset's meshes where the surface is no level of a Doo-Sabin one: triangles as
// fine as it bends, and the other schemes.
#include <glm/geometric.hpp>

#include "pipeline/asset_fixture.h"
#include "planish/adaptive/adaptive_blocks.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/solve/backend.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

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

class Adaptive : public Asset {
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
    tube->surface = tessellate(
        *tube->limit, {.chord_error = 1e-3, .diagonal = tube->fitted.fit.placement.diagonal});
    tube->blocks = std::make_unique<const AdaptiveBlocks>(tube->surface, *tube->limit);
    return tube;
  }

  std::unique_ptr<Backend> backend_ = make_cpu_backend({});
};

TEST_F(Adaptive, RowsLieWhereTheySay) {
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

TEST_F(Adaptive, MorphTargetsAreExact) {
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
