// write_samples FOLDER: one file of every kind that the writer makes, for the Khronos validator.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <list>
#include <memory>
#include <span>
#include <vector>

#include "files/gltf/asset_sample.h"
#include "files/gltf/surfaces.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/write_surface.h"
#include "planish/job/fit_file.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/bake_maps.h"
#include "planish/solve/backend.h"
#include "support/fitted_level.h"

namespace planish {
namespace {

// Levels of detail of an asset in one file, compressed or not.
void write_levels_of_detail(const std::filesystem::path& folder, GltfCompression compression) {
  const std::string bytes = test::AssetSample().glb();
  const GltfAsset asset(
      {.bytes = std::as_bytes(std::span(bytes)), .name = "asset.glb", .path = {}});
  const auto backend = make_cpu_backend({});
  struct Part {
    AssetMesh mesh;
    FittedMesh fitted;
    std::unique_ptr<const DooSabinSurface> surface;
  };
  std::list<Part> parts;
  for (const std::int64_t number : asset.surfaces()) {
    Part& part = parts.emplace_back();
    part.mesh = asset.read(number);
    part.fitted = fit_mesh(part.mesh.file.mesh, part.mesh.name, *backend);
    part.surface =
        fitted_surface(part.fitted.mesh, part.fitted.fit, part.fitted.evaluate_options());
  }
  std::list<std::unique_ptr<SurfaceBlocks>> blocks;
  std::list<AssetAttributes> attributes;
  std::vector<AssetSurface> surfaces;
  for (const int level : {2, 1, 0}) {
    for (const Part& part : parts) {
      blocks.push_back(part.surface->level(level));
      GltfOptions options;
      options.compression = compression;
      options.position_error = asset.may_be_scaled(part.mesh.number) ? 1e-3 : 0;
      attributes.emplace_back(part.mesh, part.fitted, *blocks.back(), *backend, Callbacks{})
          .add_to(options);
      surfaces.push_back({.mesh = part.mesh.number,
                          .surface = blocks.back().get(),
                          .vertices = &part.mesh.vertices,
                          .least_coverage = level == 0 ? 0 : 0.1 * level,
                          .options = std::move(options)});
    }
  }
  const bool is_packed = compression != GltfCompression::None;
  (void)write_asset(folder / (is_packed ? "packed details.gltf" : "details.glb"), folder, asset,
                    surfaces, {});
}

// Level 0 with baked maps: of an asset, one of whose charts is mirrored, and whose meshes share a
// material; of a mesh by itself.
void write_baked(const std::filesystem::path& folder) {
  test::AssetSample sample;
  sample.mirror_texture();
  sample.json["meshes"].push_back(sample.json["meshes"][0]);
  sample.json["nodes"].push_back({{"mesh", 3}, {"skin", 0}});
  sample.json["scenes"][0]["nodes"].push_back(9);
  const std::string bytes = sample.glb();
  const GltfAsset asset(
      {.bytes = std::as_bytes(std::span(bytes)), .name = "asset.glb", .path = {}});
  const auto backend = make_cpu_backend({});
  MeshFitOptions how;
  how.refine = RefineChoice::Off;
  constexpr int kSize = 64;
  std::list<AssetMesh> meshes;
  std::list<FittedMesh> fitted;
  std::list<test::FittedLevel> levels;
  std::list<AssetAttributes> attributes;
  std::list<BakedAssetMesh> baked;
  std::vector<AssetSurface> surfaces;
  for (const std::int64_t number : asset.surfaces()) {
    const AssetMesh& mesh = meshes.emplace_back(asset.read(number, true));
    const FittedMesh& fit = fitted.emplace_back(fit_mesh(mesh.file.mesh, mesh.name, *backend, how));
    const test::FittedLevel& low = levels.emplace_back(fit, *backend, 0);
    const test::FittedLevel fine(fit, *backend, bake_level(fit.mesh, kSize));
    AssetSurface& surface = surfaces.emplace_back(
        AssetSurface{.mesh = number, .surface = &low.blocks(), .vertices = &mesh.vertices});
    attributes.emplace_back(mesh, fit, low.blocks(), *backend, Callbacks{}).add_to(surface.options);
    baked
        .emplace_back(asset, mesh, fit, low.blocks(), attributes.back(), fine.blocks(),
                      BakeFileOptions{.size = kSize, .name = mesh.name, .callbacks = {}})
        .add_to(surface);
  }
  for (const char* name : {"tangents_baked.glb", "baked.gltf"})
    (void)write_asset(folder / name, folder, asset, surfaces, {});
  PolygonMesh mesh = asset.read(0).file.mesh;
  const FittedMesh fit = fit_mesh(mesh, "mesh", *backend, how);
  const test::FittedLevel low(fit, *backend, 0);
  const test::FittedLevel fine(fit, *backend, bake_level(fit.mesh, kSize));
  const BakedSurface alone(fit, low.blocks(), fine.blocks(), {},
                           {.size = kSize, .name = "mesh", .callbacks = {}});
  GltfOptions options;
  alone.add_to(options);
  write_gltf(folder / "tangents_baked_alone.glb", low.blocks(), options);
  write_gltf(folder / "baked alone.gltf", low.blocks(), options);
}

void write_samples(const std::filesystem::path& folder) {
  GltfOptions plain;
  write_gltf(folder / "a_quads.glb", test::wavy_grid(30, 20), plain);
  write_gltf(folder / "long_indices.glb", test::wavy_grid(300, 300), plain);
  write_gltf(folder / "short_indices_limit.glb", test::wavy_grid(2, 32767), plain);
  write_gltf(folder / "two words.gltf", test::wavy_grid(30, 20), plain);
  write_gltf(folder / "polygons.glb",
             test::flat_polygons({{{0, 0}, {1, 0}, {0, 1}},
                                  {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 4}, {0, 4}},
                                  {{0, 0}, {1, 0}, {1, 1}, {0, 1}}}),
             plain);
  SurfaceMesh charts = test::two_charts();
  charts.colors.assign(charts.positions.size(), glm::vec4(0.2f, 0.4f, 1.0f, 1.0f));
  write_gltf(folder / "charts.glb", charts, plain);
  std::vector<float> values(charts.positions.size(), 0.5f);
  GltfOptions with_fields = plain;
  with_fields.fields = {{"error", values}, {"gaussian_curvature", values}};
  write_gltf(folder / "fields.glb", charts, with_fields);
  charts.face_groups = {0, 1, 1, 1, 1, 1, 1, 1};
  write_gltf(folder / "groups of uneven size.gltf", charts, plain);
  charts = test::two_charts();
  charts.colors.assign(charts.positions.size(), glm::vec4(0.2f, 0.4f, 1.0f, 1.0f));
  GltfOptions packed = with_fields;
  packed.position_error = 1e-4;
  const auto write_packed = [&](const std::string& name, const SurfaceMesh& surface) {
    packed.compression = GltfCompression::None;
    write_gltf(folder / (name + "_plain.glb"), surface, packed);
    packed.compression = GltfCompression::Quantize;
    write_gltf(folder / (name + "_quantize.glb"), surface, packed);
    packed.compression = GltfCompression::Meshopt;
    write_gltf(folder / (name + "_meshopt.glb"), surface, packed);
    write_gltf(folder / (name + "_meshopt.gltf"), surface, packed);
  };
  write_packed("charts", charts);
  for (const FileFormat format : {FileFormat::Stl, FileFormat::Usda, FileFormat::Obj})
    write_surface(folder / ("charts." + std::string(name_of(format))), format, charts);
  packed.fields.clear();
  const SurfaceMesh waves = test::wavy_grid(80, 50);
  write_packed("waves", waves);
  for (const FileFormat format : {FileFormat::Stl, FileFormat::Usda, FileFormat::Obj})
    write_surface(folder / ("waves." + std::string(name_of(format))), format, waves);
  write_packed("many waves", test::wavy_grid(260, 260));
  GltfOptions buffers = with_fields;
  buffers.buffer_bytes = 300;
  write_gltf(folder / "several buffers.gltf", charts, buffers);
  buffers.fields.clear();
  buffers.buffer_bytes = 40000;
  write_gltf(folder / "buffers of waves.gltf", waves, buffers);
  // Too many triangles to compare one by one.
  packed.compression = GltfCompression::Meshopt;
  write_gltf(folder / "blocks.glb", test::wavy_grid(750, 705), packed);
  GltfOptions everything;
  everything.name = "\xC3\xA4 \"quoted\"";
  everything.double_sided = true;
  everything.z_up = true;
  everything.origin = {5e6, -3e6, 0.1};
  everything.extras = {
      {"converged", true}, {"error", 1e-7}, {"iterations", std::int64_t{7}}, {"solver", "plain"}};
  write_gltf(folder / "everything.glb", test::wavy_grid(30, 20, everything.origin), everything);
  {
    std::ofstream(folder / "asset_in.glb", std::ios::binary) << test::AssetSample().glb();
    for (const char* name : {"asset.glb", "asset.gltf"})
      (void)fit_file(folder / "asset_in.glb", folder / name);
    test::AssetSample mirrored;
    mirrored.mirror_texture();
    // The other set of texture coordinates is that of the second material's normals.
    mirrored.json["materials"].push_back({{"normalTexture", {{"index", 0}, {"texCoord", 1}}}});
    mirrored.json["meshes"][0]["primitives"][1]["material"] = 3;
    std::ofstream(folder / "asset_in.glb", std::ios::binary) << mirrored.glb();
    for (const int level : {0, 2}) {
      FitFileOptions options;
      options.settings.set_levels({level});
      (void)fit_file(folder / "asset_in.glb",
                     folder / ("tangents_" + std::to_string(level) + ".glb"), options);
    }
    std::filesystem::remove(folder / "asset_in.glb");
    // What check_asset.py draws beside its surface; the validator warns of its tangents.
    std::filesystem::create_directory(folder / "given");
    std::ofstream(folder / "given" / "asset.glb", std::ios::binary) << test::AssetSample().glb();
  }
  write_baked(folder);
  write_levels_of_detail(folder, GltfCompression::None);
  write_levels_of_detail(folder, GltfCompression::Quantize);
  write_gltf(folder / "everything.gltf", test::wavy_grid(30, 20, everything.origin), everything);
}

}  // namespace
}  // namespace planish

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  try {
    planish::write_samples(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
