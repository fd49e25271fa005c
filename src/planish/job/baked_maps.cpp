#include "planish/job/baked_maps.h"
#include "planish/core/stop.h"

#include <algorithm>

#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/job/text.h"
#include "planish/job/timed.h"

namespace planish {
namespace {

BakeFileOptions bake_options(const FittedJob& work) {
  BakeFileOptions options;
  options.size = work.job.settings.bake;
  options.name = work.made.input.name;
  options.callbacks = callbacks_for(work.report, work.context);
  options.callbacks.progress = {};
  return options;
}

// Where the maps take their normals from.
JobLevel fine_level(const FittedJob& work, JobSurface& all) {
  check_stop();
  return all.level(bake_level(work.fitted.mesh, work.job.settings.bake));
}

}  // namespace

void settle_bake(Job& job) {
  if (job.settings.bake == 0) return;
  for (OutputRequest& output : job.outputs) {
    if (output.kind == OutputKind::Cage) continue;
    if (output.by_density) {
      output.levels = {0};
      output.by_density = false;
    }
    if (output.adaptive.any() || output.levels != std::vector<int>{0})
      refuse(
          output.where,
          "{}: a baked map is of level 0, the input's own mesh; leave other levels out, or write "
          "them without --bake",
          visible(output.path));
  }
}

void require_bakeable(const std::vector<PlannedOutput>& outputs) {
  bool any = false;
  for (const PlannedOutput& output : outputs) {
    if (output.kind == OutputKind::Cage) continue;
    any = true;
    if (!info_of(output.format).is_gltf || info_of(output.format).is_tiles)
      refuse("--bake", visible(output.path) + " holds no baked map; .glb and .gltf do");
  }
  if (!any) refuse("--bake", "no surface is written that holds a map; name one: -o out.glb");
}

std::unique_ptr<const BakedSurface> baked_surface(const FittedJob& work, JobSurface& all,
                                                  const JobLevel& low, const GltfOptions& gltf) {
  if (work.job.settings.bake == 0) return nullptr;
  return timed(work.report.timing.evaluate, [&] {
    const JobLevel fine = fine_level(work, all);
    BakeFileOptions options = bake_options(work);
    options.double_sided = gltf.double_sided;
    return std::make_unique<const BakedSurface>(work.fitted, low.blocks(), fine.blocks(),
                                                work.made.materials.gltf, options);
  });
}

std::unique_ptr<const BakedAssetMesh> baked_mesh(const FittedJob& work, const GltfAsset& asset,
                                                 const AssetMesh& mesh, JobSurface& all,
                                                 const JobLevel& low,
                                                 const AssetAttributes& attributes) {
  if (work.job.settings.bake == 0) return nullptr;
  return timed(work.report.timing.evaluate, [&] {
    const JobLevel fine = fine_level(work, all);
    return std::make_unique<const BakedAssetMesh>(asset, mesh, work.fitted, low.blocks(),
                                                  attributes, fine.blocks(), bake_options(work));
  });
}

void note_maps(std::span<const BakedMap> maps, const std::string& mesh, int size,
               WrittenOutput& written) {
  written.bake_size = size;
  for (const BakedMap& map : maps)
    if (!map.png.empty())
      written.maps.push_back({.mesh = mesh,
                              .material = map.material,
                              .bytes = map.png.size(),
                              .covered = map.map.covered,
                              .overlapped = map.map.overlapped});
}

}  // namespace planish
