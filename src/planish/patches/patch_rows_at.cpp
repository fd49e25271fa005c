#include <algorithm>
#include <vector>

#include "planish/core/assert.h"
#include "planish/patches/facet_normals.h"
#include "planish/patches/patch_surface.h"

namespace planish {

namespace {

using Part = PatchNumbering::Part;

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
