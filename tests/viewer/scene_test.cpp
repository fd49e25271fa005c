#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "viewer/crowd.h"
#include "viewer/fixture.h"
#include "viewer/renderer.h"
#include "viewer/scene.h"

namespace planish::testing {
namespace {

using viewer::OrbitCamera;

glm::vec3 projected(const OrbitCamera& camera, const glm::vec3& point, float aspect) {
  const glm::vec4 clip = camera.clip_from_world(aspect) * glm::vec4(point, 1);
  return glm::vec3(clip) / clip.w;
}

TEST(OrbitCamera, KeepsItsSphereInView) {
  OrbitCamera camera;
  camera.centre = {3, -1, 2};
  camera.radius = 2.5f;
  for (const float aspect : {0.4f, 1.0f, 2.5f})
    for (const float elevation : {-89.0f, 20.0f, 89.0f}) {
      camera.elevation_degrees = elevation;
      const glm::vec3 middle = projected(camera, camera.centre, aspect);
      EXPECT_NEAR(middle.x, 0, 1e-5);
      EXPECT_NEAR(middle.y, 0, 1e-5);
      float largest = 0;
      for (int i = 0; i < 400; ++i) {
        const float z = -1 + 2 * (static_cast<float>(i) + 0.5f) / 400, turn = 2.4f * i;
        const float r = std::sqrt(1 - z * z);
        const glm::vec3 p = projected(
            camera,
            camera.centre + camera.radius * glm::vec3(r * std::cos(turn), r * std::sin(turn), z),
            aspect);
        largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
        EXPECT_GT(p.z, 0);
        EXPECT_LT(p.z, 1);
      }
      EXPECT_LT(largest, 1);
      EXPECT_GT(largest, 0.9);
    }
}

TEST(OrbitCamera, UpIsUpAndRightIsRight) {
  OrbitCamera camera;
  camera.azimuth_degrees = 0;
  camera.elevation_degrees = 0;
  EXPECT_GT(camera.eye(1).z, 0);                       // looks along -z
  EXPECT_LT(projected(camera, {0, 0.5f, 0}, 1).y, 0);  // Vulkan's y points down
  EXPECT_GT(projected(camera, {0.5f, 0, 0}, 1).x, 0);
  EXPECT_LT(projected(camera, {0, 0, 0.5f}, 1).z, projected(camera, {0, 0, -0.5f}, 1).z);
}

TEST(OrbitCamera, DragsThingsAlongAndStopsAtThePoles) {
  OrbitCamera camera;
  camera.azimuth_degrees = camera.elevation_degrees = 0;
  camera.orbit(0.1f, 0.1f);
  const glm::vec3 front = projected(camera, {0, 0, 1}, 1);
  EXPECT_GT(front.x, 0);
  EXPECT_GT(front.y, 0);
  camera.orbit(0, 10);
  EXPECT_EQ(camera.elevation_degrees, 89);
  for (int i = 0; i < 100; ++i) camera.zoom_by(2);
  EXPECT_EQ(camera.zoom, 20);
}

TEST(OrbitCamera, FramesABoxOfPoints) {
  const std::vector<glm::dvec3> points{{1, 2, 3}, {3, 2, 3}, {1, 4, 4}};
  const OrbitCamera camera = viewer::camera_around(points);
  EXPECT_EQ(camera.centre, glm::vec3(2, 3, 3.5));
  EXPECT_FLOAT_EQ(camera.radius, 1.5f);
}

TEST(OrbitCamera, KeyLightComesFromTheUpperLeftOfTheEye) {
  OrbitCamera camera;
  for (const float azimuth : {0.0f, 120.0f, -75.0f}) {
    camera.azimuth_degrees = azimuth;
    const glm::vec3 key = camera.key_light();
    EXPECT_NEAR(glm::length(key), 1, 1e-6);
    const glm::vec3 lamp = projected(camera, 0.5f * key, 1);
    EXPECT_LT(lamp.x, 0);
    EXPECT_LT(lamp.y, 0);
    EXPECT_GT(glm::dot(key, glm::normalize(camera.eye(1))), 0.3);
  }
}

using viewer::Animation;

TEST(Animation, BeginsAtRest) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  std::vector<glm::vec3> points(mesh.positions.size());
  Animation(mesh.positions).pose(0, points);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(glm::distance(glm::dvec3(points[i]), mesh.positions[i]), 1e-6) << i;
}

TEST(Animation, MovesSmoothly) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  const Animation animation(mesh.positions);
  std::vector<glm::vec3> before(mesh.positions.size()), points(before), after(before);
  constexpr double kStep = 1 / 60.0;
  // Accelerations in diameters a second squared stay below those of the formula's terms.
  constexpr double kMostAcceleration = 2, kDiameter = 5.4;
  double farthest = 0;
  for (int frame = 1; frame < 420; ++frame) {
    animation.pose((frame - 1) * kStep, before);
    animation.pose(frame * kStep, points);
    animation.pose((frame + 1) * kStep, after);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double bend = glm::length(after[i] - 2.0f * points[i] + before[i]);
      ASSERT_LT(bend, kMostAcceleration * kDiameter * kStep * kStep) << frame;
      farthest = std::max(farthest, glm::distance(glm::dvec3(points[i]), mesh.positions[i]));
    }
  }
  EXPECT_GT(farthest, 0.05 * kDiameter);
}

