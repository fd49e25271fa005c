#include "planish/vulkan/host/surface_records.h"

#include "planish/core/error.h"
#include "planish/doosabin/first_step_table.h"

namespace planish::vulkan {

SurfaceRecords::SurfaceRecords(const PolygonMesh& mesh, const SystemOptions& options)
    : topology(std::make_shared<const MeshTopology>(mesh)),
      features(find_sharp_features(mesh, *topology, mesh.positions, options.sharp)),
      patch_mesh(*topology, features, ring_columns(*topology, options.weights)),
      weights(options.weights),
      uvs(options.textured ? std::optional<CornerUvs>(mesh) : std::nullopt),
      uv_values(options.textured ? mesh.uvs : std::vector<glm::dvec2>()),
      file_faces(mesh),
      patches(patch_mesh, patch_options(options.level)) {}

const PatchSurface& SurfaceRecords::at_level(int level) const {
  if (patches.numbering().level() == level) return patches;
  for (const LevelRecords& of_set : levels.levels)
    if (of_set.patches.numbering().level() == level) return of_set.patches;
  throw Error(ErrorCode::InvalidArgument,
              formatted("level {} is neither the System's level {} nor one of its levels; give "
                        "SystemOptions it",
                        level, patches.numbering().level()));
}

void SurfaceRecords::take_uv_field(std::span<const glm::dvec3> rest) {
  if (!uvs) return;
  uv_field.emplace(patch_mesh, rest, corner_uvs(), std::span<const glm::dvec2>(uv_values));
  frames = row_frames(patches, weights, *uv_field);
}

void SurfaceRecords::take_sharp_rows(const Subdivision& subdivision) {
  const std::int32_t first = subdivision.first_sharp();
  sharp_rows.emplace(first_step_table(subdivision, {first, subdivision.state_size() - first}));
}

}  // namespace planish::vulkan
