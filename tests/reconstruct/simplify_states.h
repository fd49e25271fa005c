#pragma once

#include "planish/reconstruct/reconstruct_steps.h"
#include "planish/reconstruct/simplify_state.h"
#include "reconstruct/test_clouds.h"

namespace planish::test {

/// The state of simplify() for a mesh that uses its first `vertex_count` positions; vertices keep
/// their numbers, and further positions are carried.
struct GivenState {
  GivenState(const TriangleMesh& mesh, std::size_t vertex_count, const SimplifyOptions& given)
      : points(mesh.positions),
        options(given),
        state(points, in_order(mesh, vertex_count), options) {}

  WitnessedMesh in_order(const TriangleMesh& mesh, std::size_t vertex_count) const {
    WitnessedMesh result{.triangles = mesh.triangles};
    result.vertex_points.resize(vertex_count);
    std::vector<std::int32_t> loose;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto given = static_cast<std::size_t>(points.given(i));
      if (given < vertex_count)
        result.vertex_points[given] = static_cast<std::int32_t>(i);
      else
        loose.push_back(static_cast<std::int32_t>(i));
    }
    result.carriers.assign(points.size(), -1);
    const TriangleTree tree(mesh.positions, mesh.triangles);
    for (const std::int32_t point : loose)
      result.carriers[point] = tree.nearest(points[point]).triangle;
    return result;
  }

  OrderedPoints points;
  SimplifyOptions options;
  SimplifyState state;
};

}  // namespace planish::test
