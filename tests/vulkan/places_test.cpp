// The surface at lists of places, in single precision on a device, against LimitSurface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "support/meshes.h"
#include "vulkan/large_rings.h"
#include "vulkan/places_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;

/// Closed, open, creased, with holes; valences 3 to 20, faces of 3 to 20 corners, valence 2.
std::vector<test::NamedMesh> meshes_for_places() {
  std::vector<test::NamedMesh> meshes = {{"torus", test::torus(12, 7, 2, 0.7)},
                                         {"icosphere", test::icosphere(1)},
                                         {"plate", test::plate_with_hole(5)},
                                         {"L", test::l_shaped_plate(2)},
                                         {"valence 2", test::cube_with_split_edges()}};
  for (int n = 3; n <= 20; ++n) {
    meshes.push_back({"bipyramid " + std::to_string(n), test::bipyramid(n)});
    meshes.push_back({"prism " + std::to_string(n), test::prism(n)});
  }
  const std::vector<test::NamedMesh> kinds = random_kinds();
  meshes.insert(meshes.end(), kinds.begin(), kinds.end());
  const std::vector<test::NamedMesh> rings = large_rings();
  meshes.insert(meshes.end(), rings.begin(), rings.end());
  for (test::NamedMesh& mesh : meshes) mesh.mesh = in_floats(mesh.mesh);
  return meshes;
}

struct PlaceErrors {
  double position = 0, first = 0, second = 0, normal = 0;
};

// First derivatives in parts of themselves, second ones of the first ones and themselves: what
// rounding leaves is in proportion to what is added up. At `distance` from V or F double itself has
// rounded points of the patch before it took differences and made them 1 / distance larger, twice
// for second derivatives.
void compare_place(const PlaceResult& found, const SurfacePoint& expected, double size,
                   double distance, PlaceErrors& errors) {
  const auto grow = [](double& largest, double value) {
    if (!(value <= largest)) largest = value;
  };
  const auto off = [](const glm::vec3& a, const glm::dvec3& b) {
    return glm::distance(glm::dvec3(a), b);
  };
  const double first = glm::length(expected.du) + glm::length(expected.dv) + 0.01 * size;
  grow(errors.position, off(found.position, expected.position) / size);
  const bool is_singular = found.state == PlaceState::Singular;
  ASSERT_TRUE(is_singular || found.state == PlaceState::Regular);
  // Beside such a place first derivatives depend on the direction.
  if (!is_singular || distance == 0)
    grow(errors.first, (off(found.du, expected.du) + off(found.dv, expected.dv)) / first);
  if (is_singular) {
    ASSERT_LT(distance, std::ldexp(1.0, -23));
    for (const glm::vec3& d : {found.duu, found.duv, found.dvv}) ASSERT_EQ(d, glm::vec3(0));
  } else {
    ASSERT_TRUE(expected.has_second);
    const double second = glm::length(expected.duu) + glm::length(expected.duv) +
                          glm::length(expected.dvv) + first + 1e-9 * size / (distance * distance);
    grow(errors.second, (off(found.duu, expected.duu) + off(found.duv, expected.duv) +
                         off(found.dvv, expected.dvv)) /
                            second);
  }
  // At vertices of valence 2 tangents are parallel, and LimitSurface has a normal of places around.
  if (is_singular && found.normal == glm::vec3(0)) return;
  // The less of a direction the more parallel tangents are.
  const double area = glm::length(glm::cross(expected.du, expected.dv)) /
                      (glm::length(expected.du) * glm::length(expected.dv));
  const double shorter = std::min(glm::length(expected.du), glm::length(expected.dv));
  const double noise = distance == 0 ? 0 : 1e-10 * size / (distance * shorter);
  if (area > 1e-3) grow(errors.normal, area * off(found.normal, expected.normal) / (1 + noise));
}

// Of a place in its corner's patch from the nearer one of V and F.
double distance_to_ends(const MeshTopology& topology, const SurfaceParameter& at) {
  const CornerParameter in = corner_parameter(topology, at);
  return std::min(std::max(in.u, in.v), std::max(1 - in.u, 1 - in.v));
}

