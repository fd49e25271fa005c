#include "planish/reconstruct/simplify_state.h"

#include <gtest/gtest.h>

#include "planish/mesh/check.h"
#include "planish/mesh/statistics.h"
#include "reconstruct/simplify_states.h"

namespace planish {
namespace {

std::vector<Triangle> triangles_of(const CollapseMesh& mesh) {
  std::vector<Triangle> triangles;
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t)
    if (mesh.is_alive(static_cast<std::int32_t>(t)))
      triangles.push_back(mesh.triangle(static_cast<std::int32_t>(t)));
  return triangles;
}

// Mean distance of vertices from the middle of their neighbours, in lengths of their edges.
double unevenness(const CollapseMesh& mesh, const std::vector<glm::dvec3>& positions) {
  double sum = 0;
  int count = 0;
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(positions.size()); ++v) {
    if (!mesh.is_used(v) || mesh.is_boundary(v)) continue;
    glm::dvec3 middle(0.0);
    double length = 0;
    mesh.for_each_neighbour(v, [&](std::int32_t n) {
      middle += positions[n] - positions[v];
      length += glm::distance(positions[n], positions[v]);
    });
    sum += glm::length(middle) / length;
    ++count;
  }
  return sum / count;
}

void expect_moved_within_tolerance(const test::TriangleMesh& given, double tolerance) {
  const SimplifyOptions options{.tolerance = tolerance};
  test::GivenState given_state(given, given.positions.size(), options);
  SimplifyState& state = given_state.state;
  CollapsePass(state).run();
  const MeshStatistics before = [&] {
    PolygonMesh mesh = polygons_of(triangles_of(state.mesh));
    mesh.positions = state.positions;
    return statistics(mesh);
  }();
  const double uneven = unevenness(state.mesh, state.positions);
  MovePass(state).run();
  EXPECT_GT(state.result.move_count, 10);
  EXPECT_LT(unevenness(state.mesh, state.positions), 0.98 * uneven);
  const std::vector<Triangle> triangles = triangles_of(state.mesh);
  const PointDistances distances = measure_distances(given.positions, state.positions, triangles);
  EXPECT_LE(distances.max, tolerance * (1 + 1e-12));
  PolygonMesh mesh = polygons_of(triangles);
  mesh.positions = state.positions;
  for (std::size_t v = 0; v < state.positions.size(); ++v)
    EXPECT_EQ(state.positions[v], state.points[state.vertex_points[v]]);
  EXPECT_TRUE(check(mesh).empty());
  const MeshStatistics after = statistics(mesh);
  EXPECT_EQ(after.genus, before.genus);
  EXPECT_EQ(after.boundary_loop_count, before.boundary_loop_count);
  EXPECT_EQ(after.unused_vertex_count, before.unused_vertex_count);
  EXPECT_EQ(after.face_count, before.face_count);
}

TEST(MovePass, EvensOutAClosedMeshWithinTheTolerance) {
  expect_moved_within_tolerance(test::torus_mesh(80, 40), 0.01);
}

TEST(MovePass, EvensOutAnOpenMeshWithinTheTolerance) {
  expect_moved_within_tolerance(
      test::grid_mesh(40, [](int i, int j) { return 0.5 * std::sin(0.7 * i) * std::cos(0.5 * j); }),
      0.05);
}

TEST(MovePass, LeavesAMeshAloneThatCarriesNothing) {
  const test::TriangleMesh torus = test::torus_mesh(20, 10);
  const SimplifyOptions options{.tolerance = 1};
  test::GivenState given(torus, torus.positions.size(), options);
  SimplifyState& state = given.state;
  MovePass(state).run();
  EXPECT_EQ(state.result.move_count, 0);
  EXPECT_EQ(triangles_of(state.mesh), torus.triangles);
}

}  // namespace
}  // namespace planish
