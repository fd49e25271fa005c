// Corner patches: the surface over a quad of Q_1 is a fixed linear map of a few points of level 1,
// the same for all quads of a class; a derivation of our own.
#include "planish/patches/patch_surface.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "planish/core/assert.h"
#include "planish/patches/facet_normals.h"

namespace planish {

namespace {

struct Scratch {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> stored, normals;
};

Scratch& scratch() {
  thread_local Scratch instance;
  return instance;
}

}  // namespace

PatchSurface::PatchSurface(const PatchMesh& mesh, const PatchSurfaceOptions& options)
    : mesh_(mesh),
      numbering_(mesh, options.level, options.hidden, options.corner_uvs),
      classes_(numbering_, mesh, options.weights),
      planner_(mesh_, numbering_, classes_),
      runner_(mesh_, numbering_, classes_, planner_, patch_kernel(options.instructions)),
      tiles_(planner_.tiles()) {}

PatchOutput output_at(const Placement& placement, const PatchTarget& target,
                      std::ptrdiff_t offset) {
  PatchOutput output;
  for (int d = 0; d < 3; ++d) {
    output.centre[d] = placement.centre[d];
    output.origin[d] = target.origin[d];
  }
  output.diagonal = placement.diagonal;
  if (!target.positions.empty()) output.positions = &target.positions[0].x + 3 * offset;
  if (!target.stored.empty()) output.stored = &target.stored[0].x + 3 * offset;
  if (!target.normals.empty()) output.normals = &target.normals[0].x + 3 * offset;
  return output;
}

DegenerateRows PatchSurface::run_tile(std::size_t index, const PatchOutput& output,
                                      const double* state, const Placement& placement,
                                      RowRange wanted) const {
  const PatchTile& tile = tiles_[index];
  DegenerateRows found;
  if (!runner_.run_tile(tile, output, state)) return found;
  const FacetNormals facets(mesh_, numbering_, classes_, state, placement);
  for (std::int64_t r = 0; r < tile.row_count; ++r) {
    const std::int64_t row = tile.first_row + r;
    if (row < wanted.first || row >= wanted.first + wanted.count) continue;
    float* normal = output.normals + 3 * r;
    if (normal[0] != 0 || normal[1] != 0 || normal[2] != 0) continue;
    const glm::vec3 facet = facets.at(tile, row);
    for (int d = 0; d < 3; ++d) normal[d] = facet[d];
    found.add({1, row});
  }
  return found;
}

// A tile that the range cuts: evaluated whole, copied in part.
DegenerateRows PatchSurface::run_part(std::size_t index, std::span<const glm::dvec3> state,
                                      const Placement& placement, RowRange wanted,
                                      const PatchTarget& target) const {
  const PatchTile& tile = tiles_[index];
  Scratch& local = scratch();
  const auto count = static_cast<std::size_t>(tile.row_count);
  PatchTarget whole;
  whole.origin = target.origin;
  const auto take = [&](auto& values, const auto& wanted_values) {
    if (!wanted_values.empty()) values.resize(count);
    return wanted_values.empty() ? std::span(values).first(0) : std::span(values).first(count);
  };
  whole.positions = take(local.positions, target.positions);
  whole.stored = take(local.stored, target.stored);
  whole.normals = take(local.normals, target.normals);
  const DegenerateRows degenerate =
      run_tile(index, output_at(placement, whole, 0), &state[0].x, placement, wanted);
  const std::int64_t first = std::max(tile.first_row, wanted.first);
  const std::int64_t end = std::min(tile.first_row + tile.row_count, wanted.first + wanted.count);
  const auto copy = [&](const auto& from, const auto& to) {
    if (to.empty()) return;
    std::copy_n(from.begin() + (first - tile.first_row), end - first,
                to.begin() + (first - wanted.first));
  };
  copy(whole.positions, target.positions);
  copy(whole.stored, target.stored);
  copy(whole.normals, target.normals);
  return degenerate;
}

DegenerateRows PatchSurface::rows(std::span<const glm::dvec3> state, const Placement& placement,
                                  RowRange range, const PatchTarget& target) const {
  PLANISH_ASSERT(static_cast<std::int64_t>(state.size()) == mesh_.point_count());
  PLANISH_ASSERT(range.first >= 0 && range.first + range.count <= numbering_.row_count());
  DegenerateRows degenerate;
  if (range.count == 0) return degenerate;
  auto tile =
      std::upper_bound(tiles_.begin(), tiles_.end(), range.first,
                       [](std::int64_t row, const PatchTile& t) { return row < t.first_row; }) -
      tiles_.begin() - 1;
  for (auto t = static_cast<std::size_t>(tile);
       t < tiles_.size() && tiles_[t].first_row < range.first + range.count; ++t) {
    const PatchTile& at = tiles_[t];
    const bool whole =
        at.first_row >= range.first && at.first_row + at.row_count <= range.first + range.count;
    degenerate.add(whole ? run_tile(t, output_at(placement, target, at.first_row - range.first),
                                    &state[0].x, placement, range)
                         : run_part(t, state, placement, range, target));
  }
  return degenerate;
}

// By the row's own patch alone: of a tile of large polygons each row is dear.
DegenerateRows PatchSurface::normal_of(std::span<const glm::dvec3> state,
                                       const Placement& placement, std::int32_t row,
                                       glm::vec3& normal) const {
  PatchTarget one;
  one.normals = std::span(&normal, 1);
  return rows_at(state, placement, std::span(&row, 1), one);
}

// Normals of points that came out zero.
DegenerateRows PatchSurface::mend(std::span<const glm::dvec3> state, const Placement& placement,
                                  PointRows* points) const {
  DegenerateRows found;
  for (std::size_t i = 0; points != nullptr && i < points->size(); ++i) {
    glm::vec3& normal = points->normals()[i];
    if (normal == glm::vec3(0.0f))
      found.add(normal_of(state, placement, points->rows()[i], normal));
  }
  return found;
}

DegenerateRows PatchSurface::grids(std::span<const glm::dvec3> state, const Placement& placement,
                                   std::span<const std::int32_t> corners, const PatchTarget& target,
                                   PointRows* points) const {
  DegenerateRows found;
  if (points != nullptr) points->reset(0);
  if (corners.empty()) return found;
  if (!runner_.run_grids(corners, output_at(placement, target, 0), &state[0].x, points))
    return found;
  const PatchSamples& samples = numbering_.samples();
  // A face's point stands in the grids of all its corners, and its normal asks all of them.
  std::unordered_map<std::int32_t, std::pair<DegenerateRows, glm::vec3>> mended;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::int32_t b = 0; b <= samples.side(); ++b) {
      for (std::int32_t a = 0; a <= samples.side(); ++a) {
        glm::vec3& normal = target.normals[i * samples.count() + samples.index(a, b)];
        if (normal != glm::vec3(0.0f)) continue;
        const std::int32_t row = numbering_.row(corners[i], a, b);
        const auto [at, is_new] = mended.try_emplace(row);
        auto& [one, facets] = at->second;
        if (is_new) one = normal_of(state, placement, row, facets);
        normal = facets;
        if (samples.index(a, b) < samples.owned_count()) found.add(one);
      }
    }
  }
  found.add(mend(state, placement, points));
  return found;
}