TEST(Animation, FlatShapesStayFinite) {
  const std::vector<glm::dvec3> flat{{0, 1, 0}, {1, 1, 0}, {1, 1, 1}};
  std::vector<glm::vec3> points(flat.size());
  Animation(flat).pose(1, points);
  for (const glm::vec3& p : points) {
    EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.z));
    EXPECT_EQ(p.y, 1);
  }
}

using viewer::nearest_given;
using viewer::NearestGiven;

std::vector<std::uint32_t> rows_of(const NearestGiven& nearest, std::size_t vertex) {
  return {nearest.rows.begin() + nearest.offsets[vertex],
          nearest.rows.begin() + nearest.offsets[vertex + 1]};
}

TEST(NearestGiven, OfAGivenPointIsItself) {
  vulkan::SystemOptions options;
  for (options.level = 0; options.level < 3; ++options.level) {
    const vulkan::System system(test::torus(9, 6, 2, 0.7), options);
    const NearestGiven nearest = nearest_given(system);
    ASSERT_EQ(nearest.offsets.size(), static_cast<std::size_t>(system.vertex_count()) + 1);
    for (std::uint32_t i = 0; i < system.used_vertices().size(); ++i)
      EXPECT_THAT(rows_of(nearest, i), ::testing::ElementsAre(i));
  }
}

TEST(NearestGiven, OfTheCubesLevelOneAreEdgeEndsAndFaceCorners) {
  vulkan::SystemOptions options;
  options.level = 1;
  const vulkan::System system(test::cube(), options);  // 8 corners, 12 edges, 6 faces
  ASSERT_EQ(system.vertex_count(), 26);
  std::vector<std::size_t> sizes;
  const NearestGiven nearest = nearest_given(system);
  for (std::size_t i = 8; i < 26; ++i) sizes.push_back(rows_of(nearest, i).size());
  EXPECT_EQ(std::ranges::count(sizes, 2u), 12);
  EXPECT_EQ(std::ranges::count(sizes, 4u), 6);
}

