#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "limit/tessellation_error.h"
#include "planish/queries/surface_queries.h"

namespace planish::test {
namespace {

// How often a tessellation winds around a point: the solid angles of its triangles (Van Oosterom &
// Strackee 1983).
double winding_number(const SurfaceMesh& surface, const glm::dvec3& point) {
  double sum = 0;
  for (const Triangle& t : triangles_of_surface(surface)) {
    const auto at = [&](std::size_t k) { return surface.positions[t[k]] - point; };
    const glm::dvec3 a = at(0), b = at(1), c = at(2);
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += 2 * std::atan2(
                   glm::dot(a, glm::cross(b, c)),
                   la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

struct SignCase {
  explicit SignCase(const PolygonMesh& mesh)
      : c(mesh),
        queries(c.limit),
        surface(c.tessellated(3)),
        size(c.surface->placement().diagonal) {}

  // Of points that lie further off than the tessellation does.
  void expect_sign(const glm::dvec3& point) {
    const double distance = queries.closest(point).distance;
    if (distance < 4e-3 * size) return;
    const double winding = winding_number(surface, point);
    ASSERT_NEAR(winding, std::round(winding), 1e-6);
    const bool inside = std::abs(std::lround(winding)) % 2 == 1;
    ASSERT_EQ(queries.signed_distance(point), inside ? -distance : distance);
    ++(inside ? inside_count : outside_count);
  }

  LimitCase c;
  SurfaceQueries queries;
  SurfaceMesh surface;
  double size;
  int inside_count = 0, outside_count = 0;
};

PolygonMesh sharp_cube() {
  PolygonMesh mesh = cube();
  for (const auto& face : faces_of(mesh)) {
    for (std::size_t i = 0; i < face.size(); ++i)
      if (face[i] < face[(i + 1) % face.size()])
        mesh.creases.push_back({face[i], face[(i + 1) % face.size()], 10.0});
  }
  return mesh;
}

std::vector<NamedMesh> creased_meshes() {
  std::vector<NamedMesh> meshes{{"cube", sharp_cube()}};
  for (const std::uint32_t seed : {1u, 4u})
    meshes.push_back({"random " + std::to_string(seed),
                      with_random_creases(random_closed_mesh(seed), 0.3, seed)});
  meshes.push_back({"torus", with_random_creases(torus(7, 5, 2, 1), 0.3, 3)});
  return meshes;
}

TEST(SignedDistance, IsNegativeInside) {
  for (const bool creased : {false, true}) {
    PolygonMesh mesh = cube();
    const auto face = mesh.face(0);
    if (creased) mesh.creases = {{face[0], face[1], 10.0}, {face[1], face[2], 10.0}};
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    std::mt19937 random(13);
    for (int i = 0; i < 50; ++i) {
      const SurfacePoint on = c.limit.evaluate(c.any_place(random));
      EXPECT_NEAR(queries.signed_distance(on.position + 1e-3 * on.normal), 1e-3, 1e-4);
      EXPECT_NEAR(queries.signed_distance(on.position - 1e-3 * on.normal), -1e-3, 1e-4);
    }
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& p : mesh.positions) middle += p / 8.0;
    EXPECT_LT(queries.signed_distance(middle), 0);
    EXPECT_GT(queries.signed_distance(middle + glm::dvec3(10, 11, 12)), 0);
  }
}

// Where the nearest place is one of a sharp edge, the normal of either side can be the wrong one.
TEST(SignedDistance, IsThatOfTheWindingNumberOppositeCreases) {
  for (const auto& [name, mesh] : creased_meshes()) {
    SCOPED_TRACE(name);
    SignCase of(mesh);
    const MeshTopology& topology = of.c.limit.topology();
    int edges = 0;
    for (std::int32_t corner = 0; corner < topology.corner_count() && edges < 12; ++corner) {
      const std::int32_t twin = topology.twin(corner);
      if (twin < 0 || !of.c.surface->patches().is_sharp(corner)) continue;
      ++edges;
      const double u = 0.05 + 0.9 * (edges % 7) / 6;
      const SurfacePoint here = of.c.limit.evaluate(surface_parameter(topology, corner, u, 0));
      const glm::dvec3 there =
          of.c.limit.evaluate(surface_parameter(topology, topology.next(twin), 0, u)).normal;
      // Across the edge in its own plane, between both normals and beyond them.
      for (const double share : {-0.4, 0.0, 0.3, 0.5, 0.9, 1.0, 1.4}) {
        const glm::dvec3 way = (1 - share) * here.normal + share * there;
        if (glm::length(way) < 0.1) continue;
        for (const double off : {6e-3, 0.05, 1.0}) {
          for (const double side : {1.0, -1.0})
            of.expect_sign(here.position + side * off * of.size * glm::normalize(way));
        }
      }
    }
    EXPECT_GT(edges, 5);
    EXPECT_GT(of.inside_count, 10);
    EXPECT_GT(of.outside_count, 50);
  }
}

// From points before the places where the first direction that is tried only touches the surface.
TEST(SignedDistance, IsThatOfTheWindingNumberWhereRaysGraze) {
  const glm::dvec3 along = glm::normalize(glm::dvec3(0.8191, 0.4233, 0.3874));
  for (const auto& [name, mesh] : creased_meshes()) {
    SCOPED_TRACE(name);
    SignCase of(mesh);
    const MeshTopology& topology = of.c.limit.topology();
    int places = 0;
    const auto on = [&](std::int32_t corner, double u, double v) {
      return of.c.limit.evaluate(surface_parameter(topology, corner, u, v));
    };
    const auto ask_before = [&](const glm::dvec3& position) {
      ++places;
      for (const double way : {0.02, 0.3, 1.1}) of.expect_sign(position - way * of.size * along);
    };
    for (std::int32_t corner = 0; corner < topology.corner_count() && places < 16; ++corner) {
      for (const double v : {0.23, 0.71}) {
        const auto facing = [&](double u) { return glm::dot(on(corner, u, v).normal, along) > 0; };
        double low = 0.01, high = 0.99;
        if (facing(low) == facing(high)) continue;
        for (int i = 0; i < 60; ++i) {
          const double middle = 0.5 * (low + high);
          (facing(middle) == facing(low) ? low : high) = middle;
        }
        ask_before(on(corner, low, v).position);
      }
      // And where it touches a sharp edge.
      const std::int32_t twin = topology.twin(corner);
      if (twin < 0 || !of.c.surface->patches().is_sharp(corner)) continue;
      const double u = 0.37;
      const bool here = glm::dot(on(corner, u, 0).normal, along) > 0;
      const bool there = glm::dot(on(topology.next(twin), 0, u).normal, along) > 0;
      if (here != there) ask_before(on(corner, u, 0).position);
    }
    EXPECT_GT(places, 5);
    EXPECT_GT(of.outside_count, 10);
  }
}

}  // namespace
}  // namespace planish::test
