#include "planish/patches/patch_numbering.h"

#include <algorithm>
#include <iterator>

#include "planish/core/assert.h"
#include "planish/core/parallel.h"

namespace planish {

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

}  // namespace planish