// Every face stands alone there: most of its corners are copies of vertices in other faces.
TEST(NearestGiven, ReachesEveryFaceOfACubeWithCreasedEdges) {
  PolygonMesh cube = test::cube();
  for (std::int32_t f = 0; f < cube.face_count(); ++f)
    for (std::int32_t k = 0; k < 4; ++k)
      cube.creases.push_back({cube.face(f)[k], cube.face(f)[(k + 1) % 4]});
  for (std::int32_t v = 0; v < 8; ++v) cube.corners.push_back({v});
  vulkan::SystemOptions options;
  options.level = 1;
  const vulkan::System system(cube, options);
  ASSERT_EQ(system.vertex_count(), 6 * 9);  // 9 in each face, none shared
  const NearestGiven nearest = nearest_given(system);
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i < 54; ++i) sizes.push_back(rows_of(nearest, i).size());
  EXPECT_EQ(std::ranges::count(sizes, 1u), 24);
  EXPECT_EQ(std::ranges::count(sizes, 2u), 24);
  EXPECT_EQ(std::ranges::count(sizes, 4u), 6);
}

// Scenes of the fair method: how they are opened, played, edited, and what their cage is.

using namespace viewer;

class FairSceneTest : public ViewerTest {
 protected:
  // Of the diagonal: single precision.
  static constexpr double kRounding = 4e-6;

  static void expect_drawn(const Headless& headless, const SurfaceMesh& surface) {
    const auto drawn = headless.vertices();
    ASSERT_EQ(drawn.size(), surface.positions.size());
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      ASSERT_LT(glm::distance(glm::dvec3(drawn[i].position), surface.positions[i]),
                kRounding * headless.system().diagonal())
          << i;
      ASSERT_GT(glm::dot(drawn[i].normal, surface.normals[i]), 0.9999f) << i;
    }
  }

  // The pairs, which name each edge once.
  static std::set<std::pair<std::uint32_t, std::uint32_t>> edges_of(const Scene& scene) {
    const vulkan::System system(scene.mesh, scene.system);
    const std::vector<std::uint32_t> flat = cage_edges(scene, system.used_vertices());
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::size_t i = 0; i < flat.size(); i += 2)
      EXPECT_TRUE(edges.emplace(std::minmax(flat[i], flat[i + 1])).second) << i;
    return edges;
  }
};

TEST_F(FairSceneTest, FramesAreTheCpusWithTheDecisionsOfTheRestPose) {
  for (PolygonMesh mesh : {test::icosphere(1), test::torus(9, 6, 2, 0.7), test::cube()}) {
    const Scene scene = fair_scene_of(std::move(mesh));
    Headless headless(*device_, scene, options_for(scene.mesh));
    headless.run(30);
    expect_drawn(headless, surface_by_cpu(scene, posed(scene.mesh, 29)));
    EXPECT_LT(headless.status().residual, kRounding * headless.system().diagonal());
  }
}

// Doo and Sabin 1978: in the mesh that a step makes four edges meet at every vertex, two of the
// face's own polygon and two towards the faces beside it.
TEST_F(FairSceneTest, CageJoinsTheCornersOfLevelOne) {
  const Scene scene = fair_scene_of(test::icosphere(1));
  const MeshTopology topology(scene.mesh);
  std::map<std::uint32_t, int> degrees;
  for (const auto& [a, b] : edges_of(scene)) {
    ++degrees[a];
    ++degrees[b];
    const auto c = static_cast<std::int32_t>(a), d = static_cast<std::int32_t>(b);
    if (topology.face_of(c) == topology.face_of(d))
      EXPECT_TRUE(topology.next(c) == d || topology.next(d) == c) << c << ' ' << d;
    else
      EXPECT_EQ(topology.vertex_of(c), topology.vertex_of(d));
  }
  EXPECT_EQ(degrees.size(), static_cast<std::size_t>(topology.corner_count()));
  for (const auto& [point, degree] : degrees) EXPECT_EQ(degree, 4) << point;
}

// Each edge once, between vertices that are used.
TEST_F(FairSceneTest, ProgressiveCagesHaveTheMeshsEdges) {
  Scene scene = scene_of(test::icosphere(1));
  scene.mesh.positions.insert(scene.mesh.positions.begin(), glm::dvec3(5));
  for (std::int32_t& vertex : scene.mesh.face_vertices) ++vertex;
  const auto edges = edges_of(scene);
  const MeshTopology topology(test::icosphere(1));
  EXPECT_EQ(edges.size(), static_cast<std::size_t>(topology.edge_count()));
  for (const auto& [a, b] : edges)
    EXPECT_GE(topology.find_edge(static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)), 0);
}

