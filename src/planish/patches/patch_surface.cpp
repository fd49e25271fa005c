#include "planish/patches/patch_surface.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <unordered_map>
#include <utility>
#include <vector>

#include "planish/core/guards.h"
#include "planish/core/work.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_plan.h"

namespace planish {
namespace {

// The unit normal of the output's facets around a row, hidden ones included, weighted by area; +Z
// where they have none. For rows whose tangents are parallel.
class FacetNormals {
 public:
  FacetNormals(const PatchMesh& mesh, const PatchNumbering& numbering, const PatchClasses& classes,
               const double* state, const Placement& placement)
      : mesh_(mesh),
        numbering_(numbering),
        classes_(classes),
        state_(state),
        placement_(placement) {}

  [[nodiscard]] glm::vec3 at(const PatchTile& tile, std::int64_t row) const;

 private:
  struct Sample {
    std::int32_t corner, a, b;
  };
  [[nodiscard]] std::vector<Sample> samples_of(const PatchTile& tile, std::int64_t row) const;
  [[nodiscard]] glm::dvec3 point(const PatchPlace& place, std::int32_t sample) const;
  [[nodiscard]] glm::dvec3 cells_around(const Sample& sample) const;
  [[nodiscard]] glm::dvec3 polygon(std::int32_t face) const;

