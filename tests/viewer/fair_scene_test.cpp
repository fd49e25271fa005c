// Scenes of the fair method: how they are opened, played, edited, and what their cage is.
#include <gmock/gmock.h>

#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <utility>

#include "planish/mesh/mesh_topology.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "viewer/fixture.h"
#include "viewer/renderer.h"
#include "viewer/scene.h"

namespace planish::testing {
namespace {

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

}  // namespace
}  // namespace planish::testing