TEST_F(FairSceneTest, TrianglesOpenAsTheCommandFitsThem) {
  Scene scene = load_scene(PLANISH_SCENES "/l_bracket.obj", "");
  EXPECT_EQ(scene.system.method, InterpolationMethod::Fair);
  ASSERT_TRUE(scene.decisions);
  const Scene moved = std::move(scene);
  EXPECT_EQ(moved.system.fair_decisions, moved.decisions.get());
  const vulkan::System system(moved.mesh, moved.system);
  EXPECT_EQ(moved.decisions->halvings.size(), system.used_vertices().size());
  Headless headless(*device_, moved, options_for(moved.mesh));
  headless.run(3);
  expect_drawn(headless, surface_by_cpu(moved, posed(moved.mesh, 2)));
  // Where that is the only one, the other.
  const Scene other =
      load_scene(PLANISH_SCENES "/l_bracket.obj", "", InterpolationMethod::Progressive);
  EXPECT_EQ(other.system.method, InterpolationMethod::Progressive);
  EXPECT_FALSE(other.system.fair_decisions);
}

TEST_F(FairSceneTest, EditedPointsAreDrawnAndStayOnTheSurface) {
  const Scene scene = fair_scene_of(test::icosphere(1));
  EditSession session(scene);
  Headless headless(*device_, scene, options_for(scene.mesh));
  session.select({3});
  session.drag_to({0.1, 0.2, 0});
  session.end_drag();
  PolygonMesh pose = scene.mesh;
  pose.positions[3] += glm::dvec3(0.1, 0.2, 0);
  headless.show(session, Headless::Solved::On);
  expect_drawn(headless, surface_by_cpu(scene, pose));
  EXPECT_LT(session.editor().measured_error(), 1e-6);
  // Other rules, which the old decisions do not know: still through all points.
  session.toggle_corner(3);
  headless.show(session, Headless::Solved::On);
  EXPECT_LT(headless.status().residual, kRounding * headless.system().diagonal());
}

// The viewer's crowd: all levels in one picture, which looks as one of the finest level alone.

class CrowdTest : public ViewerTest {};

CrowdOptions small_crowd(std::uint32_t count) {
  CrowdOptions options;
  options.extent = {320, 180};
  options.count = count;
  return options;
}

TEST_F(CrowdTest, LooksAsItsFinestLevel) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  std::vector<std::uint8_t> pictures[3];
  std::uint64_t triangles[3];
  for (int i = 0; i < 3; ++i) {
    CrowdOptions options = small_crowd(60);
    options.chord_pixels = 0.1f;
    if (i == 1) options.levels = {4};
    if (i == 2) options.levels = {1};
    Crowd crowd(*device_, scene_of(mesh), options);
    crowd.run(3);
    pictures[i] = crowd.picture();
    triangles[i] = crowd.figures().triangles;
  }
  const auto differing = [&](int i) {
    std::size_t differ = 0;
    for (std::size_t k = 0; k < pictures[0].size(); ++k)
      differ += std::abs(pictures[1][k] - pictures[i][k]) > 6;
    return differ;
  };
  EXPECT_LT(differing(0), pictures[0].size() / 200);
  EXPECT_GT(differing(2), 2 * differing(0));
  EXPECT_LT(5 * triangles[0], triangles[1]);
  EXPECT_GT(triangles[0], triangles[2]);
}

