#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "make_scenes/scene_list.h"
#include "make_scenes/shapes.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/check.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "scenes/topology.h"

namespace planish::shapes {
namespace {

const std::map<std::string, PolygonMesh>& meshes() {
  static const std::map<std::string, PolygonMesh> kMeshes = [] {
    std::map<std::string, PolygonMesh> made;
    // The committed files, which another test holds to the generator: reading them is quick.
    for (const Scene& scene : scenes()) {
      const std::filesystem::path path = std::filesystem::path(PLANISH_SCENES) / scene.file;
      made[scene.file] = read_mesh(path).mesh;
    }
    return made;
  }();
  return kMeshes;
}

struct Expected {
  std::int64_t euler_characteristic;  // 2 - 2 genus - boundary loops
  bool is_open = false;
};

const std::map<std::string, Expected> kExpected{{"cube_with_holes.obj", {2 - 2 * 5}},
                                                {"goblet.obj", {2}},
                                                {"rocker_arm.obj", {0}},
                                                {"torus.obj", {0}},
                                                {"icosphere.obj", {2}},
                                                {"pole64.obj", {2}},
                                                {"mixed_polygons.obj", {2}},
                                                {"plate_with_holes.obj", {1 - 4, true}},
                                                {"open_grid.obj", {1, true}},
                                                {"wavy_patch.obj", {1, true}},
                                                {"bearing_block.obj", {0}},
                                                {"l_bracket.obj", {2}},
                                                {"cube.obj", {2}},
                                                {"mapped_cube.obj", {2}},
                                                {"cube_with_windows.obj", {2}},
                                                {"bust.obj", {2}}};

TEST(SceneShapes, PassTheCheck) {
  for (const auto& [file, mesh] : meshes()) {
    const auto problems = check(mesh);
    EXPECT_TRUE(problems.empty()) << file << ": " << problems.front().message;
  }
}

TEST(SceneShapes, HaveTheirTopology) {
  for (const auto& [file, mesh] : meshes()) {
    const Topology topology = topology_of(mesh);
    const Expected& expected = kExpected.at(file);
    EXPECT_EQ(topology.euler_characteristic(), expected.euler_characteristic) << file;
    EXPECT_EQ(topology.doubled_edge_count, 0) << file;
    EXPECT_EQ(topology.border_edge_count > 0, expected.is_open) << file;
    EXPECT_EQ(topology.vertex_count, mesh.vertex_count()) << file << " has unused vertices";
  }
}

TEST(SceneShapes, FaceOutward) {
  for (const auto& [file, mesh] : meshes()) {
    if (!kExpected.at(file).is_open) {
      EXPECT_GT(volume_of(mesh), 0.1) << file;
    }
  }
}

TEST(SceneShapes, FacePlusZWhereOpen) {
  for (const auto& [file, mesh] : meshes()) {
    if (!kExpected.at(file).is_open) continue;
    const auto corners = mesh.face(0);
    const glm::dvec3 normal = glm::cross(mesh.positions[corners[1]] - mesh.positions[corners[0]],
                                         mesh.positions[corners[2]] - mesh.positions[corners[0]]);
    EXPECT_GT(normal.z, 0.0) << file;
  }
}

TEST(SceneShapes, OfTheTableComeNearThePapersVertexCounts) {
  const std::map<std::string, int> paper{{"cube_with_holes.obj", 7666},
                                         {"goblet.obj", 8082},
                                         {"rocker_arm.obj", 13984},
                                         {"bust.obj", 16378}};
  for (const auto& [file, count] : paper) {
    EXPECT_NEAR(meshes().at(file).vertex_count(), count, 0.1 * count) << file;
  }
}

TEST(SceneShapes, OfTheTableAreCleanQuads) {
  constexpr double kLeastAngle = 30.0;
  constexpr double kGreatestAngle = 165.0;
  for (const char* file : {"cube_with_holes.obj", "goblet.obj", "rocker_arm.obj", "bust.obj"}) {
    const PolygonMesh& mesh = meshes().at(file);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) ASSERT_EQ(mesh.face_size(f), 4) << file;
    const auto [least, greatest] = corner_angles(mesh);
    EXPECT_GT(least, kLeastAngle) << file;
    EXPECT_LT(greatest, kGreatestAngle) << file;
  }
}

TEST(SceneShapes, OfTheTableNeedTheSolveAndComeOutUnfolded) {
  constexpr double kLeastInitialError = 1e-3;
  const auto backend = make_cpu_backend();
  for (const char* file : {"cube_with_holes.obj", "goblet.obj", "rocker_arm.obj", "bust.obj"}) {
    const PolygonMesh& mesh = meshes().at(file);
    const Fit result = fit(mesh, *backend);
    EXPECT_GT(result.interpolation.history.front().max, kLeastInitialError) << file;
    EXPECT_TRUE(result.interpolation.converged) << file;
    EvaluateOptions options;
    options.level = 1;
    options.rest_positions = mesh.positions;
    EXPECT_EQ(surface_quality(evaluate(result.cage, *backend, options), mesh).folded_area, 0.0)
        << file;
  }
}

TEST(SceneShapes, AreConvexFacesExceptTheBracket) {
  for (const auto& [file, mesh] : meshes()) {
    const auto [least, greatest] = corner_angles(mesh);
    EXPECT_GT(least, 4.0) << file;
    if (file == "l_bracket.obj") {
      EXPECT_NEAR(greatest, 270.0, 1e-9);
    } else {
      EXPECT_LT(greatest, 180.0) << file;
    }
  }
}

TEST(SceneShapes, MixedPolygonsHaveEverySizeFromThreeToTwelve) {
  const PolygonMesh& mesh = meshes().at("mixed_polygons.obj");
  std::map<std::int32_t, int> counts;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) ++counts[mesh.face_size(f)];
  ASSERT_EQ(counts.size(), 10u);
  EXPECT_EQ(counts.begin()->first, 3);
  EXPECT_EQ(counts.rbegin()->first, 12);
}