  const PatchMesh& mesh_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
  const double* state_;
  const Placement& placement_;
};

}  // namespace

namespace {

using Part = PatchNumbering::Part;

// A row's sample as all the corners on its side of a cut see it.
std::vector<FacetNormals::Sample> FacetNormals::samples_of(const PatchTile& tile,
                                                           std::int64_t row) const {
  const MeshTopology& topology = mesh_.topology();
  const std::int32_t n = numbering_.samples().side();
  std::vector<Sample> samples;
  const std::int64_t offset = row - tile.first_row;
  const auto add_edge_side = [&](std::int32_t corner) {
    samples.push_back({corner, n, 0});
    samples.push_back({topology.next(corner), 0, n});
  };
  const auto add_edge = [&](std::int32_t corner) {
    add_edge_side(corner);
    if (!mesh_.is_sharp(corner)) add_edge_side(topology.twin(corner));
  };
  const auto add_sector = [&](std::int32_t start) {
    const bool cut = mesh_.vertex_point(start).patch.has_sharp_edges();
    std::int32_t c = start;
    do {
      samples.push_back({c, 0, 0});
      c = topology.ccw(c);
    } while (c >= 0 && c != start && !(cut && mesh_.is_sharp(c)));
  };
  const auto item = tile.first_item + offset;
  switch (tile.part) {
    case Part::Vertices:
      add_sector(numbering_.item_corner(tile.part, item));
      break;
    case Part::Faces: {
      const std::int32_t face = topology.face_of(numbering_.item_corner(tile.part, item));
      for (std::int32_t i = 0; i < topology.face_size(face); ++i) {
        samples.push_back({topology.first_corner(face) + i, n, n});
      }
      break;
    }
    case Part::Edges:
      add_edge(numbering_.item_corner(tile.part, item));
      break;
    case Part::Further: {
      const std::int32_t corner = numbering_.item_corner(tile.part, item);
      if (numbering_.is_further_edge(item)) {
        add_edge_side(corner);
      } else {
        add_sector(corner);
      }
      break;
    }
    case Part::Trailing: {
      const std::int32_t count = numbering_.samples().trailing_count();
      const std::int32_t corner =
          numbering_.item_corner(tile.part, tile.first_item + offset / count);
      samples.push_back({corner, 0, static_cast<std::int32_t>(offset % count) + 1});
      break;
    }
    case Part::Corners: {
      const std::int32_t corner = numbering_.corner_of_row(row);
      const auto [a, b] = numbering_.samples().place(
          static_cast<std::int32_t>(row - numbering_.corner_row(corner)));
      samples.push_back({corner, a, b});
      if (b == 0 && !mesh_.is_sharp(corner)) samples.push_back({topology.cw(corner), 0, a});
      if (b > 0 && a == n) samples.push_back({topology.next(corner), b, n});
      break;
    }
  }
  return samples;
}

glm::dvec3 FacetNormals::point(const PatchPlace& place, std::int32_t sample) const {
  const auto columns = static_cast<std::size_t>(place.patch.column_count());
  count_work(Work::Products, static_cast<std::int64_t>(columns));
  std::vector<std::int32_t> indices(columns);
  mesh_.gather(place, indices.data(), 1);
  const auto at = [&](std::size_t k) {
    const double* p = state_ + 3 * static_cast<std::ptrdiff_t>(indices[k]);
    return glm::dvec3(p[0], p[1], p[2]);
  };
  const auto weights = classes_.weights(classes_.index_of(place.patch)).rows(sample);
  glm::dvec3 sum(0.0);
  for (std::size_t k = 1; k < columns; ++k) sum += weights[k - 1] * (at(k) - at(0));
  return placement_.to_model(sum + at(0));
}

glm::dvec3 FacetNormals::cells_around(const Sample& sample) const {
  const PatchSamples& samples = numbering_.samples();
  const PatchPlace place = mesh_.corner_patch(sample.corner);
  glm::dvec3 sum(0.0);
  for (std::int32_t b = sample.b - 1; b <= sample.b; ++b) {
    for (std::int32_t a = sample.a - 1; a <= sample.a; ++a) {
      if (a < 0 || b < 0 || a >= samples.side() || b >= samples.side()) continue;
      const std::array<glm::dvec3, 4> cell = {
          point(place, samples.index(a, b)), point(place, samples.index(a + 1, b)),
          point(place, samples.index(a + 1, b + 1)), point(place, samples.index(a, b + 1))};
      sum += area_vector(cell, std::array<std::int32_t, 4>{0, 1, 2, 3});
    }
  }
  return sum;
}

glm::dvec3 FacetNormals::polygon(std::int32_t face) const {
  const MeshTopology& topology = mesh_.topology();
  std::vector<glm::dvec3> points;
  std::vector<std::int32_t> order;
  for (std::int32_t i = 0; i < topology.face_size(face); ++i) {
    const std::int32_t vertex = topology.vertex_of(topology.first_corner(face) + i);
    std::vector<std::int32_t> starts;
    mesh_.sector_starts(vertex, starts);
    points.push_back(point(mesh_.vertex_point(starts.front()), 0));
    order.push_back(i);
  }
  return area_vector(points, order);
}

glm::vec3 FacetNormals::at(const PatchTile& tile, std::int64_t row) const {
  std::vector<Sample> samples = samples_of(tile, row);
  std::sort(samples.begin(), samples.end(),
            [](const Sample& x, const Sample& y) { return x.corner < y.corner; });
  glm::dvec3 sum(0.0);
  for (const Sample& sample : samples) {
    sum += numbering_.level() == 0 ? polygon(mesh_.topology().face_of(sample.corner))
                                   : cells_around(sample);
  }
  const double length = glm::length(sum);
  return length > 0 ? glm::vec3(sum / length) : glm::vec3(0.0f, 0.0f, 1.0f);
}

// Corner patches: the surface over a quad of Q_1 is a fixed linear map of a few points of level 1,
// the same for all quads of a class; a derivation of our own.

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

namespace {

// Evaluated at once: as many as a tile of the surface has.
constexpr std::int64_t kRunRows = 1 << 14, kRunItems = 1 << 11;

// The item that a row belongs to, with all its rows.
PatchTile item_of_row(const PatchNumbering& numbering, std::int64_t row) {
  int part = 0;
  while (row >= numbering.end_row(static_cast<Part>(part))) ++part;
  PatchTile item{static_cast<Part>(part), 0, 1, row, 1};
  const std::int64_t offset = row - numbering.first_row(item.part);
  if (item.part == Part::Corners) {
    const std::int32_t corner = numbering.corner_of_row(row);
    item.first_item = corner;
    item.first_row = numbering.corner_row(corner);
    item.row_count = numbering.corner_row_count(corner);
  } else if (item.part == Part::Trailing) {
    item.row_count = numbering.samples().trailing_count();
    item.first_item = offset / item.row_count;
    item.first_row = row - offset % item.row_count;
  } else {
    item.first_item = offset;
  }
  return item;
}

// Items that follow one another, of one part.
std::vector<PatchTile> runs_of(const PatchNumbering& numbering,
                               std::span<const std::int32_t> rows) {
  std::vector<PatchTile> runs;
  for (std::size_t i = 0; i < rows.size();) {
    const PatchTile item = item_of_row(numbering, rows[i]);
    while (i < rows.size() && rows[i] < item.first_row + item.row_count) ++i;
    if (!runs.empty()) {
      PatchTile& last = runs.back();
      if (last.part == item.part && last.first_item + last.item_count == item.first_item &&
          last.first_row + last.row_count == item.first_row && last.item_count < kRunItems &&
          last.row_count + item.row_count <= kRunRows) {
        ++last.item_count;
        last.row_count += item.row_count;
        continue;
      }
    }
    runs.push_back(item);
  }
  return runs;
}

}  // namespace

// Some runs, evaluated one after another into arrays of their own.
class PatchSurface::RowEvaluator {
 public:
  RowEvaluator(const PatchSurface& surface, std::span<const glm::dvec3> state,
               const Placement& placement, const PatchTarget& target)
      : surface_(surface), state_(state), placement_(placement), target_(target) {}

