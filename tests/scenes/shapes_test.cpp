#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <utility>

#include "make_scenes/implicit.h"
#include "make_scenes/sample_points.h"
#include "make_scenes/scene_list.h"
#include "make_scenes/shapes.h"
#include "planish/files/mesh_file.h"
#include "planish/mesh/check.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/reconstruct/point_tree.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"

namespace planish::shapes {
namespace {

// Counts made from directed edges alone, independent of the library's own check().
struct Topology {
  std::int64_t vertex_count = 0;  // vertices that faces name
  std::int64_t face_count = 0;
  std::int64_t edge_count = 0;
  std::int64_t border_edge_count = 0;
  std::int64_t doubled_edge_count = 0;  // directed edges of more than one face
  [[nodiscard]] std::int64_t euler_characteristic() const {
    return vertex_count - edge_count + face_count;
  }
};

Topology topology_of(const PolygonMesh& mesh) {
  Topology result;
  std::map<std::pair<std::int32_t, std::int32_t>, int> directed;
  std::set<std::int32_t> used;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      used.insert(corners[i]);
      if (++directed[{corners[i], corners[(i + 1) % corners.size()]}] == 2) {
        ++result.doubled_edge_count;
      }
    }
  }
  for (const auto& [edge, count] : directed) {
    if (!directed.contains({edge.second, edge.first})) ++result.border_edge_count;
  }
  result.vertex_count = static_cast<std::int64_t>(used.size());
  result.face_count = mesh.face_count();
  result.edge_count = (static_cast<std::int64_t>(directed.size()) + result.border_edge_count) / 2;
  return result;
}

// Volume by the divergence theorem; positive when a closed mesh faces outward.
double volume_of(const PolygonMesh& mesh) {
  double volume = 0.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      const glm::dvec3& a = mesh.positions[corners[0]];
      const glm::dvec3& b = mesh.positions[corners[i]];
      const glm::dvec3& c = mesh.positions[corners[i + 1]];
      volume += glm::dot(a, glm::cross(b, c)) / 6.0;
    }
  }
  return volume;
}

// Smallest and largest interior angle in degrees, about the Newell normal; above 180 where
// concave.
std::pair<double, double> corner_angles(const PolygonMesh& mesh) {
  double least = 360.0;
  double greatest = 0.0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto corners = mesh.face(f);
    const std::size_t size = corners.size();
    glm::dvec3 normal(0.0);
    for (std::size_t i = 0; i < size; ++i) {
      normal += glm::cross(mesh.positions[corners[i]] - mesh.positions[corners[0]],
                           mesh.positions[corners[(i + 1) % size]] - mesh.positions[corners[0]]);
    }
    normal = glm::normalize(normal);
    for (std::size_t i = 0; i < size; ++i) {
      const glm::dvec3& here = mesh.positions[corners[i]];
      const glm::dvec3 next = mesh.positions[corners[(i + 1) % size]] - here;
      const glm::dvec3 previous = mesh.positions[corners[(i + size - 1) % size]] - here;
      double angle =
          std::atan2(glm::dot(glm::cross(next, previous), normal), glm::dot(next, previous)) *
          180.0 / std::numbers::pi;
      if (angle < 0.0) angle += 360.0;
      least = std::min(least, angle);
      greatest = std::max(greatest, angle);
    }
  }
  return {least, greatest};
}

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
  std::int64_t in_paper = 0;  // vertices in the paper's table
};

const std::map<std::string, Expected> kExpected{{"cube_with_holes.obj", {2 - 2 * 5, false, 7666}},
                                                {"goblet.obj", {2, false, 8082}},
                                                {"rocker_arm.obj", {0, false, 13984}},
                                                {"bust.obj", {2, false, 16378}},
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
                                                {"cube_with_windows.obj", {2}}};

TEST(SceneShapes, AreSoundWithTheirTopologyAndFaceOutward) {
  for (const auto& [file, mesh] : meshes()) {
    SCOPED_TRACE(file);
    const auto problems = check(mesh);
    EXPECT_TRUE(problems.empty()) << problems.front().message;
    const Topology topology = topology_of(mesh);
    const Expected& expected = kExpected.at(file);
    EXPECT_EQ(topology.euler_characteristic(), expected.euler_characteristic);
    EXPECT_EQ(topology.doubled_edge_count, 0);
    EXPECT_EQ(topology.border_edge_count > 0, expected.is_open);
    EXPECT_EQ(topology.vertex_count, mesh.vertex_count()) << "unused vertices";
    if (expected.is_open) {  // to +z
      const auto corners = mesh.face(0);
      const glm::dvec3& a = mesh.positions[corners[0]];
      EXPECT_GT(glm::cross(mesh.positions[corners[1]] - a, mesh.positions[corners[2]] - a).z, 0.0);
    } else {
      EXPECT_GT(volume_of(mesh), 0.1);
    }
    // Convex, all but the bracket; those of the table are clean quads.
    const auto [least, greatest] = corner_angles(mesh);
    EXPECT_GT(least, expected.in_paper > 0 ? 30.0 : 4.0);
    if (file == "l_bracket.obj") {
      EXPECT_NEAR(greatest, 270.0, 1e-9);
    } else {
      EXPECT_LT(greatest, expected.in_paper > 0 ? 165.0 : 180.0);
    }
    if (expected.in_paper == 0) continue;
    EXPECT_NEAR(mesh.vertex_count(), expected.in_paper, 0.1 * expected.in_paper);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) ASSERT_EQ(mesh.face_size(f), 4);
  }
}

