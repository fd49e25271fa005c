// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", equation (1) and
// section 4 (B = A T). Boundaries and creases: uniform quadratic B-spline of the sharp polyline.
#include "planish/doosabin/limit_masks.h"

#include <algorithm>

#include "planish/core/assert.h"
#include "planish/stencil/stencil_builder.h"

namespace planish {

namespace {

using OpenSubdiv::Far::TopologyLevel;

struct MaskEmitter {
  const PolygonMesh& mesh;
  const Subdivision& subdivision;
  std::vector<double> scratch{};

  void smooth(std::int32_t vertex, StencilRow& row) {
    const TopologyLevel& base = subdivision.split().level(0);
    const auto faces = base.GetVertexFaces(vertex);
    const auto corners = base.GetVertexFaceLocalIndices(vertex);
    const double share = 1.0 / faces.size();
    for (int k = 0; k < faces.size(); ++k) {
      const auto vertices = mesh.face(faces[k]);
      const auto m = static_cast<std::int32_t>(vertices.size());
      const auto c = subdivision.face_weights(m, scratch);
      for (std::int32_t j = 0; j < m; ++j) {
        row.add(vertices[(corners[k] + j) % m], share * c[j]);
      }
    }
  }

  void crease(std::int32_t vertex, StencilRow& row) const {
    const TopologyLevel& base = subdivision.split().level(0);
    row.add(vertex, 6.0 / 8.0);
    const auto edges = base.GetVertexEdges(vertex);
    int count = 0;
    for (int i = 0; i < edges.size(); ++i) {
      const int edge = edges[i];
      if (subdivision.sharp_of_edge(0, edge) < 0) continue;
      const auto ends = base.GetEdgeVertices(edge);
      row.add(ends[0] == vertex ? ends[1] : ends[0], 1.0 / 8.0);
      ++count;
    }
    PLANISH_ASSERT(count == 2);
  }

  void operator()(std::int32_t vertex, StencilRow& row) {
    switch (subdivision.features().vertex_kinds[vertex]) {
      case VertexKind::Smooth:
      case VertexKind::Dart:
        return smooth(vertex, row);
      case VertexKind::Crease:
        return crease(vertex, row);
      case VertexKind::Corner:
        return row.add(vertex, 1.0);
    }
  }
};

}  // namespace

StencilTable<double> limit_masks(const PolygonMesh& mesh, const Subdivision& subdivision) {
  return StencilTable<double>(mesh.vertex_count(),
                              build_rows(0, mesh.vertex_count(), Derivatives::No, [&] {
                                return MaskEmitter{mesh, subdivision};
                              }));
}

double spectral_bound(const PolygonMesh& mesh, Weights weights) {
  double bound = 1.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    bound = std::min(bound, smallest_face_eigenvalue(weights, mesh.face_size(f)));
  }
  return bound;
}

bool is_self_adjoint(const SharpFeatures& features) {
  return features.sharp_edge_count == 0 && features.corner_count == 0;
}

std::vector<double> valences(const QuadSplit& split) {
  const TopologyLevel& base = split.level(0);
  std::vector<double> result(static_cast<std::size_t>(base.GetNumVertices()));
  for (int v = 0; v < base.GetNumVertices(); ++v) result[v] = base.GetVertexFaces(v).size();
  return result;
}

}  // namespace planish
