// Based on: Doo & Sabin 1978 for the step; the quad split as the dual of Doo-Sabin subdivision is
// a derivation of our own: every face of Q_l carries a Doo-Sabin control point, every vertex of Q_l
// is the limit point of the polygon of faces around it.
#include "support/doo_sabin_tables.h"

#include <algorithm>
#include <array>

#include "planish/core/guards.h"
#include "planish/doosabin/vertex_ring.h"

namespace planish::test {

namespace {

using OpenSubdiv::Far::TopologyLevel;

// Sharp edges of the next level: the halves of this level's.
std::vector<std::int32_t> split_sharp_edges(const TopologyLevel& parent, const TopologyLevel& child,
                                            const std::vector<std::int32_t>& sharp_of_edge) {
  std::vector<std::int32_t> children(static_cast<std::size_t>(child.GetNumEdges()), -1);
  for (std::size_t e = 0; e < sharp_of_edge.size(); ++e) {
    if (sharp_of_edge[e] < 0) continue;
    const auto halves = parent.GetEdgeChildEdges(static_cast<int>(e));
    for (int end = 0; end < 2; ++end) {
      children[halves[end]] = 2 * sharp_of_edge[e] + end;
      const auto half = child.GetEdgeVertices(halves[end]);
      const int vertex = parent.GetEdgeVertices(static_cast<int>(e))[end];
      PLANISH_ASSERT(half[0] == vertex || half[1] == vertex);
    }
  }
  return children;
}

std::vector<std::int32_t> invert(const std::vector<std::int32_t>& sharp_of_edge,
                                 std::size_t sharp_count) {
  std::vector<std::int32_t> edge_of_sharp(sharp_count);
  for (std::size_t e = 0; e < sharp_of_edge.size(); ++e) {
    if (sharp_of_edge[e] >= 0) edge_of_sharp[sharp_of_edge[e]] = static_cast<std::int32_t>(e);
  }
  return edge_of_sharp;
}

// Rings of a level >= 2: all faces of the level above are quads, and their corners this level's
// faces.
struct QuadRings {
  const SubdivisionChain& subdivision;
  int parent_level;
  const TopologyLevel& parent = subdivision.split().level(parent_level);
  const SubdivisionChain::StateLayout& layout = subdivision.state_layout(parent_level + 1);

  [[nodiscard]] static std::int32_t next(std::int32_t corner) {
    return (corner & ~3) | ((corner + 1) & 3);
  }
  [[nodiscard]] static std::int32_t prev(std::int32_t corner) {
    return (corner & ~3) | ((corner + 3) & 3);
  }
  [[nodiscard]] std::int32_t vertex_of(std::int32_t corner) const {
    return parent.GetFaceVertices(corner / 4)[corner % 4];
  }
  [[nodiscard]] std::int32_t edge_of(std::int32_t corner) const {
    return parent.GetFaceEdges(corner / 4)[corner % 4];
  }
  template <class Faces, class Places>
  static void append_corners(const Faces& faces, const Places& places, VertexRing& ring) {
    for (int k = 0; k < faces.size(); ++k) ring.faces.push_back(4 * faces[k] + places[k]);
  }
  // The curve control point of the half of sharp edge `sharp` (of the parent level) at `vertex`.
  [[nodiscard]] std::int32_t curve_point(std::int32_t edge, std::int32_t sharp,
                                         std::int32_t vertex) const {
    const int end = parent.GetEdgeVertices(edge)[0] == vertex ? 0 : 1;
    return static_cast<std::int32_t>(layout.first_sharp) + 2 * sharp + end;
  }

