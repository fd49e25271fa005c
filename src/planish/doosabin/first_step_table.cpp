// Based on: Doo & Sabin 1978. Curve points: the uniform quadratic B-spline of a sharp polyline.
#include "planish/doosabin/first_step_table.h"

#include "planish/stencil/stencil_builder.h"

namespace planish {

namespace {

struct FirstStepEmitter {
  const Subdivision& subdivision;
  std::vector<double> scratch{};

  void corner_point(std::int32_t corner, double scale, StencilRow& row) {
    const MeshTopology& topology = subdivision.topology();
    const auto vertices = topology.face(topology.face_of(corner));
    const auto m = static_cast<std::int32_t>(vertices.size());
    const auto c = subdivision.face_weights().of(m, scratch);
    const std::int32_t place = topology.place_of(corner);
    for (std::int32_t j = 0; j < m; ++j) row.add(vertices[(place + j) % m], scale * c[j]);
  }

  void curve_point(std::int32_t sharp_child, StencilRow& row) {
    const MeshTopology& topology = subdivision.topology();
    const std::int32_t edge = subdivision.edge_of_sharp(sharp_child / 2);
    const auto [v0, v1] = topology.edge_vertices(edge);
    const bool is_first_end = sharp_child % 2 == 0;
    const std::int32_t own = is_first_end ? v0 : v1, other = is_first_end ? v1 : v0;
    if (subdivision.features().vertex_kinds[own] != VertexKind::Dart) {
      row.add(own, 0.75);
      row.add(other, 0.25);
      return;
    }
    // Between the two faces beside the edge.
    for (const std::int32_t tail :
         {topology.corner_of(edge), topology.twin(topology.corner_of(edge))})
      corner_point(topology.vertex_of(tail) == own ? tail : topology.next(tail), 0.5, row);
  }

  void operator()(std::int32_t index, StencilRow& row) {
    if (index >= subdivision.first_corner()) {
      row.add(subdivision.features().corner_vertices[index - subdivision.first_corner()], 1.0);
    } else if (index >= subdivision.first_sharp()) {
      curve_point(index - subdivision.first_sharp(), row);
    } else {
      corner_point(index, 1.0, row);
    }
  }
};

}  // namespace

StencilTable first_step_table(const Subdivision& subdivision, RowRange rows) {
  return build_rows(subdivision.topology().vertex_count(), rows, Derivatives::No,
                    [&] { return FirstStepEmitter{subdivision}; });
}

}  // namespace planish
