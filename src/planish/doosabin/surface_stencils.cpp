// Based on: Doo & Sabin 1978 for the step; the quad split as the dual of Doo-Sabin subdivision is
// a derivation of our own: every face of Q_l carries a Doo-Sabin control point, every vertex of Q_l
// is the limit point of the polygon of faces around it.
#include "planish/doosabin/surface_stencils.h"

#include <algorithm>
#include <utility>

#include "planish/core/assert.h"
#include "planish/doosabin/sector_rules.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

namespace {

using OpenSubdiv::Far::TopologyLevel;

struct FirstStepEmitter {
  const PolygonMesh& mesh;
  const Subdivision& subdivision;
  std::vector<double> scratch{};

  void corner_point(std::int32_t face, std::int32_t corner, double scale, StencilRow& row) {
    const auto vertices = mesh.face(face);
    const auto m = static_cast<std::int32_t>(vertices.size());
    const auto c = subdivision.face_weights(m, scratch);
    for (std::int32_t j = 0; j < m; ++j) row.add(vertices[(corner + j) % m], scale * c[j]);
  }

  void curve_point(std::int32_t sharp_child, StencilRow& row) {
    const MeshTopology& topology = subdivision.split().topology();
    const std::int32_t edge = subdivision.edge_of_sharp(0, sharp_child / 2);
    const auto [v0, v1] = topology.edge_vertices(edge);
    const std::int32_t own = sharp_child % 2 == 0 ? v0 : v1;
    const std::int32_t other = sharp_child % 2 == 0 ? v1 : v0;
    if (subdivision.features().vertex_kinds[own] != VertexKind::Dart) {
      row.add(own, 0.75);
      row.add(other, 0.25);
      return;
    }
    const std::int32_t corner = topology.corner_of(edge);
    for (const std::int32_t face :
         {topology.face_of(corner), topology.face_of(topology.twin(corner))}) {
      const auto vertices = mesh.face(face);
      const auto place = std::find(vertices.begin(), vertices.end(), own) - vertices.begin();
      corner_point(face, static_cast<std::int32_t>(place), 0.5, row);
    }
  }

  void operator()(std::int32_t index, StencilRow& row) {
    const auto& layout = subdivision.state_layout(1);
    if (index >= layout.first_corner) {
      row.add(subdivision.features().corner_vertices[index - layout.first_corner], 1.0);
    } else if (index >= layout.first_sharp) {
      curve_point(static_cast<std::int32_t>(index - layout.first_sharp), row);
    } else {
      const MeshTopology& topology = subdivision.split().topology();
      corner_point(topology.face_of(index), topology.place_of(index), 1.0, row);
    }
  }
};

struct RefinementEmitter {
  const Subdivision& subdivision;
  int level;
  VertexRing ring{};
  std::vector<double> scratch{};

  void face_point(std::int32_t child, StencilRow& row) {
    const std::int32_t face = child / 4;
    const auto vertices = subdivision.split().level(level).GetFaceVertices(face);
    gather_ring(subdivision, level, vertices[child % 4], ring);
    const auto place = std::find(ring.faces.begin(), ring.faces.end(), face) - ring.faces.begin();
    add_refined_face(subdivision.all_face_weights(), ring, static_cast<std::int32_t>(place), 1.0,
                     scratch, row);
  }

  void curve_point(std::int32_t sharp_child, StencilRow& row) {
    const TopologyLevel& topology = subdivision.split().level(level);
    const int edge = subdivision.edge_of_sharp(level, sharp_child / 2);
    const int vertex = topology.GetEdgeVertices(edge)[sharp_child % 2];
    const auto first_sharp = static_cast<std::int32_t>(subdivision.state_layout(level).first_sharp);
    const std::int32_t own = first_sharp + sharp_child / 2;
    gather_ring(subdivision, level, vertex, ring);
    add_refined_curve_point(subdivision.all_face_weights(), ring, own, scratch, row);
  }

