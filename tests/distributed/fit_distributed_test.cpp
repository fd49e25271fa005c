#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "distributed/rank_runs.h"
#include "fair/cure_meshes.h"
#include "planish/distributed/fit_distributed.h"
#include "planish/distributed/part_fair.h"
#include "planish/distributed/write_cage.h"
#include "planish/doosabin/subdivision.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
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

MeshPart tagged_part_of(const Ranks& ranks, const PolygonMesh& mesh, std::int64_t block) {
  MeshSlice slice = scatter_mesh(ranks, mesh);
  CurveOrder order = order_along_curve(ranks, slice, block);
  FaceStream ring = send_first_ring(ranks, slice, order);
  MeshPart part = make_part(ranks, std::move(ring), slice, std::move(order));
  fetch_ghost_tags(ranks, part);
  return part;
}

// What one machine makes, and where it stands in the state.
struct OneFair {
  OneFair(const PolygonMesh& mesh, const FitOptions& options) {
    const auto backend = make_cpu_backend();
    fit = planish::fit(mesh, *backend, options);
    const UsedPart used = used_part(mesh, fit.prepared);
    const MeshTopology topology(used.mesh);
    const SharpFeatures features =
        find_sharp_features(used.mesh, topology, used.mesh.positions, options.sharp);
    const auto& ids = used.vertices;
    for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
      if (features.sharp_of_edge.empty() || features.sharp_of_edge[e] < 0) continue;
      const auto [v0, v1] = topology.edge_vertices(e);
      const std::int32_t index = topology.corner_count() + 2 * features.sharp_of_edge[e];
      curves[{ids[v0], ids[v1]}] = index;
      curves[{ids[v1], ids[v0]}] = index + 1;
    }
    state = fit.fair->level_one.state;
  }

  Fit fit;
  std::vector<glm::dvec3> state;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int32_t> curves;  // by numbers in the file
};

struct FairCase {
  std::string name;
  PolygonMesh mesh;
  FitOptions options;
  std::int64_t block = 64;
};

// All corners of all ranks' parts, ghosts' too, and curve points of their own vertices.
void expect_state_of_one_machine(const FairCase& job, const OneFair& one, const MeshPart& part,
                                 const PartFair& fair, const std::string& what) {
  std::int64_t differing = 0;
  for (std::int32_t f = 0; f < part.face_count(); ++f) {
    const std::int32_t first = job.mesh.face_offsets[part.face_ids[f]];
    for (std::int32_t c = part.face_offsets[f]; c < part.face_offsets[f + 1]; ++c)
      differing += fair.state[c] == one.state[first + c - part.face_offsets[f]] ? 0 : 1;
  }
  EXPECT_EQ(differing, 0) << what << ", of " << part.face_vertices.size() << " corners";
  std::size_t own_curves = 0;
  for (const CurveKey& key : fair.keys) {
    const std::int32_t v = part.local_of(key.vertex), other = part.local_of(key.other);
    const auto known = one.curves.find({part.file_ids[v], part.file_ids[other]});
    if (v < part.owned_count()) {
      ++own_curves;
      ASSERT_NE(known, one.curves.end()) << what;
    }
    if (known == one.curves.end()) continue;  // at the rim
    EXPECT_EQ(fair.state[key.index], one.state[known->second]) << what << ", a curve point";
  }
  std::size_t expected = 0;
  for (const auto& [ends, index] : one.curves) {
    const auto v = std::ranges::find(part.file_ids, ends.first) - part.file_ids.begin();
    expected += v < part.owned_count() ? 1 : 0;
  }
  EXPECT_EQ(own_curves, expected) << what;
}

