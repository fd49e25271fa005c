#include "planish/patches/patch_plan.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <set>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"
#include "planish/patches/patch_kernel.h"

namespace planish {

namespace {

using Part = PatchNumbering::Part;
using Results = PatchPlan::Results;

// Corners of a tile: enough to fill batches of each class, few enough that their rows and points
// stay in cache.
constexpr std::int64_t kTileItems = 2048;
constexpr std::int64_t kTileRows = 16384;
constexpr std::int64_t kMinTileItems = 64;
// Of the indices of a tile, with faces of thousands of corners.
constexpr std::int64_t kTileIndices = 1 << 20;

constexpr std::array kParts = {Part::Vertices, Part::Faces,    Part::Edges,
                               Part::Corners,  Part::Trailing, Part::Further};

// Of a row of a vertex or midpoint: the patch in whose tangent plane it lies, whatever chart of
// texture coordinates it is of.
PatchPlace point_at(const PatchMesh& mesh, std::int32_t corner, bool is_edge) {
  return is_edge ? mesh.edge_point(corner) : mesh.vertex_point(mesh.sector_corner(corner));
}

// The patch of a row that a part has for an item.
PatchPlace place_of(const PatchMesh& mesh, const PatchNumbering& numbering, Part part,
                    std::int64_t item) {
  const std::int32_t corner = numbering.item_corner(part, item);
  switch (part) {
    case Part::Vertices:
      return point_at(mesh, corner, false);
    case Part::Faces:
      return mesh.face_point(mesh.topology().face_of(corner));
    case Part::Edges:
      return mesh.edge_point(corner);
    case Part::Corners:
    case Part::Trailing:
      return mesh.corner_patch(corner);
    case Part::Further:
      return point_at(mesh, corner, numbering.is_further_edge(item));
  }
  return {};
}

// Where a table of smooth classes by ring and face size has an item's; -1 where that takes more
// than a look.
std::int32_t smooth_place(const PatchMesh& mesh, Part part, std::int32_t corner,
                          std::int32_t table_size) {
  const MeshTopology& topology = mesh.topology();
  std::int32_t ring = table_size, face = 0;
  if (part == Part::Vertices || part == Part::Corners) {
    const std::int32_t vertex = topology.vertex_of(corner);
    if (mesh.features().vertex_kinds[vertex] != VertexKind::Smooth) return -1;
    ring = static_cast<std::int32_t>(topology.corners_at(vertex).size());
    if (part == Part::Corners) face = topology.face_size(topology.face_of(corner));
  } else if (part == Part::Faces) {
    ring = topology.face_size(topology.face_of(corner));
  } else if (part == Part::Edges && !mesh.is_sharp(corner)) {
    ring = 4;
  }
  return ring < table_size && face < table_size ? ring * table_size + face : -1;
}

// Adds an item to its bucket, which is made if there is none.
void add_item(const PatchPlace& place, const PatchPlan::Bucket& wanted, std::int64_t target,
              PatchPlan& plan) {
  std::size_t b = plan.buckets.size();
  const auto matches = [&](const PatchPlan::Bucket& bucket) {
    return bucket.class_index == wanted.class_index && bucket.has_results_of(wanted);
  };
  while (b > 0 && !matches(plan.buckets[b - 1])) --b;
  if (b == 0) {
    plan.buckets.push_back(wanted);
    b = plan.buckets.size();
  }
  ++plan.buckets[b - 1].item_count;
  plan.items.push_back(
      {place, static_cast<std::int32_t>(b - 1), static_cast<std::int32_t>(target)});
}

}  // namespace

PatchClasses::PatchClasses(const PatchNumbering& numbering, const PatchMesh& mesh,
                           Weights weights) {
  std::set<PatchClass> found;
  std::mutex mutex;
  for (const Part part : kParts) {
    auto count = static_cast<std::size_t>(numbering.item_count(part));
    // Corners without samples of their own still have facets.
    if (part == Part::Corners && numbering.level() == 1) count = mesh.topology().corner_count();
    parallel_for(count, 1 << 14, [&](std::size_t begin, std::size_t end) {
      std::set<PatchClass> here;
      std::array<bool, kTableSize * kTableSize> smooth{};
      PatchClass last{};
      for (std::size_t i = begin; i < end; ++i) {
        const auto item = static_cast<std::int64_t>(i);
        const std::int32_t known =
            smooth_place(mesh, part, numbering.item_corner(part, item), kTableSize);
        if (known >= 0) {
          smooth[known] = true;
          continue;
        }
        const PatchClass patch = place_of(mesh, numbering, part, item).patch;
        if (patch == last) continue;
        here.insert(patch);
        last = patch;
      }
      for (std::int32_t k = 0; k < kTableSize * kTableSize; ++k) {
        if (smooth[k]) here.insert({PatchKind::Smooth, k / kTableSize, 0, k % kTableSize});
      }
      const std::lock_guard lock(mutex);
      found.merge(here);
    });
  }
  // Facets around a row may be hidden ones.
  std::vector<std::int32_t> starts;
  for (std::int32_t v = 0; numbering.has_hidden() && v < mesh.topology().vertex_count(); ++v) {
    mesh.sector_starts(v, starts);
    for (const std::int32_t start : starts) found.insert(mesh.vertex_point(start).patch);
  }
  classes_.assign(found.begin(), found.end());
  table_.assign(kTableSize * kTableSize, -1);
  PatchTemplates templates(weights);
  for (const PatchClass& patch : classes_) {
    const auto index = static_cast<std::int32_t>(templates_.size());
    templates_.push_back(templates.make(patch, std::max(numbering.level(), 1)));
    max_column_count_ = std::max(max_column_count_, patch.column_count());
    if (patch.kind == PatchKind::Smooth && patch.ring_size < kTableSize &&
        patch.face_size < kTableSize) {
      table_[patch.ring_size * kTableSize + patch.face_size] = index;
    }
  }
}

std::int32_t PatchClasses::index_of(const PatchClass& patch) const {
  const std::int32_t known =
      patch.kind == PatchKind::Smooth ? smooth_index(patch.ring_size, patch.face_size) : -1;
  if (known >= 0) return known;
  const auto place = std::lower_bound(classes_.begin(), classes_.end(), patch);
  PLANISH_ASSERT(place != classes_.end() && *place == patch);
  return static_cast<std::int32_t>(place - classes_.begin());
}

std::vector<PatchTile> PatchPlanner::tiles() const {
  std::vector<PatchTile> tiles;
  const std::int64_t owned = std::max(numbering_.samples().owned_count(), 1);
  for (const Part part : kParts) {
    const std::int64_t count = numbering_.item_count(part);
    std::int64_t items = part == Part::Corners || part == Part::Trailing
                             ? std::clamp(kTileRows / owned, kMinTileItems, kTileItems)
                             : kTileItems;
    items =
        std::clamp(kTileIndices / classes_.max_column_count(), std::int64_t{kPatchLanes}, items);
    std::int64_t row = numbering_.first_row(part);
    for (std::int64_t first = 0; first < count; first += items) {
      const std::int64_t end = std::min(first + items, count);
      std::int64_t end_row = row + end - first;
      if (part == Part::Trailing) {
        end_row = row + (end - first) * numbering_.samples().trailing_count();
      } else if (part == Part::Corners) {
        end_row = end == count ? numbering_.end_row(part)
                               : numbering_.corner_row(static_cast<std::int32_t>(end));
      }
      if (end_row > row) tiles.push_back({part, first, end - first, row, end_row - row});
      row = end_row;
    }
  }
  return tiles;
}

void PatchPlanner::add(const PatchTile& tile, std::int64_t target, PatchPlan& plan) const {
  const PatchSamples& samples = numbering_.samples();
  const auto add = [&](const PatchPlace& place, std::int32_t first_sample,
                       std::int32_t sample_count, Results results, std::int64_t row) {
    add_item(place, {classes_.index_of(place.patch), first_sample, sample_count, results, 0},
             row - tile.first_row + target, plan);
  };
  std::int64_t row = tile.first_row;
  for (std::int64_t i = tile.first_item; i < tile.first_item + tile.item_count; ++i) {
    const std::int32_t corner = numbering_.item_corner(tile.part, i);
    if (tile.part == Part::Corners) {
      const std::int32_t count = numbering_.corner_row_count(corner);
      if (count > 0) {
        add(mesh_.corner_patch(corner), 0, count, Results::All, numbering_.corner_row(corner));
      }
      continue;
    }
    const PatchPlace place = place_of(mesh_, numbering_, tile.part, i);
    if (tile.part == Part::Trailing) {
      const std::int32_t count = samples.trailing_count();
      const std::int32_t other = mesh_.topology().ccw(corner);
      const bool is_sharp = mesh_.is_sharp(mesh_.topology().prev(corner));
      if (other < 0 || is_sharp)
        add(place, samples.first_trailing(), count, other < 0 ? Results::All : Results::Normals,
            row);
      if (other >= 0)
        add(mesh_.corner_patch(other), 0, count, is_sharp ? Results::Positions : Results::All, row);
      row += count;
    } else if (tile.part == Part::Further) {
      const bool is_edge = numbering_.is_further_edge(i);
      const std::int32_t other = numbering_.further_first(i);
      const PatchPlace first = point_at(mesh_, other, is_edge);
      // At a seam of texture coordinates alone both sides are one point of one plane.
      const bool is_sharp =
          is_edge ? mesh_.is_sharp(corner) : place.sector_start != first.sector_start;
      if (is_sharp) add(place, 0, 1, Results::Normals, row);
      add(first, 0, 1, is_sharp ? Results::Positions : Results::All, row);
      ++row;
    } else {
      add(place, 0, 1, Results::All, row++);
    }
  }
}

}  // namespace planish