// In one frame: from near to far, and some that nobody sees.
TEST_F(CrowdTest, OfAThousandHasAllLevels) {
  CrowdOptions options = small_crowd(1000);
  Crowd crowd(
      *device_,
      load_scene(PLANISH_SCENES "/cube_with_windows.obj", "", InterpolationMethod::Progressive),
      options);
  crowd.run(1);
  const CrowdFigures figures = crowd.figures();
  EXPECT_EQ(std::accumulate(figures.instances.begin(), figures.instances.end(), figures.unseen),
            1000u);
  EXPECT_GT(figures.unseen, 100u);
  for (std::size_t k = 0; k + 1 < figures.instances.size(); ++k)
    EXPECT_GT(figures.instances[k], 0u) << k;
  // Levels for what is near are for few.
  EXPECT_TRUE(std::is_sorted(figures.instances.rbegin(), figures.instances.rend()));
}

// A textured crowd whose eye walks through it: what temporal anti-aliasing asks of a frame. Where a
// pixel came from by its motion, the frame before shows the same piece of surface, though instances
// move and change their levels meanwhile; without motions it shows another one.
TEST_F(CrowdTest, MotionsLeadToTheSamePieceOfTheFrameBefore) {
  Scene scene = load_scene(PLANISH_SCENES "/mapped_cube.obj", "", InterpolationMethod::Progressive);
  scene.system.textured = true;
  CrowdOptions options = small_crowd(200);
  options.motions = true;
  options.chord_pixels = 0.2f;
  options.walk = 20;
  Crowd crowd(*device_, std::move(scene), options);
  crowd.run(1);
  for (const glm::vec4& pixel : crowd.motions())  // the first frame has none before it
    ASSERT_LT(glm::length(glm::vec2(pixel)), 0.01f);
  const auto [width, height] = options.extent;
  std::vector<glm::vec4> before = crowd.motions();
  CrowdFigures figures = crowd.figures();
  std::size_t checked = 0, same = 0, same_without = 0, changes = 0;
  for (int frame = 1; frame < 6; ++frame) {
    crowd.run(1);
    const std::vector<glm::vec4> now = crowd.motions();
    const CrowdFigures last = std::exchange(figures, crowd.figures());
    changes += last.instances != figures.instances;
    for (std::uint32_t y = 0; y < height; ++y)
      for (std::uint32_t x = 0; x < width; ++x) {
        const glm::vec4& pixel = now[y * width + x];
        const glm::vec2 motion(pixel), uv(pixel.z, pixel.w);
        const glm::vec2 from = glm::vec2(x, y) - motion;
        if (glm::length(motion) < 1.5f || from.x < 0 || from.y < 0 || from.x > width - 1.0f ||
            from.y > height - 1.0f)
          continue;
        // Where pixels tell pieces apart: neither at outlines nor of what is far away.
        const auto is_apart = [&](std::uint32_t i, std::uint32_t j) {
          const glm::vec4& beside = now[std::min(j, height - 1) * width + std::min(i, width - 1)];
          return glm::distance(uv, glm::vec2(beside.z, beside.w)) > 1.0f / 64;
        };
        if (is_apart(x + 1, y) || is_apart(x, y + 1)) continue;
        // Within a square of the board, of which there are 16 a side.
        const auto shows_it = [&](const glm::vec2& place) {
          const glm::uvec2 nearest(place + 0.5f);
          const glm::vec4& other = before[nearest.y * width + nearest.x];
          return glm::distance(uv, glm::vec2(other.z, other.w)) < 1.0f / 32;
        };
        ++checked;
        same += shows_it(from);
        same_without += shows_it({x, y});
      }
    before = now;
  }
  EXPECT_GT(checked, 20000u);
  EXPECT_GT(same, checked * 85 / 100);
  EXPECT_LT(same_without, checked / 2);
  EXPECT_GE(changes, 4u);
  std::size_t colourful = 0;
  const std::vector<std::uint8_t> picture = crowd.picture();
  for (std::size_t i = 0; i < picture.size(); i += 3)
    colourful += std::abs(picture[i] - picture[i + 2]) > 40;
  EXPECT_GT(colourful, picture.size() / 3 / 50);
}

}  // namespace
}  // namespace planish::testing