TEST_F(PlacesOnDevice, AreTheLimitSurfaces) {
  for (const ReadPath path : {ReadPath::Texel, ReadPath::Storage}) {
    open_reading(path);
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      PlaceErrors worst;
      for (const auto& [name, mesh] : meshes_for_places()) {
        SCOPED_TRACE(name);
        const PlaceOracle oracle(mesh, weights);
        const auto places = places_on(oracle.limit.topology(), 7, 12);
        const auto found = results_of(mesh, places, {.weights = weights});
        const double size = oracle.limit.surface().placement().diagonal;
        PlaceErrors errors;
        for (std::size_t i = 0; i < places.size(); ++i) {
          const SurfaceParameter at{static_cast<std::int32_t>(places[i].face), places[i].u,
                                    places[i].v};
          compare_place(found[i], oracle.limit.evaluate(at), size,
                        distance_to_ends(oracle.limit.topology(), at), errors);
          ASSERT_FALSE(HasFatalFailure()) << places[i].face << " " << at.u << " " << at.v;
        }
        EXPECT_LT(errors.position, 3e-7);
        EXPECT_LT(errors.first, 1e-5);
        EXPECT_LT(errors.second, 1e-5);
        EXPECT_LT(errors.normal, 1e-5);
        worst = {std::max(worst.position, errors.position), std::max(worst.first, errors.first),
                 std::max(worst.second, errors.second), std::max(worst.normal, errors.normal)};
      }
      std::printf("  off by at most %.1e, du %.1e, duu %.1e, normals %.1e\n", worst.position,
                  worst.first, worst.second, worst.normal);
    }
  }
}

// At vertices and centres themselves the limits are closed forms.
TEST_F(PlacesOnDevice, KnowVerticesAndCentres) {
  for (const auto& [name, mesh] : meshes_for_places()) {
    SCOPED_TRACE(name);
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const MeshTopology& topology = oracle.limit.topology();
    std::vector<PlaceRecord> places;
    for (std::int32_t c = 0; c < topology.corner_count(); ++c)
      for (const double at : {0.0, 1.0}) {
        const SurfaceParameter p = surface_parameter(topology, c, at, at);
        places.push_back({static_cast<std::uint32_t>(p.face), float(p.u), float(p.v)});
      }
    const auto found = results_of(mesh, places);
    const double size = oracle.limit.surface().placement().diagonal;
    PlaceErrors errors;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SurfacePoint expected = oracle.limit.evaluate(
          {static_cast<std::int32_t>(places[i].face), places[i].u, places[i].v});
      ASSERT_EQ(found[i].state == PlaceState::Regular, expected.has_second) << i;
      compare_place(found[i], expected, size, 0, errors);
    }
    EXPECT_LT(errors.position, 3e-7);
    EXPECT_LT(errors.first, 1e-5);
    EXPECT_LT(errors.normal, 1e-5);
  }
}

TEST_F(PlacesOnDevice, LieOnTheSurfaceOfASolve) {
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    const PolygonMesh mesh =
        in_floats(test::with_random_creases(test::random_open_mesh(2), 0.1, 3));
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const MeshTopology& topology = oracle.limit.topology();
    std::vector<PlaceRecord> places;
    std::vector<std::int32_t> vertices;
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      const SurfaceParameter p = surface_parameter(topology, c, 0, 0);
      places.push_back({static_cast<std::uint32_t>(p.face), float(p.u), float(p.v)});
      vertices.push_back(topology.vertex_of(c));
    }
    const auto found = results_of(mesh, places, {.method = method}, 60);
    for (std::size_t i = 0; i < places.size(); ++i)
      ASSERT_LT(glm::distance(glm::dvec3(found[i].position), mesh.positions[vertices[i]]), 4e-6)
          << i;
  }
}

}  // namespace
}  // namespace planish::testing
