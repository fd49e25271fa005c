#include "planish/reconstruct/simplify_state.h"

#include <gtest/gtest.h>

#include "reconstruct/simplify_states.h"

namespace planish {
namespace {

bool has_edge(const CollapseMesh& mesh, std::int32_t a, std::int32_t b) {
  bool found = false;
  mesh.for_each_neighbour(a, [&](std::int32_t n) { found = found || n == b; });
  return found;
}

// A roof whose ridge crosses the diagonals of the grid.
TEST(FlipPass, LaysEdgesAlongTheRidge) {
  constexpr std::int32_t kSize = 12;
  const test::TriangleMesh roof =
      test::grid_mesh(kSize, [](int i, int j) { return -0.8 * std::abs(i + j - kSize); });
  const SimplifyOptions options{.tolerance = 10, .least_angle = 3};
  test::GivenState given(roof, roof.positions.size(), options);
  SimplifyState& state = given.state;
  FlipPass(state).run();
  const auto at = [](std::int32_t i) { return i * (kSize + 1) + kSize - i; };
  // The last squares at the border would take an edge from a vertex that has none to give.
  for (std::int32_t i = 1; i + 2 < kSize; ++i) EXPECT_TRUE(has_edge(state.mesh, at(i), at(i + 1)));
  EXPECT_EQ(state.result.vertex_count, (kSize + 1) * (kSize + 1));
}

TEST(FlipPass, FlipsNothingThatMovesACarriedPointTooFar) {
  test::TriangleMesh flat = test::grid_mesh(2, [](int, int) { return 0.0; });
  // Long triangles, so that the other diagonal is far better; a point lies on the one there is.
  for (glm::dvec3& p : flat.positions) p.x += 0.8 * p.y;
  flat.positions[8].z = flat.positions[4].z = 0.2;
  flat.positions.push_back(0.5 * (flat.positions[4] + flat.positions[8]));
  for (const double tolerance : {1.0, 1e-3}) {
    const SimplifyOptions options{.tolerance = tolerance, .least_angle = 3};
    test::GivenState given(flat, 9, options);
    FlipPass(given.state).run();
    EXPECT_EQ(has_edge(given.state.mesh, 4, 8), tolerance < 0.01) << tolerance;
  }
}

}  // namespace
}  // namespace planish
