#include "bench/table_chain.h"

#include "planish/backend/cpu_backend.h"
#include "planish/doosabin/surface_stencils.h"
#include "planish/surface/surface_blocks.h"

namespace planish::bench {

void apply_table_chain(const PolygonMesh& mesh, int level, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals) {
  constexpr std::int64_t kSlice = 1 << 17;
  const auto backend = make_cpu_backend();
  QuadSplit split(mesh);
  split.refine(level);
  const SharpFeatures features = find_sharp_features(mesh, split, mesh.positions, {});
  const Subdivision subdivision(split, features, Weights::DooSabin);
  auto points = backend->upload(mesh.positions);
  for (int l = 1; l <= level; ++l) {
    const std::int64_t size = subdivision.state_layout(l).size;
    auto next = backend->allocate(static_cast<std::int32_t>(size));
    for (const RowRange rows : ranges_of(size, kSlice)) {
      const auto table = l == 1 ? first_step_table(mesh, subdivision, rows)
                                : refinement_table(subdivision, l - 1, rows);
      backend->apply(table.view(), *points, *next, static_cast<std::int32_t>(rows.first));
    }
    points = std::move(next);
  }
  const LimitRows limits(subdivision, level, split.counts(level).vertices);
  for (const RowRange rows : ranges_of(limits.count(), kSlice)) {
    const auto first = static_cast<std::size_t>(rows.first);
    const auto count = static_cast<std::size_t>(rows.count);
    backend->apply_limit(limit_table(subdivision, level, limits, rows).view(), *points,
                         positions.subspan(first, count), normals.subspan(first, count));
  }
}

}  // namespace planish::bench
