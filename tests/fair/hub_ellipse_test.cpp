#include "planish/fair/fold_cure.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

// The corner of a box, vertex 0, whose floor is cut into `needles` and whose two walls are whole:
// what a CAD program makes of a part's bottom.
PolygonMesh box_corner(int needles) {
  PolygonMesh mesh;
  mesh.positions.emplace_back(0.0, 0.0, 0.0);
  for (int i = 0; i <= needles; ++i) {
    const double angle = std::numbers::pi / 2 * i / needles;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
  }
  const int top = mesh.vertex_count();
  mesh.positions.emplace_back(0.0, 0.0, 1.0);
  // Seen from below the floor's needles run clockwise about the corner.
  for (int i = 1; i <= needles; ++i) mesh.add_face(std::array{0, i + 1, i});
  mesh.add_face(std::array{0, 1, top});
  mesh.add_face(std::array{0, top, needles + 1});
  return mesh;
}

struct Hub {
  explicit Hub(const PolygonMesh& mesh)
      : c(mesh),
        topology(make_fair_topology(c.mesh, c.subdivision)),
        face_normals(unit_face_normals(topology, c.given)),
        plane(vertex_normals(topology, c.given, face_normals)[0]) {}

  FairCase c;
  FairTopology topology;
  std::vector<dvec3> face_normals;
  dvec3 plane;
};

// The least product of the polygon's sides at vertex 0 with what leads into the faces that they
// cross edges of, as a part of the side's length.
double least_crossing(const Hub& hub, std::span<const dvec3> offsets) {
  const int32_t first = hub.topology.ring_offsets[0], n = hub.topology.valence(0);
  double least = 1;
  for (int32_t i = 0; i < n; ++i) {
    const int32_t corner = hub.topology.ring_corners[first + i];
    const int32_t before = hub.topology.ring_corners[first + (i + n - 1) % n];
    const dvec3 side = offsets[corner] - offsets[before];
    const dvec3 edge =
        glm::normalize(hub.c.given[hub.topology.ring_next[first + i]] - hub.c.given[0]);
    for (const int32_t c : {corner, before}) {
      const dvec3 inward = glm::cross(hub.face_normals[hub.topology.corner_faces[c]], edge);
      least = std::min(least, glm::dot(side, inward) / glm::length(side));
    }
  }
  return least;
}

std::vector<dvec3> ellipse_polygon(const Hub& hub, const glm::vec4& ellipse) {
  std::vector<dvec3> offsets(std::size_t(hub.topology.state_size), dvec3(0.0));
  build_hub_ellipse(hub.topology, hub.c.given, 0, hub.plane, ellipse, 0.01, offsets);
  return offsets;
}

TEST(HubEllipse, ItsSidesCrossAllEdgesOfABoxesCorner) {
  for (const int needles : {5, 12, 21, 40}) {
    const Hub hub(box_corner(needles));
    const glm::vec4 ellipse =
        hub_ellipse(hub.topology, hub.c.given, hub.face_normals, 0, hub.plane);
    ASSERT_TRUE(is_ellipse(ellipse)) << needles;
    const std::vector<dvec3> offsets = ellipse_polygon(hub, ellipse);
    EXPECT_GT(least_crossing(hub, offsets), 0.02) << needles;
    // A circle's do not, from a few needles on.
    if (needles > 5) {
      const glm::vec4 circle(1.0F, 0.0F, 0.0F, 1.0F);
      EXPECT_LT(least_crossing(hub, ellipse_polygon(hub, circle)), 0) << needles;
    }
    // About the vertex, of the wanted size, in the plane and not turned over.
    dvec3 sum(0.0);
    double farthest = 0;
    for (int32_t i = hub.topology.ring_offsets[0]; i < hub.topology.ring_offsets[1]; ++i) {
      const dvec3& offset = offsets[hub.topology.ring_corners[i]];
      sum += offset;
      farthest = std::max(farthest, glm::length(offset));
      EXPECT_NEAR(glm::dot(offset, hub.plane), 0, 1e-15);
    }
    EXPECT_LT(glm::length(sum), 1e-15 * hub.topology.valence(0));
    EXPECT_NEAR(farthest, 0.01, 1e-8);
    const dvec3 normal = limit_normal(hub.topology, hub.topology.valence(0), [&](int32_t i) {
      return offsets[hub.topology.ring_corners[hub.topology.ring_offsets[0] + i]];
    });
    EXPECT_GT(glm::dot(normal, hub.plane), 0.99 * glm::length(normal));
  }
}

TEST(HubEllipse, TurnsWithTheMesh) {
  const Hub hub(box_corner(12));
  const glm::vec4 ellipse = hub_ellipse(hub.topology, hub.c.given, hub.face_normals, 0, hub.plane);
  const dvec3 axis = glm::normalize(dvec3(1.0, 2.0, -0.5));
  const auto turned = [&](const dvec3& p) {
    return std::cos(1.9) * p + std::sin(1.9) * glm::cross(axis, p) +
           (1 - std::cos(1.9)) * glm::dot(axis, p) * axis;
  };
  Hub other(box_corner(12));
  for (dvec3& p : other.c.given) p = turned(p);
  other.face_normals = unit_face_normals(other.topology, other.c.given);
  other.plane = turned(hub.plane);
  const std::vector<dvec3> before = ellipse_polygon(hub, ellipse);
  const std::vector<dvec3> after = ellipse_polygon(other, ellipse);
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_LT(glm::distance(after[i], turned(before[i])), 1e-15);
}

TEST(HubEllipse, IsNoneWhereNoPlaneSeesTheFaces) {
  Hub hub(box_corner(12));
  EXPECT_FALSE(is_ellipse(hub_ellipse(hub.topology, hub.c.given, hub.face_normals, 0, -hub.plane)));
}

TEST(HubEllipse, IsChosenWhereTheCureChangedAVertexThatIsFlagged) {
  const Hub hub(box_corner(12));
  const std::size_t count = hub.c.given.size();
  FairDecisions decisions;
  decisions.cures.assign(count, 1);
  decisions.leans.assign(count, glm::vec2(0.0F));
  std::vector<std::uint8_t> flagged(count, 1);
  const auto chosen = choose_ellipses(hub.topology, hub.c.given, flagged, decisions);
  ASSERT_EQ(decisions.ellipses.size(), count);
  // All others are on the boundary.
  for (std::size_t v = 0; v < count; ++v) {
    EXPECT_EQ(chosen[v], v == 0) << v;
    EXPECT_EQ(is_ellipse(decisions.ellipses[v]), v == 0) << v;
  }
  // Once.
  EXPECT_EQ(choose_ellipses(hub.topology, hub.c.given, flagged, decisions)[0], 0);
  decisions.ellipses.clear();
  decisions.cures[0] = 0;
  EXPECT_EQ(choose_ellipses(hub.topology, hub.c.given, flagged, decisions)[0], 0);
}

}  // namespace
}  // namespace planish::test
