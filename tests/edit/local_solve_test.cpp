// Whether all rows are solved is decided before any is: by how far moves are expected to reach.
#include "planish/edit/editor_impl.h"

#include <gtest/gtest.h>

#include "edit/edit_case.h"
#include "planish/doosabin/subdivision.h"

namespace planish::test {
namespace {

// The system of a mesh whose vertices faces name all, as an editor has it.
LocalSolve solve_of(const EditCase& c) {
  const auto& prepared = *c.first.prepared;
  const auto features =
      find_sharp_features(c.mesh, *prepared.topology, c.mesh.positions, c.options.fit.sharp);
  const Subdivision subdivision(*prepared.topology, features, c.options.fit.weights);
  const auto unit = [&](const std::vector<glm::dvec3>& positions) {
    std::vector<glm::dvec3> result;
    for (const glm::dvec3& p : positions) result.push_back(c.first.placement.to_unit(p));
    return result;
  };
  return LocalSolve(doo_sabin_system(c.mesh, subdivision, c.options.fit), prepared.topology,
                    unit(c.mesh.positions), unit(c.first.cage.positions), kTolerance);
}

TEST(LocalSolve, DecidesBeforeItSolvesWhetherAllAreReached) {
  const std::vector<NamedMesh> meshes{{"quads", torus(150, 100, 1, 0.4)},
                                      {"triangles", icosphere(5)},
                                      {"uneven", jittered(icosphere(5), 0.3, 7)}};
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    const EditCase c(mesh, 0);
    LocalSolve solve = solve_of(c);
    std::mt19937 random(11);
    const std::size_t size = mesh.positions.size();
    bool was_whole = false;
    std::size_t most_local = 0;
    for (std::size_t count = 1; count < size / 4; count += 1 + count / 3) {
      std::vector<std::int32_t> vertices;
      std::vector<glm::dvec3> points;
      for (std::size_t k = 0; k < count; ++k) {
        // Scattered, none twice.
        vertices.push_back(static_cast<std::int32_t>(k * size / count));
        points.push_back(solve.given()[vertices.back()] +
                         glm::dvec3(random() % 2 == 0 ? 0.01 : -0.01, 0, 0));
      }
      solve.move(vertices, points);
      EXPECT_LE(solve.measured().norms.max, solve.bound() * (1 + 1e-9));
      if (solve.changed_all()) {
        EXPECT_EQ(solve.row_count(), 0) << count;  // nothing was solved in vain
        was_whole = true;
      } else {
        EXPECT_GT(solve.row_count(), 0);
        EXPECT_FALSE(was_whole) << count;  // once they are too many, more are
        most_local = std::max(most_local, solve.changed().size());
      }
    }
    EXPECT_TRUE(was_whole);
    EXPECT_GT(most_local, size / 100);
    EXPECT_LT(most_local, size / 10);
  }
}

TEST(LocalSolve, SmallMovesReachLess) {
  const EditCase c(torus(150, 100, 1, 0.4), 0);
  LocalSolve solve = solve_of(c);
  // So many that ways of 1 % of the diagonal reach all, of the size of the tolerance hardly others.
  std::vector<std::int32_t> vertices;
  for (std::int32_t v = 0; v < 15'000; v += 50) vertices.push_back(v);
  for (const double way : {1e-2, 1e-6}) {
    std::vector<glm::dvec3> points;
    for (const std::int32_t v : vertices)
      points.push_back(solve.given()[v] + glm::dvec3(0, 0, way));
    solve.move(vertices, points);
    EXPECT_EQ(solve.changed_all(), way == 1e-2);
  }
}

}  // namespace
}  // namespace planish::test