DegenerateRows PatchSurface::owned(std::span<const glm::dvec3> state, const Placement& placement,
                                   std::int32_t first, std::int32_t corner_count,
                                   const PatchTarget& target, PointRows& points) const {
  const std::int64_t first_row = numbering_.corner_row(first),
                     row_count = std::int64_t{corner_count} * numbering_.samples().owned_count();
  const PatchTile tile{PatchNumbering::Part::Corners, first, corner_count, first_row, row_count};
  DegenerateRows found;
  if (!runner_.run_tile(tile, output_at(placement, target, 0), &state[0].x, &points)) return found;
  for (std::int64_t i = 0; i < row_count; ++i) {
    glm::vec3& normal = target.normals[i];
    if (normal == glm::vec3(0.0f))
      found.add(normal_of(state, placement, static_cast<std::int32_t>(first_row + i), normal));
  }
  found.add(mend(state, placement, &points));
  return found;
}

DegenerateRows PatchSurface::points(std::span<const glm::dvec3> state, const Placement& placement,
                                    std::span<const std::int32_t> rows,
                                    const PatchTarget& target) const {
  DegenerateRows degenerate;
  if (rows.empty() || !runner_.run_points(rows, output_at(placement, target, 0), &state[0].x))
    return degenerate;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (target.normals[i] != glm::vec3(0.0f)) continue;
    degenerate.add(normal_of(state, placement, rows[i], target.normals[i]));
  }
  return degenerate;
}

}  // namespace planish