TEST(SceneShapes, PoleHasValence64AndACapOf64Corners) {
  const PolygonMesh& mesh = meshes().at("pole64.obj");
  EXPECT_EQ(mesh.face_size(0), 64);
  std::vector<int> faces_at(mesh.positions.size(), 0);
  for (const std::int32_t v : mesh.face_vertices) ++faces_at[v];
  EXPECT_EQ(*std::max_element(faces_at.begin(), faces_at.end()), 64);
}

TEST(SceneShapes, BearingBlockTagsItsSharpEdgesOnly) {
  const PolygonMesh& mesh = meshes().at("bearing_block.obj");
  // Six outlines of 64 edges: two squares, the foot and the rim of the boss, both ends of the bore;
  // and four upright edges at each of the four corners.
  std::int64_t sharp = 0;
  std::int64_t semi_sharp = 0;
  for (const CreaseEdge& crease : mesh.creases) {
    (crease.sharpness == kInfiniteSharpness ? sharp : semi_sharp)++;
  }
  EXPECT_EQ(sharp, 6 * 64);
  EXPECT_EQ(semi_sharp, 4 * 4);
}

TEST(Torus, LiesOnItsEquation) {
  const PolygonMesh mesh =
      torus({.ring_count = 20, .tube_count = 12, .radius = 2.0, .tube_radius = 0.5});
  EXPECT_EQ(mesh.vertex_count(), 240);
  EXPECT_EQ(mesh.face_count(), 240);
  for (const glm::dvec3& p : mesh.positions) {
    EXPECT_NEAR(std::hypot(std::hypot(p.x, p.y) - 2.0, p.z), 0.5, 1e-14);
  }
}

TEST(Icosphere, QuadruplesItsFaces) {
  for (std::int32_t level = 0; level < 4; ++level) {
    const PolygonMesh mesh = icosphere(level);
    EXPECT_EQ(mesh.face_count(), 20 << (2 * level));
    EXPECT_EQ(mesh.vertex_count(), (10 << (2 * level)) + 2);
    for (const glm::dvec3& p : mesh.positions) EXPECT_NEAR(glm::length(p), 1.0, 1e-15);
  }
}

TEST(Dual, SwapsVerticesAndFaces) {
  const PolygonMesh sphere = icosphere(2);
  const PolygonMesh once = dual(sphere);
  EXPECT_EQ(once.vertex_count(), sphere.face_count());
  EXPECT_EQ(once.face_count(), sphere.vertex_count());
  EXPECT_TRUE(check(once).empty());
  EXPECT_GT(volume_of(once), 0.0);
}

TEST(Shapes, RefuseCountsTheyCannotServe) {
  EXPECT_THROW((void)cube(0), std::invalid_argument);
  EXPECT_THROW((void)cube_with_tunnels(10, 3), std::invalid_argument);
  EXPECT_THROW((void)torus({.ring_count = 2}), std::invalid_argument);
  EXPECT_THROW((void)icosphere(-1), std::invalid_argument);
  EXPECT_THROW((void)pole_sphere(2, 3), std::invalid_argument);
  EXPECT_THROW((void)open_grid(0, 3), std::invalid_argument);
}

}  // namespace
}  // namespace planish::shapes