  // `rows` are those wanted of the runs, which go to the target from `place` on.
  DegenerateRows operator()(std::span<const PatchTile> runs, std::span<const std::int32_t> rows,
                            std::size_t place) {
    plan_.clear();
    std::int64_t count = 0;
    for (const PatchTile& run : runs) {
      surface_.planner_.add(run, count, plan_);
      count += run.row_count;
    }
    PatchTarget all;
    all.origin = target_.origin;
    if (!target_.positions.empty()) all.positions = sized(positions_, count);
    if (!target_.stored.empty()) all.stored = sized(stored_, count);
    if (!target_.normals.empty()) all.normals = sized(normals_, count);
    const bool degenerate =
        surface_.runner_.run_plan(plan_, output_at(placement_, all, 0), &state_[0].x);
    return hand_over(runs, rows, place, all, degenerate);
  }

 private:
  template <class Vector>
  static std::span<Vector> sized(std::vector<Vector>& values, std::int64_t count) {
    values.resize(static_cast<std::size_t>(count));
    return values;
  }

  DegenerateRows hand_over(std::span<const PatchTile> runs, std::span<const std::int32_t> rows,
                           std::size_t place, const PatchTarget& all, bool degenerate) const {
    DegenerateRows found;
    const FacetNormals facets(surface_.mesh(), surface_.numbering(), surface_.classes(),
                              &state_[0].x, placement_);
    std::int64_t first = 0;
    std::size_t i = 0;
    for (const PatchTile& run : runs) {
      for (; i < rows.size() && rows[i] < run.first_row + run.row_count; ++i) {
        const auto from = static_cast<std::size_t>(first + rows[i] - run.first_row);
        if (!all.positions.empty()) target_.positions[place + i] = all.positions[from];
        if (!all.stored.empty()) target_.stored[place + i] = all.stored[from];
        if (all.normals.empty()) continue;
        glm::vec3& normal = target_.normals[place + i] = all.normals[from];
        if (!degenerate || normal != glm::vec3(0.0f)) continue;
        normal = facets.at(run, rows[i]);
        found.add({1, rows[i]});
      }
      first += run.row_count;
    }
    return found;
  }

  const PatchSurface& surface_;
  std::span<const glm::dvec3> state_;
  const Placement& placement_;
  const PatchTarget& target_;
  PatchPlan plan_;
  std::vector<glm::dvec3> positions_;
  std::vector<glm::vec3> stored_, normals_;
};

DegenerateRows PatchSurface::rows_at(std::span<const glm::dvec3> state, const Placement& placement,
                                     std::span<const std::int32_t> rows,
                                     const PatchTarget& target) const {
  DegenerateRows degenerate;
  if (rows.empty()) return degenerate;
  PLANISH_ASSERT(rows.front() >= 0 && rows.back() < numbering_.row_count());
  const std::vector<PatchTile> runs = runs_of(numbering_, rows);
  RowEvaluator evaluate(*this, state, placement, target);
  std::size_t place = 0;
  for (std::size_t begin = 0; begin < runs.size();) {
    std::size_t end = begin;
    std::int64_t items = 0, count = 0;
    while (end < runs.size() && (end == begin || (items + runs[end].item_count <= kRunItems &&
                                                  count + runs[end].row_count <= kRunRows))) {
      items += runs[end].item_count;
      count += runs[end].row_count;
      ++end;
    }
    const auto last =
        std::ranges::lower_bound(rows, runs[end - 1].first_row + runs[end - 1].row_count);
    const auto stop = static_cast<std::size_t>(last - rows.begin());
    degenerate.add(evaluate(std::span(runs).subspan(begin, end - begin),
                            rows.subspan(place, stop - place), place));
    place = stop;
    begin = end;
  }
  return degenerate;
}

}  // namespace planish