  void around(std::int32_t vertex, VertexRing& ring) const {
    const std::int32_t vertex_count = parent.GetNumVertices(), face_count = parent.GetNumFaces();
    if (vertex < vertex_count) {
      around_vertex(vertex, ring);
    } else if (vertex < vertex_count + face_count) {
      const std::int32_t first = 4 * (vertex - vertex_count);
      ring.faces = {first, first + 1, first + 2, first + 3};
    } else {
      around_edge(vertex - vertex_count - face_count, ring);
    }
  }
  void around_edge(std::int32_t edge, VertexRing& ring) const;
  void around_vertex(std::int32_t vertex, VertexRing& ring) const;
  void gather_sectors(std::int32_t vertex, VertexRing& ring) const;
};

void QuadRings::around_edge(std::int32_t edge, VertexRing& ring) const {
  append_corners(parent.GetEdgeFaces(edge), parent.GetEdgeFaceLocalIndices(edge), ring);
  const std::size_t count = ring.faces.size();
  const std::array<std::int32_t, 2> tails{ring.faces.front(), ring.faces.back()};
  // A face runs along the edge from its corner to the next: seen from the edge's midpoint, the
  // child at the far corner comes first.
  ring.faces.clear();
  for (std::size_t k = 0; k < count; ++k) {
    ring.faces.push_back(next(tails[k]));
    ring.faces.push_back(tails[k]);
  }
  const std::int32_t sharp = subdivision.sharp_of(parent_level, edge);
  if (sharp < 0) return;
  ring.kind = VertexKind::Crease;
  for (std::size_t k = 0; k < count; ++k) {
    ring.sectors.push_back({static_cast<std::int32_t>(2 * k), 2,
                            curve_point(edge, sharp, vertex_of(next(tails[k]))),
                            curve_point(edge, sharp, vertex_of(tails[k]))});
  }
}

void QuadRings::around_vertex(std::int32_t vertex, VertexRing& ring) const {
  append_corners(parent.GetVertexFaces(vertex), parent.GetVertexFaceLocalIndices(vertex), ring);
  const SharpFeatures& features = subdivision.features();
  const bool from_mesh = vertex < static_cast<int>(features.vertex_kinds.size());
  ring.kind = from_mesh ? features.vertex_kinds[vertex] : VertexKind::Smooth;
  if (from_mesh && ring.kind == VertexKind::Smooth) return;
  if (ring.kind == VertexKind::Corner) {
    ring.corner_point =
        static_cast<std::int32_t>(layout.first_corner) + features.corner_of_vertex[vertex];
  }
  if (subdivision.has_sharp_edges()) gather_sectors(vertex, ring);
}

// Sectors of a vertex whose faces are gathered; turns the ring so that a sector begins at its
// first face.
void QuadRings::gather_sectors(std::int32_t vertex, VertexRing& ring) const {
  const auto sharp_of = [&](std::int32_t edge) { return subdivision.sharp_of(parent_level, edge); };
  const auto first = std::ranges::find_if(
      ring.faces, [&](std::int32_t corner) { return sharp_of(edge_of(corner)) >= 0; });
  if (first == ring.faces.end()) return;  // smooth, or a tagged vertex in a smooth neighbourhood
  std::ranges::rotate(ring.faces, first);
  if (ring.kind == VertexKind::Dart) {
    ring.dart_face = 0;
    return;
  }
  if (ring.kind == VertexKind::Smooth) ring.kind = VertexKind::Crease;  // born on a sharp edge

  for (std::size_t k = 0; k < ring.faces.size(); ++k) {
    const std::int32_t leading = edge_of(ring.faces[k]);
    const std::int32_t trailing = edge_of(prev(ring.faces[k]));
    const std::int32_t sharp = sharp_of(leading), trailing_sharp = sharp_of(trailing);
    if (sharp >= 0) {
      ring.sectors.push_back(
          {static_cast<std::int32_t>(k), 0, curve_point(leading, sharp, vertex), -1});
      if (ring.kind == VertexKind::Corner) {
        // Descendants of a sharp edge keep its number in the high bits.
        ring.sectors.back().corner = subdivision.features().corner_sectors.at(
            SharpFeatures::sector_key(vertex, sharp >> parent_level));
      }
    }
    VertexRing::Sector& sector = ring.sectors.back();
    ++sector.count;
    if (trailing_sharp >= 0) sector.curve1 = curve_point(trailing, trailing_sharp, vertex);
  }
  for (const VertexRing::Sector& sector : ring.sectors) PLANISH_ASSERT(sector.curve1 >= 0);
}

// Rows of the state of level + 1, level >= 1.
struct RefinementEmitter {
  const SubdivisionChain& subdivision;
  int level;
  SubdivisionChain::StateLayout own = subdivision.state_layout(level);
  SubdivisionChain::StateLayout finer = subdivision.state_layout(level + 1);
  VertexRing ring{};
  std::vector<double> scratch{};

