#include "planish/pipeline/fit_asset.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/host_scope.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/asset/write_asset.h"
#include "planish/files/gltf/gltf_nodes.h"
#include "planish/pipeline/asset_attributes.h"
#include "planish/pipeline/asset_parts.h"
#include "planish/pipeline/fitted_level.h"
#include "planish/pipeline/mesh_warnings.h"
#include "planish/pipeline/written_distance.h"

namespace planish {
namespace {

// A mesh of an asset on its way to its surface.
struct AssetPart {
  AssetMesh mesh;
  MeshShare share;
  ReadyFit ready;
  FittedMesh fitted;
};

// Of one level.
struct PartLevel {
  int level = 0;
  FittedLevel made;
  std::unique_ptr<const AssetAttributes> attributes;
};

// Of the time of fits, when the meshes are ready.
constexpr double kMeshesReady = 0.2;
// Of the time until all is written, but for rows of surfaces, when the meshes are fitted; the rest
// is what rides on them.
constexpr double kMeshesFitted = 0.8;

Callbacks share_of_mesh(const Callbacks& whole, MeshShare mesh, double from, double to) {
  return share_of(whole, std::lerp(from, to, mesh.begin), std::lerp(from, to, mesh.end));
}

std::list<AssetPart> fitted_parts(const GltfAsset& asset, const MeshFitOptions& how,
                                  Backend& backend, const FitFileOptions& options) {
  const std::string file(asset.file().name);
  const Callbacks& whole = how.fit.callbacks;
  MeshSteps<AssetPart> steps;
  steps.warn = [&](const Warning& warning) { whole.warn(warning); };
  steps.prepare = [&](AssetPart& part, std::int64_t number, MeshShare of) {
    part.share = of;
    part.mesh = asset.read(number);
    for (const Warning& warning : part.mesh.file.warnings) whole.warn(warning);
    MeshFitOptions one = how;
    one.fit.callbacks = share_of_mesh(whole, of, 0, kMeshesReady);
    one.stands_alone = part.mesh.file.stands_alone;
    part.ready =
        prepare_fit(std::move(part.mesh.file.mesh),
                    asset.surfaces().size() == 1 ? file : file + ": " + part.mesh.name, one);
  };
  steps.fit = [&](AssetPart& part, MeshShare of) {
    part.ready.options.fit.callbacks = share_of_mesh(whole, of, kMeshesReady, 1);
    part.fitted = fit_prepared(std::move(part.ready), backend);
    part.fitted.split_normals = options.split_normals;
  };
  return fit_meshes(asset, steps);
}

void tell(const Callbacks& callbacks, FittedMesh& fitted, const std::optional<Warning>& warning) {
  if (!warning) return;
  fitted.warnings.push_back(*warning);
  callbacks.warn(*warning);
}

// `level_of` a part.
std::list<PartLevel> levels_of(std::list<AssetPart>& parts,
                               const std::function<int(const AssetPart&)>& level_of,
                               Backend& backend, const Callbacks& callbacks) {
  std::list<PartLevel> levels;
  for (const AssetPart& part : parts) {
    PartLevel& one = levels.emplace_back();
    one.level = level_of(part);
    one.made = fitted_level(part.fitted, backend, {one.level, false, {}});
    one.attributes =
        std::make_unique<const AssetAttributes>(part.mesh, part.fitted, *one.made.blocks, backend,
                                                share_of_mesh(callbacks, part.share, 0, 1));
  }
  return levels;
}

}  // namespace

FileFit fit_asset(const GltfAsset& asset, const std::filesystem::path& output,
                  const MeshFitOptions& how, Backend& backend, const FitFileOptions& options) {
  const Callbacks& whole = how.fit.callbacks;
  const std::vector<int> levels = options.levels();
  double rows = 0;
  std::vector<double> edges;  // of a level, of a level 0
  for (const int level : levels) {
    rows += std::ldexp(1.0, 2 * level);
    edges.push_back(std::ldexp(1.0, -level));
  }
  const double made = share_before_rows(levels), fitted = kMeshesFitted * made;
  MeshFitOptions fitting = how;
  fitting.fit.callbacks = share_of(whole, 0, fitted);
  std::list<AssetPart> parts = fitted_parts(asset, fitting, backend, options);
  AssetDetails<PartLevel> details;
  double done = 0;
  for (const int level : levels) {
    const double from = done / rows;
    done += std::ldexp(1.0, 2 * level);
    const auto level_of = [&](const AssetPart& part) {
      return details.empty() ? options.level_of(part.fitted.density) : level;
    };
    details.push_back(levels_of(
        parts, level_of, backend,
        share_of(whole, std::lerp(fitted, made, from), std::lerp(fitted, made, done / rows))));
  }
  tell(whole, parts.front().fitted, empty_scene_warning(asset.root()));
  int finest = 0;
  for (auto part = parts.begin(); const PartLevel& level : details.front()) {
    tell(whole, part->fitted,
         fold_warning(part->fitted, level.made, level.level, {.cancelled = whole.cancelled}));
    finest = std::max(finest, level.level);
    ++part;
  }
  FileFit result;
  double rounded = 0;  // the largest error of the file's numbers, of a mesh's diagonal
  const std::vector<AssetSurface> surfaces =
      surfaces_of(parts, details, edges, [&](const AssetPart& part, const PartLevel& level) {
        GltfOptions gltf = gltf_options_of(part.fitted, part.mesh.name, {level.level, false, {}});
        level.attributes->add_to(gltf);
        const Fit& fit = part.fitted.fit;
        if (fit.interpolation.converged)
          rounded =
              std::max(rounded, written_distance(*level.made.blocks, part.fitted.points(), gltf) /
                                    fit.placement.diagonal);
        result.vertex_count += level.made.blocks->info().row_count;
        result.face_count += level.made.blocks->info().face_count;
        return AssetSurface{.mesh = part.mesh.number,
                            .surface = level.made.blocks.get(),
                            .vertices = &part.mesh.vertices,
                            .options = std::move(gltf)};
      });
  GltfOptions common;
  common.callbacks = share_of(whole, made, 1);
  result.byte_count = write_asset(output, output.parent_path(), asset, surfaces, common).byte_count;
  tell(whole, parts.front().fitted, rounding_warning(visible(output), rounded, how.fit.tolerance));
  if (!options.level && options.coarser_levels.empty())
    tell(whole, parts.front().fitted,
         size_warning(visible(output), result.byte_count, asset.byte_count(), finest));
  result.fitted = std::move(parts.front().fitted);
  for (auto part = std::next(parts.begin()); part != parts.end(); ++part)
    result.further.push_back(std::move(part->fitted));
  return result;
}

}  // namespace planish