void expect_fair_of_one_machine(const FairCase& job) {
  const OneFair one(job.mesh, job.options);
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      const MeshPart part = tagged_part_of(ranks, job.mesh, job.block);
      PartFairOptions options;
      options.fit = job.options;
      options.placement = one.fit.placement;
      options.block_vertices = job.block;
      const PartFair fair = make_part_fair(ranks, part, options);
      const std::string what = job.name + " on " + std::to_string(count);
      expect_state_of_one_machine(job, one, part, fair, what);
      const FairFit& expected = *one.fit.fair;
      EXPECT_EQ(fair.shrunk_vertices, expected.shrunk_vertices) << what;
      EXPECT_EQ(fair.reversed_vertices, expected.reversed_vertices) << what;
      EXPECT_EQ(fair.cured_vertices, expected.cured_vertices) << what;
      EXPECT_EQ(fair.flagged_edges, expected.flagged_edges) << what;
      EXPECT_EQ(fair.flagged_faces, expected.flagged_faces) << what;
      EXPECT_EQ(fair.error.max, one.fit.interpolation.error.max) << what;
      EXPECT_NEAR(fair.error.rms, one.fit.interpolation.error.rms, 1e-20) << what;
      EXPECT_EQ(fair.converged, one.fit.interpolation.converged) << what;
    });
}

FitOptions fair_options(std::int32_t polish_steps = 8) {
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  options.obeys_semi_sharp = false;  // ranks take them as smooth, and say so
  options.polish_steps = polish_steps;
  return options;
}

class FairScene : public testing::TestWithParam<const char*> {};

TEST_P(FairScene, HasTheControlPointsOfOneMachineBitByBitForEveryRankCount) {
  const std::string path = std::string(PLANISH_SCENES) + "/" + GetParam() + ".obj";
  for (const std::int32_t polish : {0, 8})
    expect_fair_of_one_machine({path, read_mesh(path).mesh, fair_options(polish)});
}

INSTANTIATE_TEST_SUITE_P(PartFair, FairScene,
                         testing::Values("bearing_block", "cube", "cube_with_holes",
                                         "cube_with_windows", "goblet", "icosphere", "l_bracket",
                                         "mapped_cube", "mixed_polygons", "open_grid",
                                         "plate_with_holes", "pole64", "torus", "wavy_patch"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(PartFair, FoldsAreCuredAsOnOneMachine) {
  PolygonMesh mesh = mixed_torus(24, 12);
  for (const std::size_t v : {30u, 100u, 200u}) mesh.positions[v] *= 0.7;
  mesh.positions.insert(mesh.positions.begin() + 40, {40, 50, 60});  // unused
  for (std::int32_t& v : mesh.face_vertices) v += v >= 40 ? 1 : 0;
  expect_fair_of_one_machine({"folded torus", mesh, fair_options(), 16});
}

TEST(PartFair, EllipsesOfHubsAreThoseOfOneMachine) {
  expect_fair_of_one_machine({"needle loft", test::needle_loft(10), fair_options(), 4});
}

TEST(PartFair, RandomOpenMeshesWithCreasesAreThoseOfOneMachine) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    FairCase job{"random mesh " + std::to_string(seed),
                 with_random_creases(random_open_mesh(seed), 0.2, seed), fair_options(), 16};
    if (seed > 2) job.options.sharp = {BoundaryRule::EdgeAndCorner, true};
    job.options.cures_folds = seed % 2 == 0;
    expect_fair_of_one_machine(job);
  }
}

// The file that one machine writes.
std::string cage_of_one_machine(const PolygonMesh& mesh, const DistributedOptions& options) {
  FitOptions on_one;
  on_one.method = InterpolationMethod::Fair;
  on_one.obeys_semi_sharp = false;
  on_one.polish_steps = options.polish_steps;
  on_one.sharp = options.sharp;
  const auto backend = make_cpu_backend();
  const Fit fit = planish::fit(mesh, *backend, on_one);
  const std::string path = shared_path("one.ply");
  write_mesh(path, FileFormat::Ply, control_cage(mesh, fit, options.sharp),
             {.header = options.cage_header});
  return content_of(path);
}

