#include "planish/distributed/fit_distributed.h"

#include <gtest/gtest.h>

#include "distributed/rank_runs.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// Both are solved to rounding, so that what they differ by is not what either stopped at.
constexpr double kTight = 3e-14;

DistributedFit fitted(const Ranks& ranks, const std::string& input, DistributedOptions options) {
  RankWatch watch(ranks.rank);
  options.name = input;
  return fit_distributed(
      ranks, [&] { return read_slices(ranks, input); }, options, watch);
}

void expect_cage_of_one_machine(const std::string& input, const DistributedOptions& options) {
  const std::string cage = shared_path("cage.ply");
  std::string reference;
  for (const int count : {1, 2, 3, 5, 8})
    on_ranks(count, [&](const Ranks& ranks) {
      DistributedOptions own = options;
      own.cage = cage;
      const DistributedFit fit = fitted(ranks, input, own);
      EXPECT_TRUE(fit.solution.converged) << input;
      if (ranks.rank != 0) return;
      const std::string bytes = content_of(cage);
      EXPECT_FALSE(bytes.empty());
      if (reference.empty()) reference = bytes;
      EXPECT_TRUE(bytes == reference) << input << " on " << count;
    });
  if (!is_first_rank()) return;
  const PolygonMesh mesh = read_mesh(input).mesh;
  FitOptions on_one;
  on_one.tolerance = options.tolerance;
  on_one.weights = options.weights;
  on_one.solver = options.solver;
  on_one.sharp = options.sharp;
  const auto backend = make_cpu_backend();
  const Fit expected = fit(mesh, *backend, on_one);
  const PolygonMesh got = read_mesh(cage).mesh;
  ASSERT_EQ(got.vertex_count(), mesh.vertex_count());
  EXPECT_EQ(got.face_vertices, mesh.face_vertices);
  EXPECT_EQ(got.face_offsets, mesh.face_offsets);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(got.positions[v][c], expected.cage.positions[v][c],
                  1e-12 * expected.placement.diagonal)
          << input << " " << v;
}

// Every scene: closed, open, creased, with corners, darts, holes, 3- to 64-gons.
class EveryScene : public testing::TestWithParam<const char*> {};

TEST_P(EveryScene, HasTheCageOfOneMachineInTheSameBytesForEveryRankCount) {
  const std::string input = std::string(PLANISH_SCENES) + "/" + GetParam() + ".obj";
  expect_cage_of_one_machine(input, {.tolerance = kTight, .block_vertices = 256});
}

