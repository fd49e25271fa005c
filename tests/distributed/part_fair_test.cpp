#include "planish/distributed/part_fair.h"

#include <gtest/gtest.h>

#include <map>

#include "distributed/rank_runs.h"
#include "fair/cure_meshes.h"
#include "planish/doosabin/subdivision.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

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

}  // namespace
}  // namespace planish::test
