#include "bench/table_chain.h"

#include "planish/backend/cpu_backend.h"
#include "planish/surface/surface_blocks.h"
#include "support/doo_sabin_tables.h"

namespace planish::bench {

void apply_table_chain(const PolygonMesh& mesh, int level, std::span<glm::dvec3> positions,
                       std::span<glm::vec3> normals) {
  constexpr std::int64_t kSlice = 1 << 17;
  const auto backend = make_cpu_backend();
  test::QuadSplit split(mesh);
  split.refine(level);
  const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
  const test::SubdivisionChain subdivision(split, features, Weights::DooSabin);
  auto points = backend->upload(mesh.positions);
  for (int l = 1; l <= level; ++l) {
    const std::int64_t size = subdivision.state_layout(l).size;
    auto next = backend->allocate(static_cast<std::int32_t>(size));
    for (const RowRange rows : ranges_of(size, kSlice)) {
      backend->apply(step_table(subdivision, l, rows).view(), *points, *next,
                     static_cast<std::int32_t>(rows.first));
    }
    points = std::move(next);
  }
  const test::LimitRows limits(subdivision, level);
  for (const RowRange rows : ranges_of(limits.count(), kSlice)) {
    const auto first = static_cast<std::size_t>(rows.first);
    const auto count = static_cast<std::size_t>(rows.count);
    backend->apply_limit(limit_table(subdivision, limits, rows).view(), *points,
                         positions.subspan(first, count), normals.subspan(first, count));
  }
}

}  // namespace planish::bench
