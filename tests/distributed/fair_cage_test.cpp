#include "planish/distributed/write_cage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "distributed/rank_runs.h"
#include "planish/files/mesh_file.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// The file that one machine writes.
std::string cage_of_one_machine(const PolygonMesh& mesh, const DistributedOptions& options) {
  FitOptions on_one;
  on_one.method = InterpolationMethod::Fair;
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