TEST(SceneShapes, OfTheTableNeedTheSolveAndComeOutUnfolded) {
  constexpr double kLeastInitialError = 1e-3;
  const auto backend = make_cpu_backend();
  for (const auto& [file, mesh] : meshes()) {
    if (kExpected.at(file).in_paper == 0) continue;
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

TEST(RandomPolygonMesh, IsClosedAndUsableForEverySeed) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const PolygonMesh mesh =
        random_polygon_mesh({.seed = seed, .level = 2, .merged_share = 0.015 * seed});
    EXPECT_TRUE(check(mesh).empty()) << "seed " << seed;
    const Topology topology = topology_of(mesh);
    EXPECT_EQ(topology.euler_characteristic(), 2) << "seed " << seed;
    EXPECT_EQ(topology.border_edge_count, 0) << "seed " << seed;
    EXPECT_EQ(topology.vertex_count, mesh.vertex_count()) << "seed " << seed;
    EXPECT_GT(volume_of(mesh), 3.0) << "seed " << seed;
  }
}

TEST(RandomPolygonMesh, MixesFaceSizesUpToTheLargest) {
  const PolygonMesh mesh = random_polygon_mesh({.merged_share = 0.7, .largest_face = 6});
  std::set<std::int32_t> sizes;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) sizes.insert(mesh.face_size(f));
  EXPECT_EQ(sizes, (std::set<std::int32_t>{3, 4, 5, 6}));
}

TEST(RandomPolygonMesh, DependsOnTheSeedAlone) {
  const PolygonMesh a = random_polygon_mesh({.seed = 7});
  const PolygonMesh b = random_polygon_mesh({.seed = 7});
  const PolygonMesh c = random_polygon_mesh({.seed = 8});
  EXPECT_EQ(a.face_vertices, b.face_vertices);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_NE(a.face_vertices, c.face_vertices);
}

TEST(MixedPolygons, AreUsableForEverySeed) {
  for (std::uint32_t seed = 0; seed < 10; ++seed) {
    const PolygonMesh mesh = mixed_polygons(seed);
    EXPECT_TRUE(check(mesh).empty()) << "seed " << seed;
    EXPECT_EQ(topology_of(mesh).euler_characteristic(), 2) << "seed " << seed;
  }
}

double torus_distance(const glm::dvec3& p) {
  return std::hypot(std::hypot(p.x, p.y) - 1.0, p.z) - 0.4;
}

TEST(SurfaceNets, PutEveryVertexOnTheSurface) {
  SurfaceNetsOptions options{
      .low = {-1.503, -1.507, -0.511}, .high = {1.5, 1.5, 0.5}, .cell = 0.08};
  const PolygonMesh mesh = surface_nets(torus_distance, options);
  EXPECT_TRUE(check(mesh).empty());
  EXPECT_EQ(topology_of(mesh).euler_characteristic(), 0);
  for (const glm::dvec3& p : mesh.positions) EXPECT_NEAR(torus_distance(p), 0.0, 1e-9);
  // 2 pi^2 R r^2; an inscribed quad mesh of this fineness misses about 1 %.
  const double volume = 2.0 * std::numbers::pi * std::numbers::pi * 0.16;
  EXPECT_NEAR(volume_of(mesh), volume, 0.02 * volume);
}

// Newton's step where that is no longer than a step may be, else one as long as that.
TEST(SurfaceNets, ProjectFromAfarByStepsOfTheLongestLength) {
  const Field plane = [](const glm::dvec3& p) { return p.x; };
  EXPECT_NEAR(projected(plane, {5.5, 2, 3}, 1).x, 0, 1e-9);
  EXPECT_NEAR(projected(plane, {40, 2, 3}, 1).x, 28, 1e-9);  // after twelve of them
}