  void face_point(std::int32_t child, StencilRow& row) {
    const std::int32_t face = child / 4;
    const auto vertices = subdivision.split().level(level).GetFaceVertices(face);
    gather_ring(subdivision, level, vertices[child % 4], ring);
    const auto place = std::find(ring.faces.begin(), ring.faces.end(), face) - ring.faces.begin();
    add_refined_face(subdivision.face_weights(), ring, static_cast<std::int32_t>(place), 1.0,
                     scratch, row);
  }

  void curve_point(std::int32_t sharp_child, StencilRow& row) {
    const TopologyLevel& topology = subdivision.split().level(level);
    const int edge = subdivision.edge_of(level, sharp_child / 2);
    gather_ring(subdivision, level, topology.GetEdgeVertices(edge)[sharp_child % 2], ring);
    add_refined_curve_point(subdivision.face_weights(), ring,
                            static_cast<std::int32_t>(own.first_sharp) + sharp_child / 2, scratch,
                            row);
  }

  void operator()(std::int32_t index, StencilRow& row) {
    if (index >= finer.first_corner) {
      row.add(static_cast<std::int32_t>(own.first_corner + index - finer.first_corner), 1.0);
    } else if (index >= finer.first_sharp) {
      curve_point(static_cast<std::int32_t>(index - finer.first_sharp), row);
    } else {
      face_point(index, row);
    }
  }
};

// `limit_row(i)` is the number of row i.
template <class LimitRow>
StencilTable make_limit_table(const SubdivisionChain& subdivision, const LimitRows& limit_rows,
                              RowRange rows, const LimitRow& limit_row) {
  const auto source_count =
      static_cast<std::int32_t>(subdivision.state_layout(limit_rows.state_level()).size);
  return build_rows(source_count, rows, Derivatives::Yes, [&] {
    return [&, ring = VertexRing{}](std::int32_t index, StencilRow& row) mutable {
      const LimitRows::Place place = limit_rows.place(limit_row(index));
      gather_ring(subdivision, limit_rows.state_level(), place.vertex, ring);
      add_limit(ring, place.sector, row);
    };
  });
}

}  // namespace

SubdivisionChain::SubdivisionChain(const QuadSplit& split, const SharpFeatures& features,
                                   Weights weights)
    : Subdivision(split.topology(), features, weights), split_(split) {
  const std::vector<LevelCounts> counts = split.counts_to(split.level_count() + 1);
  for (std::size_t l = 0; l < counts.size(); ++l) {
    const std::int64_t first_corner =
        counts[l].faces + (static_cast<std::int64_t>(features.sharp_edge_count) << l);
    layouts_.push_back({counts[l].faces, first_corner, first_corner + features.corner_count});
  }
  if (!has_sharp_edges()) return;
  sharp_of_edge_ = {features.sharp_of_edge};
  auto count = static_cast<std::size_t>(features.sharp_edge_count);
  edge_of_sharp_ = {invert(sharp_of_edge_[0], count)};
  for (int l = 1; l < split.level_count(); ++l) {
    sharp_of_edge_.push_back(
        split_sharp_edges(split.level(l - 1), split.level(l), sharp_of_edge_.back()));
    edge_of_sharp_.push_back(invert(sharp_of_edge_.back(), count *= 2));
  }
}

void gather_ring(const SubdivisionChain& subdivision, int level, std::int32_t vertex,
                 VertexRing& ring) {
  PLANISH_ASSERT(level >= 1);
  if (level == 1) {
    planish::gather_ring(subdivision, vertex, ring);
    return;
  }
  ring.kind = VertexKind::Smooth;
  ring.faces.clear();
  ring.sectors.clear();
  ring.corner_point = ring.dart_face = -1;
  QuadRings{subdivision, level - 1}.around(vertex, ring);
}

StencilTable step_table(const SubdivisionChain& subdivision, int level, RowRange rows) {
  if (level == 1) return first_step_table(subdivision, rows);
  const auto source_count = static_cast<std::int32_t>(subdivision.state_layout(level - 1).size);
  return build_rows(source_count, rows, Derivatives::No, [&] {
    return RefinementEmitter{subdivision, level - 1};
  });
}

StencilTable step_table(const SubdivisionChain& subdivision, int level) {
  return step_table(subdivision, level, {0, subdivision.state_layout(level).size});
}

LimitRows::LimitRows(const SubdivisionChain& subdivision, int level)
    : subdivision_(subdivision), state_level_(std::max(level, 1)) {
  const std::int64_t vertex_count = subdivision.split().counts(level).vertices;
  std::vector<Place> extra;
  if (subdivision.features().interior_sharp_edge_count > 0) {
    VertexRing ring;
    for (std::int32_t v = 0; v < vertex_count; ++v) {
      gather_ring(subdivision, state_level_, v, ring);
      for (std::size_t s = 1; s < ring.sectors.size(); ++s) {
        extra.push_back({v, static_cast<std::int32_t>(s)});
      }
    }
  }
  sectors_ = {vertex_count, std::move(extra)};
}

std::int32_t LimitRows::row_of(std::int32_t vertex, std::int32_t face, VertexRing& scratch) const {
  if (!sectors_.is_split(vertex)) return vertex;
  gather_ring(subdivision_, state_level_, vertex, scratch);
  for (std::size_t s = 0; s < scratch.sectors.size(); ++s) {
    const VertexRing::Sector& sector = scratch.sectors[s];
    const auto begin = scratch.faces.begin() + sector.first;
    if (std::find(begin, begin + sector.count, face) == begin + sector.count) continue;
    return sectors_.row(vertex, static_cast<std::int32_t>(s));
  }
  PLANISH_ASSERT(!"the face is not around the vertex");
  return -1;
}

std::vector<std::int32_t> LimitRows::in_order_of(const PatchNumbering& numbering) const {
  const MeshTopology& topology = subdivision_.topology();
  std::vector<std::int32_t> rows(static_cast<std::size_t>(numbering.row_count()), -1);
  VertexRing ring;
  if (numbering.level() == 0) {
    for (std::int32_t c = 0; c < topology.corner_count(); ++c)
      rows[numbering.vertex_row(c)] = row_of(topology.vertex_of(c), c, ring);
    return rows;
  }
  const auto& level = subdivision_.split().level(numbering.level());
  const PatchCells cells(numbering.level());
  const std::int32_t side = numbering.samples().side() + 1;
  std::vector<std::int32_t> grid(static_cast<std::size_t>(side * side));
  std::int32_t face = 0;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
    numbering.grid(c, grid.data());
    for (const auto& cell : cells.of(topology, c)) {
      const auto vertices = level.GetFaceVertices(face);
      for (int k = 0; k < 4; ++k) rows[grid[cell[k]]] = row_of(vertices[k], face, ring);
      ++face;
    }
  }
  return rows;
}

