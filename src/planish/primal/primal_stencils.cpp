// Based on: Catmull & Clark 1978, Loop 1987. Limits are taken on a refined level, whose faces are
// quads (or triangles), and B is carried back to the mesh through one step: Sdc's limit masks are
// wrong next to faces of other sizes.
#include "planish/primal/primal_stencils.h"

#include <utility>
#include <vector>

#include "planish/primal/star_limit.h"
#include "planish/primal/star_masks.h"
#include "planish/primal/vertex_star.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

namespace {

using OpenSubdiv::Far::TopologyLevel;

// Rows of one step of the scheme.
class StepEmitter {
 public:
  StepEmitter(const PrimalSplit& split, int level)
      : split_(split),
        level_(level),
        topology_(split.level(level)),
        quads_(split.scheme() == PrimalScheme::CatmullClark),
        first_edge_(topology_.GetNumVertices() + (quads_ ? topology_.GetNumFaces() : 0)) {}

  // Adds `scale` times vertex `child` of the next level.
  void add(std::int32_t child, double scale, StencilRow& row) {
    if (child < topology_.GetNumVertices()) {
      add_vertex(child, scale, row);
    } else if (child < first_edge_) {
      add_centre(child - topology_.GetNumVertices(), scale, row);
    } else {
      add_edge(child - first_edge_, scale, row);
    }
  }
  void operator()(std::int32_t child, StencilRow& row) { add(child, 1.0, row); }

 private:
  void add_vertex(std::int32_t vertex, double scale, StencilRow& row) {
    gather_star(split_, level_, vertex, star_);
    vertex_mask(split_.scheme(), star_, mask_);
    add_weight(vertex, scale * mask_.vertex(0), row);
    for (std::int32_t i = 0; i < star_.edge_count(); ++i) {
      add_weight(star_.edge_ends[i], scale * mask_.edge(i), row);
    }
    const auto faces = topology_.GetVertexFaces(vertex);
    for (int i = 0; quads_ && i < faces.size(); ++i) {
      add_centre(faces[i], scale * mask_.face(i), row);
    }
  }

  void add_edge(std::int32_t edge, double scale, StencilRow& row) {
    const auto ends = topology_.GetEdgeVertices(edge);
    const auto faces = topology_.GetEdgeFaces(edge);
    edge_mask(split_.scheme(), topology_.GetEdgeSharpness(edge), faces.size(), mask_);
    for (int i = 0; i < 2; ++i) add_weight(ends[i], scale * mask_.vertex(i), row);
    const auto places = topology_.GetEdgeFaceLocalIndices(edge);
    for (int i = 0; i < faces.size(); ++i) {
      if (quads_) {
        add_centre(faces[i], scale * mask_.face(i), row);
      } else {
        // Edge i of a face runs from corner i to corner i + 1.
        const auto corners = topology_.GetFaceVertices(faces[i]);
        add_weight(corners[(places[i] + 2) % 3], scale * mask_.face(i), row);
      }
    }
  }

  void add_centre(std::int32_t face, double scale, StencilRow& row) const {
    if (scale == 0) return;
    const auto corners = topology_.GetFaceVertices(face);
    for (int i = 0; i < corners.size(); ++i) row.add(corners[i], scale / corners.size());
  }

  static void add_weight(std::int32_t vertex, double weight, StencilRow& row) {
    if (weight != 0) row.add(vertex, weight);
  }

  const PrimalSplit& split_;
  int level_;
  const TopologyLevel& topology_;
  bool quads_;
  std::int32_t first_edge_;
  VertexStar star_{};
  SubdivisionMask mask_{};
};

// Limits on one level.
class LimitEmitter {
 public:
  LimitEmitter(const PrimalSplit& split, int level)
      : split_(split), level_(level), limits_(split.scheme()) {}

  // Calls add(vertex of the level, weight, du, dv) for all points of the limit.
  template <class Add>
  void for_points(SectorRows::Place place, const Add& add) {
    gather_star(split_, level_, place.vertex, star_);
    const StarLimit& limit = limits_.limit(star_, place.sector);
    const auto visit = [&](std::int32_t vertex, double weight, double du, double dv) {
      if (weight != 0 || du != 0 || dv != 0) add(vertex, weight, du, dv);
    };
    visit(place.vertex, limit.position.vertex, limit.du.vertex, limit.dv.vertex);
    for (std::size_t i = 0; i < star_.edge_ends.size(); ++i) {
      visit(star_.edge_ends[i], limit.position.edges[i], limit.du.edges[i], limit.dv.edges[i]);
    }
    for (std::size_t i = 0; i < star_.face_ends.size(); ++i) {
      visit(star_.face_ends[i], limit.position.faces[i], limit.du.faces[i], limit.dv.faces[i]);
    }
  }

 private:
  const PrimalSplit& split_;
  int level_;
  StarLimits limits_;
  VertexStar star_{};
};

}  // namespace

StencilTable primal_refinement_table(const PrimalSplit& split, int level, RowRange rows) {
  return build_rows(split.level(level).GetNumVertices(), rows, Derivatives::No,
                    [&] { return StepEmitter(split, level); });
}

SectorRows primal_sector_rows(const PrimalSplit& split, int level, std::int64_t vertex_count) {
  std::vector<SectorRows::Place> extra;
  const TopologyLevel& base = split.level(0);
  bool has_creases = false;
  for (int e = 0; e < base.GetNumEdges() && !has_creases; ++e) {
    has_creases = base.IsEdgeInfSharp(e) && !base.IsEdgeBoundary(e);
  }
  if (!has_creases) return {vertex_count, {}};
  VertexStar star;
  for (std::int32_t v = 0; v < vertex_count; ++v) {
    gather_star(split, level, v, star);
    const std::int32_t sectors = sector_count(star);
    for (std::int32_t s = 1; s < sectors; ++s) extra.push_back({v, s});
  }
  return {vertex_count, std::move(extra)};
}

StencilTable primal_limit_table(const PrimalSplit& split, int level, const SectorRows& sectors,
                                RowRange rows) {
  return build_rows(split.level(level).GetNumVertices(), rows, Derivatives::Yes, [&] {
    return [&, emitter = LimitEmitter(split, level)](std::int32_t index, StencilRow& row) mutable {
      emitter.for_points(sectors.place(index), [&](std::int32_t vertex, double weight, double du,
                                                   double dv) { row.add(vertex, weight, du, dv); });
    };
  });
}

StencilTable primal_limit_masks(const PrimalSplit& split) {
  const std::int32_t count = split.level(0).GetNumVertices();
  return build_rows(count, {0, count}, Derivatives::No, [&] {
    return [&, limits = LimitEmitter(split, 1), step = StepEmitter(split, 0)](
               std::int32_t vertex, StencilRow& row) mutable {
      limits.for_points({vertex, 0}, [&](std::int32_t point, double weight, double, double) {
        if (weight != 0) step.add(point, weight, row);
      });
    };
  });
}

}  // namespace planish