TEST(SurfaceNets, FollowTheWarp) {
  SurfaceNetsOptions options{
      .low = {-0.753, -0.757, -0.261}, .high = {0.75, 0.75, 0.25}, .cell = 0.04};
  options.warp = [](const glm::dvec3& p) { return p * 2.0; };
  const PolygonMesh mesh = surface_nets(torus_distance, options);
  EXPECT_EQ(topology_of(mesh).euler_characteristic(), 0);
  for (const glm::dvec3& p : mesh.positions) EXPECT_NEAR(torus_distance(p), 0.0, 1e-9);
}

TEST(Implicit, DistancesMatchHandComputedOnes) {
  EXPECT_DOUBLE_EQ(rounded_box({3.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.2), 2.0);
  EXPECT_DOUBLE_EQ(rounded_box({0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.2), -1.0);
  EXPECT_DOUBLE_EQ((Cone{{0, 0, 0}, {0, 0, 2}, 0.5, 0.5}({1.0, 0.0, 1.0})), 0.5);
  EXPECT_DOUBLE_EQ((Ellipsoid{{0, 0, 0}, {2, 2, 2}}({3.0, 0.0, 0.0})), 1.5 * 0.5 / 0.75);
  EXPECT_DOUBLE_EQ(extruded(0.5, 0.0, 1.0, 0.1), 0.5);
}

TEST(Implicit, BlendsLeaveFarSurfacesAlone) {
  EXPECT_DOUBLE_EQ(smooth_union(0.1, 0.9, 0.2), 0.1);
  EXPECT_DOUBLE_EQ(smooth_intersection(0.1, 0.9, 0.2), 0.9);
  EXPECT_DOUBLE_EQ(smooth_difference(-0.9, 0.5, 0.2), -0.5);
  EXPECT_LT(smooth_union(0.1, 0.1, 0.2), 0.1);
}

// Two triangles, one of nine times the other's area.
PolygonMesh two_triangles() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {10, 0, 1}, {11, 0, 1}, {10, 1, 1}};
  mesh.add_face(std::vector<std::int32_t>{0, 1, 2});
  mesh.add_face(std::vector<std::int32_t>{3, 4, 5});
  return mesh;
}

TEST(SamplePoints, DrawsEvenlyInArea) {
  int small = 0;
  for (const glm::dvec3& p : sample_uniform(two_triangles(), 20000, 1)) {
    small += p.z > 0.5;
    const glm::dvec3 foot = p.z > 0.5 ? p - glm::dvec3(10, 0, 1) : p;
    EXPECT_GE(foot.x, 0);
    EXPECT_GE(foot.y, 0);
    EXPECT_LE(foot.x + foot.y, (p.z > 0.5 ? 1 : 3) + 1e-12);
  }
  EXPECT_NEAR(small, 2000, 5 * 43);  // five standard deviations
}

TEST(SamplePoints, KeepsPoissonDisksApart) {
  const std::vector<glm::dvec3> points = sample_poisson_disk(two_triangles(), 2000, 3);
  ASSERT_EQ(points.size(), 2000u);
  const PointTree tree(points);
  double nearest = 1e9;
  for (const glm::dvec3& p : points) {
    std::array<Neighbour, 2> found;
    ASSERT_EQ(tree.find_nearest(p, found), 2u);
    nearest = std::min(nearest, found[1].squared_distance);
  }
  // Area 5 for 2000 points: squares of side 0.05.
  EXPECT_GT(std::sqrt(nearest), 0.7 * 0.05);
}

TEST(SamplePoints, IsTheSameForTheSameSeed) {
  EXPECT_EQ(sample_poisson_disk(two_triangles(), 300, 5),
            sample_poisson_disk(two_triangles(), 300, 5));
  EXPECT_NE(sample_uniform(two_triangles(), 300, 5), sample_uniform(two_triangles(), 300, 6));
}

TEST(SamplePoints, AddsNoiseAndOutliers) {
  std::vector<glm::dvec3> points(5000, glm::dvec3(0.0));
  add_noise(points, 0.1, 2);
  double squares = 0;
  for (const glm::dvec3& p : points) squares += glm::dot(p, p);
  EXPECT_NEAR(std::sqrt(squares / 15000), 0.1, 0.003);
  add_outliers(points, 50, 2);
  EXPECT_EQ(points.size(), 5050u);
}

TEST(SamplePoints, WritesPly) {
  const std::vector<glm::dvec3> points = {{0.5, -2, 3}, {4, 5, 6}};
  const std::string text = ply_text(points);
  const MeshFile file =
      read_mesh(std::as_bytes(std::span(text.data(), text.size())), "a.ply", FileFormat::Ply);
  EXPECT_EQ(file.mesh.positions, points);
}

}  // namespace
}  // namespace planish::shapes