INSTANTIATE_TEST_SUITE_P(FitDistributed, EveryScene,
                         testing::Values("bearing_block", "cube", "cube_with_holes",
                                         "cube_with_windows", "goblet", "icosphere", "l_bracket",
                                         "mapped_cube", "mixed_polygons", "open_grid",
                                         "plate_with_holes", "pole64", "rocker_arm", "torus",
                                         "wavy_patch", "bust"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(FitDistributed, OptionsAreThoseOfOneMachine) {
  const std::string creased =
      shared_file("creased.obj", obj_of(with_random_creases(random_open_mesh(3), 0.2, 3)));
  expect_cage_of_one_machine(creased, {.weights = Weights::Averaged,
                                       .sharp = {BoundaryRule::EdgeAndCorner, true},
                                       .tolerance = kTight,
                                       .block_vertices = 50});
  expect_cage_of_one_machine(
      creased, {.sharp = {BoundaryRule::Edge, false}, .tolerance = kTight, .block_vertices = 11});
  expect_cage_of_one_machine(shared_file("paper.ply", ply_of(mixed_torus(16, 8))),
                             {.weights = Weights::Averaged,
                              .solver = Solver::Plain,
                              .tolerance = kTight,
                              .block_vertices = 20});
}

TEST(FitDistributed, BlocksDoNotChangeTheCage) {
  const std::string input = shared_file("blocks.ply", ply_of(mixed_torus(24, 12)));
  std::string reference;
  for (const std::int64_t block : {5, 64, 65536})
    on_ranks(3, [&](const Ranks& ranks) {
      DistributedOptions options{.block_vertices = block};
      options.cage = shared_path("blocks_cage.ply");
      (void)fitted(ranks, input, options);
      if (ranks.rank != 0) return;
      const std::string bytes = content_of(options.cage);
      if (reference.empty()) reference = bytes;
      EXPECT_TRUE(bytes == reference) << block;
    });
}

TEST(FitDistributed, UnusedVerticesStayWhereTheyAre) {
  PolygonMesh mesh = mixed_torus(16, 8);
  mesh.positions.push_back({40, 50, 60});
  const std::string input = shared_file("unused.ply", ply_of(mesh));
  expect_cage_of_one_machine(input, {.tolerance = kTight, .block_vertices = 16});
  if (is_first_rank()) {
    EXPECT_EQ(read_mesh(shared_path("cage.ply")).mesh.positions.back(), glm::dvec3(40, 50, 60));
  }
}

TEST(FitDistributed, FiguresAreOfAllRanks) {
  const std::string input = shared_file("figures.ply", ply_of(mixed_torus(24, 12)));
  on_ranks(5, [&](const Ranks& ranks) {
    const DistributedFit fit = fitted(ranks, input, {.block_vertices = 16});
    EXPECT_EQ(fit.vertices, 288);
    EXPECT_EQ(fit.kinds[0], 288);
    if (ranks.rank != 0) return;
    ASSERT_EQ(fit.ranks.size(), 5u);
    std::int64_t owned = 0;
    for (const RankFigures& rank : fit.ranks) {
      owned += rank.vertices;
      EXPECT_GT(rank.halo, 0);
      EXPECT_GE(rank.ghosts, rank.halo);  // the second ring is not asked for in products
      EXPECT_GT(rank.peers, 0);
      EXPECT_GT(rank.peak_bytes, 1000000);
    }
    EXPECT_EQ(owned, 288);
    // One maximum a step, that of the first residual, and that behind the last step.
    EXPECT_GE(fit.solution.reductions, fit.solution.iterations + 2);
    EXPECT_LE(fit.solution.reductions, fit.solution.iterations + 3);
  });
}

// Where the tolerance is reached before the count that the bound promises, and where it is not.
TEST(FitDistributed, TakesTheStepsOfOneMachine) {
  PolygonMesh apart = mixed_torus(24, 12);
  for (const PolygonMesh& mesh : {random_open_mesh(7), mixed_torus(8, 6)}) {
    const auto first = static_cast<std::int32_t>(apart.positions.size());
    for (const glm::dvec3& p : mesh.positions) apart.positions.push_back(p + glm::dvec3(9, 2, 1));
    for (const std::int32_t v : mesh.face_vertices) apart.face_vertices.push_back(first + v);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      apart.face_offsets.push_back(apart.face_offsets.back() +
                                   static_cast<std::int32_t>(mesh.face(f).size()));
  }
  const std::string input = shared_file("apart.ply", ply_of(apart));
  const std::string grid = std::string(PLANISH_SCENES) + "/open_grid.obj";
  for (const std::string& name : {input, grid})
    for (const Solver solver : {Solver::Chebyshev, Solver::Plain})
      for (const double tolerance : {1e-3, 1e-6, 1e-11}) {
        FitOptions options;
        options.solver = solver;
        options.tolerance = tolerance;
        const auto backend = make_cpu_backend();
        const Interpolation expected = fit(read_mesh(name).mesh, *backend, options).interpolation;
        on_ranks(3, [&](const Ranks& ranks) {
          DistributedOptions own{.solver = solver, .tolerance = tolerance, .block_vertices = 16};
          own.cage = shared_path("steps.ply");
          const PetscSolution found = fitted(ranks, name, own).solution;
          EXPECT_EQ(found.iterations, expected.iterations) << name << " " << tolerance;
          EXPECT_EQ(found.stop_reason, expected.stop_reason);
          ASSERT_EQ(found.history.size(), expected.history.size());
          for (std::size_t k = 0; k < found.history.size(); ++k)
            EXPECT_NEAR(found.history[k].max, expected.history[k].max,
                        1e-6 * expected.history[k].max + 1e-15);
        });
      }
}

}  // namespace
}  // namespace planish::test