void expect_cage(const std::string& name, const PolygonMesh& mesh, DistributedOptions options) {
  options.method = InterpolationMethod::Fair;
  options.cage = shared_path("fair.ply");
  options.cage_header = {"of a test"};
  std::string expected;
  if (is_first_rank()) expected = cage_of_one_machine(mesh, options);
  for (const int count : kRankCounts)
    on_ranks(count, [&](const Ranks& ranks) {
      RankWatch watch(ranks.rank);
      const auto fit = fit_distributed(
          ranks, [&] { return scatter_mesh(ranks, mesh); }, options, watch);
      EXPECT_EQ(sum_over(ranks, std::ssize(fit.file_ids)), mesh.vertex_count());
      if (ranks.rank != 0) return;
      EXPECT_TRUE(content_of(options.cage) == expected) << name << " on " << count;
    });
}

class FairCageScene : public testing::TestWithParam<const char*> {};

TEST_P(FairCageScene, HasTheBytesOfOneMachineForEveryRankCount) {
  const std::string path = std::string(PLANISH_SCENES) + "/" + GetParam() + ".obj";
  const PolygonMesh mesh = read_mesh(path).mesh;
  expect_cage(path, mesh, {.polish_steps = 0, .block_vertices = 64});
}

INSTANTIATE_TEST_SUITE_P(FairCage, FairCageScene,
                         testing::Values("bearing_block", "cube", "goblet", "icosphere",
                                         "l_bracket", "mixed_polygons", "open_grid",
                                         "plate_with_holes", "pole64", "torus", "wavy_patch"),
                         [](const auto& scene) { return std::string(scene.param); });

TEST(FairCage, RandomMeshesWithCreasesAndCornersAreThoseOfOneMachine) {
  for (const unsigned seed : {1u, 3u}) {
    DistributedOptions options{.polish_steps = 0, .block_vertices = 16};
    if (seed == 3) options.sharp = {BoundaryRule::EdgeAndCorner, true};
    expect_cage("random mesh " + std::to_string(seed),
                with_random_creases(random_open_mesh(seed), 0.2, seed), options);
  }
}

TEST(FairCage, UnusedVerticesHaveNoControlPoints) {
  PolygonMesh mesh = mixed_torus(16, 8);
  mesh.positions.insert(mesh.positions.begin() + 40, {40, 50, 60});
  for (std::int32_t& v : mesh.face_vertices) v += v >= 40 ? 1 : 0;
  expect_cage("torus", mesh, {.polish_steps = 0, .block_vertices = 16});
}

TEST(FairCage, FacesOfManyCornersTakeLongCounts) {
  PolygonMesh mesh;  // two polygons of 300 corners, back to back with a band between
  std::vector<std::int32_t> lower, upper;
  for (int i = 0; i < 300; ++i) {
    const double angle = 2 * 3.14159265358979 * i / 300;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 1});
    lower.insert(lower.begin(), 2 * i);
    upper.push_back(2 * i + 1);
    const int next = (i + 1) % 300;
    mesh.add_face(std::vector<std::int32_t>{2 * i, 2 * next, 2 * next + 1, 2 * i + 1});
  }
  mesh.add_face(lower);
  mesh.add_face(upper);
  expect_cage("drum", mesh, {.polish_steps = 0, .block_vertices = 16});
}

TEST(FairCage, HolesAreRefused) {
  PolygonMesh mesh = mixed_torus(16, 8);
  mesh.hole_faces = {3, 7};
  on_ranks(3, [&](const Ranks& ranks) {
    RankWatch watch(ranks.rank);
    DistributedOptions options{.method = InterpolationMethod::Fair};
    options.cage = shared_path("holes.ply");
    const Outcome outcome = outcome_of([&] {
      (void)fit_distributed(
          ranks, [&] { return scatter_mesh(ranks, mesh); }, options, watch);
    });
    EXPECT_EQ(outcome.code, static_cast<int>(ErrorCode::InvalidArgument));
    EXPECT_NE(outcome.message.find("2 faces are tagged so; leave it out"), std::string::npos);
    EXPECT_TRUE(content_of(options.cage).empty());
  });
}

}  // namespace
}  // namespace planish::test