  void operator()(std::int32_t index, StencilRow& row) {
    const auto& layout = subdivision.state_layout(level + 1);
    if (index >= layout.first_corner) {
      const auto corner = index - layout.first_corner;
      row.add(static_cast<std::int32_t>(subdivision.state_layout(level).first_corner + corner),
              1.0);
    } else if (index >= layout.first_sharp) {
      curve_point(static_cast<std::int32_t>(index - layout.first_sharp), row);
    } else {
      face_point(index, row);
    }
  }
};

}  // namespace

StencilTable<double> first_step_table(const PolygonMesh& mesh, const Subdivision& subdivision,
                                      RowRange rows) {
  return StencilTable<double>(mesh.vertex_count(),
                              build_rows(rows.first, rows.count, Derivatives::No, [&] {
                                return FirstStepEmitter{mesh, subdivision};
                              }));
}

StencilTable<double> refinement_table(const Subdivision& subdivision, int level, RowRange rows) {
  const auto source_count = static_cast<std::int32_t>(subdivision.state_layout(level).size);
  return StencilTable<double>(source_count,
                              build_rows(rows.first, rows.count, Derivatives::No, [&] {
                                return RefinementEmitter{subdivision, level};
                              }));
}

LimitRows::LimitRows(const Subdivision& subdivision, int level, std::int64_t vertex_count)
    : subdivision_(subdivision), level_(level) {
  std::vector<Place> extra;
  if (subdivision.features().interior_sharp_edge_count > 0) {
    VertexRing ring;
    for (std::int32_t v = 0; v < vertex_count; ++v) {
      gather_ring(subdivision, level, v, ring);
      for (std::size_t s = 1; s < ring.sectors.size(); ++s) {
        extra.push_back({v, static_cast<std::int32_t>(s)});
      }
    }
  }
  sectors_ = {vertex_count, std::move(extra)};
}

std::int32_t LimitRows::row_of(std::int32_t vertex, std::int32_t face, VertexRing& scratch) const {
  if (!sectors_.is_split(vertex)) return vertex;
  gather_ring(subdivision_, level_, vertex, scratch);
  for (std::size_t s = 0; s < scratch.sectors.size(); ++s) {
    const VertexRing::Sector& sector = scratch.sectors[s];
    const auto begin = scratch.faces.begin() + sector.first;
    if (std::find(begin, begin + sector.count, face) == begin + sector.count) continue;
    return sectors_.row(vertex, static_cast<std::int32_t>(s));
  }
  PLANISH_ASSERT(!"the face is not around the vertex");
  return -1;
}

namespace {

// `limit_row(i)` is the number of row i.
template <class LimitRow>
LimitStencilTable<double> make_limit_table(const Subdivision& subdivision, int level,
                                           const LimitRows& limit_rows, RowRange rows,
                                           const LimitRow& limit_row) {
  const auto source_count = static_cast<std::int32_t>(subdivision.state_layout(level).size);
  return LimitStencilTable<double>(
      source_count, build_rows(rows.first, rows.count, Derivatives::Yes, [&] {
        return [&, ring = VertexRing{}](std::int32_t index, StencilRow& row) mutable {
          const LimitRows::Place place = limit_rows.place(limit_row(index));
          gather_ring(subdivision, level, place.vertex, ring);
          add_limit(ring, place.sector, row);
        };
      }));
}

}  // namespace

LimitStencilTable<double> limit_table(const Subdivision& subdivision, int level,
                                      const LimitRows& limit_rows, RowRange rows) {
  return make_limit_table(subdivision, level, limit_rows, rows, [](std::int32_t i) { return i; });
}

LimitStencilTable<double> limit_table(const Subdivision& subdivision, int level,
                                      const LimitRows& limit_rows,
                                      std::span<const std::int32_t> order) {
  return make_limit_table(subdivision, level, limit_rows,
                          {0, static_cast<std::int64_t>(order.size())},
                          [&](std::int32_t i) { return order[i]; });
}

}  // namespace planish