StencilTable limit_table(const SubdivisionChain& subdivision, const LimitRows& limit_rows,
                         RowRange rows) {
  return make_limit_table(subdivision, limit_rows, rows, [&](std::int32_t i) { return i; });
}

StencilTable limit_table(const SubdivisionChain& subdivision, const LimitRows& limit_rows) {
  return limit_table(subdivision, limit_rows, {0, limit_rows.count()});
}

StencilTable limit_table(const SubdivisionChain& subdivision, const LimitRows& limit_rows,
                         std::span<const std::int32_t> order) {
  return make_limit_table(subdivision, limit_rows, {0, static_cast<std::int64_t>(order.size())},
                          [&](std::int32_t i) { return order[i]; });
}

namespace {

QuadSplit& refined(QuadSplit& split, int levels) {
  split.refine(levels);
  return split;
}

}  // namespace

ChainCase::ChainCase(const PolygonMesh& given, Weights weights, int levels,
                     const SharpFeatureOptions& sharp)
    : mesh(given),
      split(mesh),
      features(find_sharp_features(mesh, split.topology(), mesh.positions, sharp)),
      subdivision(refined(split, levels), features, weights) {}

std::vector<glm::dvec3> applied(const StencilTable& table, std::span<const glm::dvec3> source) {
  const auto view = table.view();
  std::vector<glm::dvec3> result(static_cast<std::size_t>(view.row_count()), glm::dvec3(0.0));
  for (std::int32_t i = 0; i < view.row_count(); ++i)
    for (std::int32_t k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k)
      result[i] += view.weights[k] * source[view.indices[k]];
  return result;
}

}  // namespace planish::test
