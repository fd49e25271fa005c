#include "planish/patches/patch_plan.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <mutex>
#include <set>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/patches/bezier_net.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/patches/patch_kernel.h"

namespace planish {
namespace {

// A quarter's sample and its place in the whole patch.
struct QuarterSample {
  std::size_t of_quarter, of_patch;
};

std::vector<QuarterSample> samples_of(int quarter, std::int32_t n) {
  std::vector<QuarterSample> samples;
  for (std::int32_t b = 0; b <= n; ++b) {
    for (std::int32_t a = 0; a <= n; ++a) {
      const int lies_in = 2 * b <= n ? (2 * a <= n ? 0 : 1) : (2 * a <= n ? 3 : 2);
      if (lies_in != quarter) continue;
      const auto [u, v] = seen_from(quarter, n, a, b);
      samples.push_back({static_cast<std::size_t>(v * (n / 2 + 1) + u),
                         static_cast<std::size_t>(b * (n + 1) + a)});
    }
  }
  return samples;
}

// result (columns) += weights times some rows, added in their order.
void add_rows(std::span<const double> weights, const double* rows, std::size_t columns,
              double* result) {
  for (const double weight : weights) {
    if (weight != 0) {
      for (std::size_t j = 0; j < columns; ++j) result[j] += weight * rows[j];
    }
    rows += columns;
  }
}

}  // namespace

const PatchTemplates::Grid& PatchTemplates::grid(const PatchClass& patch, int level) {
  const auto found = grids_.find({patch, level});
  if (found != grids_.end()) return *found->second;

  const PatchRings rings(patch);
  const auto columns = static_cast<std::size_t>(patch.column_count());
  auto result = std::make_unique<Grid>();
  if (level == 1) {
    for (const int corner : {0, 1, 3, 2}) {
      const PatchRowsOfWeights rows = rings.limit(corner);
      result->insert(result->end(), rows.begin(), rows.end());
    }
  } else {
    const std::int32_t n = PatchSamples(level).side();
    result->resize(static_cast<std::size_t>((n + 1) * (n + 1)) * 3 * columns);
    for (int q = 0; q < 4; ++q) add_quarter(rings, q, level, columns, *result);
  }
  return *(grids_[{patch, level}] = std::move(result));
}

// The quarter's template times its points, some of them at a time.
void PatchTemplates::add_quarter(const PatchRings& rings, int quarter, int level,
                                 std::size_t columns, Grid& result) {
  constexpr std::size_t kPointsAtOnce = 64;
  const Grid& weights = grid(rings.quarter_class(quarter), level - 1);
  const auto inner = static_cast<std::size_t>(rings.quarter_class(quarter).column_count());
  const std::vector<QuarterSample> samples = samples_of(quarter, PatchSamples(level).side());
  std::vector<double> points;
  std::size_t first = 0;
  const auto add_points = [&] {
    const std::size_t count = points.size() / columns;
    parallel_each(samples.size(), 16, [&](std::size_t s) {
      for (std::size_t r = 0; r < 3; ++r) {
        const std::size_t row = samples[s].of_quarter * 3 + r;
        add_rows({weights.data() + row * inner + first, count}, points.data(), columns,
                 result.data() + (samples[s].of_patch * 3 + r) * columns);
      }
    });
    first += count;
    points.clear();
  };
  rings.visit_quarter_points(quarter, weights_, [&](std::span<const double> row) {
    points.insert(points.end(), row.begin(), row.end());
    if (points.size() == kPointsAtOnce * columns) add_points();
  });
  add_points();
}

PatchTemplate PatchTemplates::make(const PatchClass& patch, int level) {
  const auto columns = static_cast<std::size_t>(patch.column_count());
  PatchTemplate result;
  result.column_count = patch.column_count() - 1;
  const auto add_sample = [&](const double* rows, std::size_t sample) {
    double* to = result.weights.data() + sample * 3 * (columns - 1);
    for (std::size_t row = 0; row < 3; ++row) {
      std::copy(rows + row * columns + 1, rows + (row + 1) * columns, to + row * (columns - 1));
    }
  };
  if (patch.is_limit_only()) {
    result.sample_count = 1;
    result.weights.resize(3 * (columns - 1));
    add_sample(PatchRings(patch).limit(0).data(), 0);
    return result;
  }
  const PatchSamples samples(level);
  const Grid& whole = grid(patch, level);
  const std::int32_t n = samples.side();
  result.sample_count = samples.count();
  result.weights.resize(static_cast<std::size_t>(samples.count()) * 3 * (columns - 1));
  for (std::int32_t b = 0; b <= n; ++b) {
    for (std::int32_t a = 0; a <= n; ++a) {
      add_sample(whole.data() + static_cast<std::size_t>(b * (n + 1) + a) * 3 * columns,
                 static_cast<std::size_t>(samples.index(a, b)));
    }
  }
  return result;
}

namespace {

// Stands for an item of the further part until the part's place is known, and back; -1 is no row.
template <class Number>
std::int32_t further_mark(Number item) {
  return -2 - static_cast<std::int32_t>(item);
}

}  // namespace

PatchCells::PatchCells(int level) {
  const std::int32_t n = PatchSamples(level).side();
  struct Place {
    std::int32_t a, b;
  };
  const std::array<Place, 4> whole = {{{0, 0}, {n, 0}, {n, n}, {0, n}}};
  for (int turn = 0; turn < 4; ++turn) {
    for (std::int32_t path = 0; path < n * n; ++path) {
      std::array<Place, 4> places;
      for (int k = 0; k < 4; ++k) places[(k + turn) % 4] = whole[k];
      for (int l = level - 2; l >= 0; --l) {
        const Place kept = places[(path >> (2 * l)) & 3];
        for (Place& place : places) place = {(place.a + kept.a) / 2, (place.b + kept.b) / 2};
      }
      std::array<std::int32_t, 4>& cell = cells_[turn].emplace_back();
      for (int k = 0; k < 4; ++k) cell[k] = places[k].b * (n + 1) + places[k].a;
    }
  }
}

PatchNumbering::PatchNumbering(const MeshTopology& topology, int level,
                               std::span<const std::uint8_t> hidden)
    : topology_(topology),
      level_(level),
      samples_(std::max(level, 1)),
      owned_count_(level == 0 ? 0 : samples_.owned_count()),
      hidden_(hidden) {}

bool is_uv_seam(const MeshTopology& topology, std::span<const std::int32_t> corner_uvs,
                std::int32_t corner) {
  const std::int32_t other = topology.twin(corner);
  return other < 0 || corner_uvs[corner] != corner_uvs[topology.next(other)] ||
         corner_uvs[topology.next(corner)] != corner_uvs[other];
}

PatchNumbering::PatchNumbering(const PatchMesh& mesh, int level,
                               std::span<const std::uint8_t> hidden,
                               std::span<const std::int32_t> corner_uvs)
    : PatchNumbering(mesh.topology(), level, hidden) {
  number_vertices(mesh, corner_uvs);
  number_rest(!mesh.features().sharp_of_edge.empty() || !corner_uvs.empty(),
              [&](std::int32_t corner) {
                return mesh.is_sharp(corner) ||
                       (!corner_uvs.empty() && is_uv_seam(topology_, corner_uvs, corner));
              });
}

PatchNumbering::PatchNumbering(const MeshTopology& topology,
                               std::span<const std::int32_t> corner_uvs, std::int32_t uv_count,
                               int level, std::span<const std::uint8_t> hidden)
    : PatchNumbering(topology, level, hidden) {
  has_vertex_items_ = false;
  vertex_rows_.assign(corner_uvs.begin(), corner_uvs.end());
  first_[1] = uv_count;
  number_rest(true, [&](std::int32_t corner) { return is_uv_seam(topology, corner_uvs, corner); });
}

// Rows of vertices in their first visible sectors or charts, and the further ones.
void PatchNumbering::number_vertices(const PatchMesh& mesh,
                                     std::span<const std::int32_t> corner_uvs) {
  const std::int32_t vertex_count = topology_.vertex_count();
  if (hidden_.empty() && corner_uvs.empty() && mesh.features().interior_sharp_edge_count == 0) {
    first_[1] = vertex_count;
    return;
  }
  vertex_rows_.resize(static_cast<std::size_t>(topology_.corner_count()));
  std::vector<std::int32_t> starts;
  for (std::int32_t v = 0; v < vertex_count; ++v) {
    const auto corners = topology_.corners_at(v);
    if (corners.empty()) continue;
    mesh.sector_starts(v, starts);
    const bool has_sectors = starts.size() > 1;
    // Whether another row stands for a corner than for the one clockwise of it.
    const auto begins = [&](std::int32_t corner) {
      if (has_sectors && mesh.is_sharp(corner)) return true;
      if (corner_uvs.empty()) return false;
      const std::int32_t before = topology_.cw(corner);
      return before >= 0 && corner_uvs[before] != corner_uvs[corner];
    };
    if (!corner_uvs.empty()) {
      starts.clear();
      std::ranges::copy_if(corners, std::back_inserter(starts), begins);
      // From the boundary on, or all around.
      if (starts.empty() ||
          (topology_.cw(corners.front()) < 0 && starts.front() != corners.front()))
        starts.insert(starts.begin(), corners.front());
    }
    bool has_row = false;
    for (const std::int32_t start : starts) {
      const auto for_sector = [&](const auto& visit) {
        std::int32_t c = start;
        do {
          visit(c);
          c = topology_.ccw(c);
        } while (c >= 0 && c != start && !begins(c));
      };
      bool visible = false;
      for_sector([&](std::int32_t c) { visible |= !is_hidden(topology_.face_of(c)); });
      std::int32_t row = -1;
      if (visible && !has_row) {
        row = static_cast<std::int32_t>(vertex_items_.size());
        vertex_items_.push_back(start);
        has_row = true;
      } else if (visible) {
        row = further_mark(further_corners_.size());
        further_corners_.push_back(start);
        further_first_.push_back(vertex_items_.back());
      }
      for_sector([&](std::int32_t c) { vertex_rows_[c] = row; });
    }
  }
  first_[1] = static_cast<std::int64_t>(vertex_items_.size());
}

void PatchNumbering::number_rest(bool has_cuts, const IsCut& is_cut) {
  further_vertices_ = static_cast<std::int64_t>(further_corners_.size());
  std::int64_t faces = topology_.face_count(), edges = topology_.edge_count();
  std::int64_t corners = std::int64_t{topology_.corner_count()} * owned_count_;
  if (level_ == 0) {
    faces = edges = corners = 0;
  } else if (!hidden_.empty() || has_cuts) {
    if (!hidden_.empty()) {
      face_rows_.assign(static_cast<std::size_t>(topology_.face_count()), -1);
      for (std::int32_t f = 0; f < topology_.face_count(); ++f) {
        if (is_hidden(f)) continue;
        face_rows_[f] = static_cast<std::int32_t>(face_items_.size());
        face_items_.push_back(topology_.first_corner(f));
      }
      faces = static_cast<std::int64_t>(face_items_.size());
    }
    first_[2] = first_[1] + faces;
    number_edges(is_cut);
    if (!edge_rows_.empty()) edges = static_cast<std::int64_t>(edge_items_.size());
  }
  first_[2] = first_[1] + faces;
  first_[3] = first_[2] + edges;
  if (!hidden_.empty() && level_ > 0) {
    number_corners(is_cut);
    corners = corner_rows_.back() - first_[3];
  }
  first_[4] = first_[3] + corners;
  if (has_cuts && samples_.trailing_count() > 0 && level_ > 0) {
    for (std::int32_t c = 0; c < topology_.corner_count(); ++c) {
      if (is_cut(topology_.prev(c)) && !is_hidden(topology_.face_of(c))) {
        trailing_corners_.push_back(c);
      }
    }
  }
  first_[5] =
      first_[4] + static_cast<std::int64_t>(trailing_corners_.size()) * samples_.trailing_count();
  first_[6] = first_[5] + static_cast<std::int64_t>(further_corners_.size());
  place_further();
}

// The side of an edge that has the midpoint's first row: the first one that is seen, or -1.
std::int32_t PatchNumbering::visible_side(std::int32_t edge) const {
  const std::int32_t first = topology_.corner_of(edge), second = topology_.twin(first);
  if (!is_hidden(topology_.face_of(first))) return first;
  return second >= 0 && !is_hidden(topology_.face_of(second)) ? second : -1;
}

void PatchNumbering::number_edges(const IsCut& is_cut) {
  // Only where rows are not the edges' own numbers.
  bool needed = !hidden_.empty();
  for (std::int32_t e = 0; e < topology_.edge_count() && !needed; ++e) {
    needed = !topology_.is_boundary_edge(e) && is_cut(topology_.corner_of(e));
  }
  if (!needed) return;
  edge_rows_.resize(static_cast<std::size_t>(topology_.corner_count()));
  for (std::int32_t e = 0; e < topology_.edge_count(); ++e) {
    const std::int32_t first = topology_.corner_of(e), second = topology_.twin(first);
    const std::int32_t side = visible_side(e);
    std::int32_t row = -1;
    if (side >= 0) {
      row = static_cast<std::int32_t>(first_[2]) + static_cast<std::int32_t>(edge_items_.size());
      edge_items_.push_back(side);
    }
    edge_rows_[first] = row;
    if (second < 0) continue;
    edge_rows_[second] = row;
    if (side == first && is_cut(first) && !is_hidden(topology_.face_of(second))) {
      edge_rows_[second] = further_mark(further_corners_.size());
      further_corners_.push_back(second);
      further_first_.push_back(first);
    }
  }
}

// A corner of a hidden face still owns its half of the leading edge where its neighbour is seen.
void PatchNumbering::number_corners(const IsCut& is_cut) {
  corner_rows_.resize(static_cast<std::size_t>(topology_.corner_count()) + 1);
  std::int64_t row = first_[3];
  for (std::int32_t c = 0; c < topology_.corner_count(); ++c) {
    corner_rows_[c] = static_cast<std::int32_t>(row);
    if (!is_hidden(topology_.face_of(c))) {
      row += owned_count_;
      continue;
    }
    const std::int32_t other = topology_.twin(c);
    const bool shared = other >= 0 && !is_hidden(topology_.face_of(other));
    // Across a cut the neighbour has rows of its own.
    if (shared && !is_cut(c)) row += samples_.leading_count();
  }
  corner_rows_.back() = static_cast<std::int32_t>(row);
}

void PatchNumbering::place_further() {
  const auto first = static_cast<std::int32_t>(first_row(Part::Further));
  if (further_corners_.empty()) return;
  for (RawVector<std::int32_t>* rows : {&vertex_rows_, &edge_rows_}) {
    if (rows == &vertex_rows_ && !has_vertex_items_) continue;
    parallel_each(rows->size(), 1 << 16, [&](std::size_t c) {
      if ((*rows)[c] < -1) (*rows)[c] = first + further_mark((*rows)[c]);
    });
  }
}

std::int64_t PatchNumbering::item_count(Part part) const {
  switch (part) {
    case Part::Corners:
      return owned_count_ == 0 ? 0 : topology_.corner_count();
    case Part::Trailing:
      return static_cast<std::int64_t>(trailing_corners_.size());
    default:
      return end_row(part) - first_row(part);
  }
}

std::int32_t PatchNumbering::item_corner(Part part, std::int64_t item) const {
  const auto i = static_cast<std::int32_t>(item);
  switch (part) {
    case Part::Vertices:
      return vertex_items_.empty() ? topology_.corners_at(i).front() : vertex_items_[i];
    case Part::Faces:
      return face_items_.empty() ? topology_.first_corner(i) : face_items_[i];
    case Part::Edges:
      return edge_items_.empty() ? topology_.corner_of(i) : edge_items_[i];
    case Part::Corners:
      return i;
    case Part::Trailing:
      return trailing_corners_[i];
    case Part::Further:
      return further_corners_[i];
  }
  return -1;
}

std::int32_t PatchNumbering::corner_of_row(std::int64_t row) const {
  if (corner_rows_.empty()) {
    return static_cast<std::int32_t>((row - first_row(Part::Corners)) / owned_count_);
  }
  return static_cast<std::int32_t>(std::upper_bound(corner_rows_.begin(), corner_rows_.end(), row) -
                                   corner_rows_.begin() - 1);
}

std::int32_t PatchNumbering::trailing_row(std::int32_t corner) const {
  if (!trailing_corners_.empty()) {
    const auto found = std::lower_bound(trailing_corners_.begin(), trailing_corners_.end(), corner);
    if (found != trailing_corners_.end() && *found == corner) {
      return static_cast<std::int32_t>(first_row(Part::Trailing) +
                                       (found - trailing_corners_.begin()) *
                                           samples_.trailing_count());
    }
  }
  return static_cast<std::int32_t>(corner_row(topology_.ccw(corner)));
}

std::int32_t PatchNumbering::row(std::int32_t corner, std::int32_t a, std::int32_t b) const {
  const std::int32_t n = samples_.side();
  if (a == 0)
    return b == 0   ? vertex_row(corner)
           : b == n ? edge_row(topology_.prev(corner))
                    : trailing_row(corner) + b - 1;
  if (b == 0) {
    return a == n ? edge_row(corner) : static_cast<std::int32_t>(corner_row(corner)) + a - 1;
  }
  if (b < n) {
    return static_cast<std::int32_t>(corner_row(corner)) + n - 1 + (b - 1) * n + a - 1;
  }
  if (a == n) return face_row(topology_.face_of(corner));
  return static_cast<std::int32_t>(corner_row(topology_.prev(corner))) + n - 1 + (a - 1) * n + n -
         1;
}

void PatchNumbering::grid(std::int32_t corner, std::int32_t* rows) const {
  const std::int32_t n = samples_.side();
  for (std::int32_t b = 0; b <= n; ++b, rows += n + 1) {
    rows[0] = row(corner, 0, b);
    rows[n] = row(corner, n, b);
    if (n == 1) continue;
    const std::int32_t first = row(corner, 1, b), step = b == n ? n : 1;
    for (std::int32_t a = 1; a < n; ++a) rows[a] = first + (a - 1) * step;
  }
}

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
