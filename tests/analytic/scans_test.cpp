#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat3x3.hpp>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "analytic_case.h"
#include "planish/brep/brep.h"

// Meshes through samples of parts: no vertex lies on an edge, and triangles reach across.

namespace planish::test {
namespace {

using Kinds = std::array<std::int64_t, kAnalyticKinds>;
// Below 0 inside; of a distance's slope near the surface.
using Solid = std::function<double(const glm::dvec3&)>;

double box(const glm::dvec3& p, const glm::dvec3& half) {
  const glm::dvec3 off = glm::abs(p) - half;
  return std::max({off.x, off.y, off.z});
}
double cylinder(const glm::dvec3& p, double radius) {
  return std::sqrt(p.x * p.x + p.y * p.y) - radius;
}

// Where edges of a grid of tetrahedra cross the surface (marching tetrahedra), and off it by noise.
PolygonMesh sampled(const Solid& solid, double reach, int cells, double deviation) {
  const auto corner = [&](const std::array<int, 3>& at) {
    return reach * (2.0 / cells * glm::dvec3(at[0], at[1], at[2]) - 1.0);
  };
  PolygonMesh mesh;
  std::map<std::array<int, 6>, std::int32_t> vertices;
  const auto crossing = [&](std::array<int, 3> inside, std::array<int, 3> outside) {
    const auto [at, is_new] =
        vertices.try_emplace({inside[0], inside[1], inside[2], outside[0], outside[1], outside[2]},
                             static_cast<std::int32_t>(mesh.positions.size()));
    if (!is_new) return at->second;
    glm::dvec3 in = corner(inside), out = corner(outside);
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 middle = 0.5 * (in + out);
      (solid(middle) < 0 ? in : out) = middle;
    }
    mesh.positions.push_back(in);
    return at->second;
  };
  // Six tetrahedra around the diagonal of each cell.
  std::array<int, 3> axes{0, 1, 2};
  do {
    const bool is_even = (axes[1] - axes[0] + 3) % 3 == 1;
    for (int z = 0; z < cells; ++z) {
      for (int y = 0; y < cells; ++y) {
        for (int x = 0; x < cells; ++x) {
          std::array<std::array<int, 3>, 4> place{{{x, y, z}}};
          for (int i = 0; i < 3; ++i) {
            place[i + 1] = place[i];
            ++place[i + 1][axes[i]];
          }
          // Corners inside first, by an even permutation.
          std::vector<int> order, out;
          for (int i = 0; i < 4; ++i) (solid(corner(place[i])) < 0 ? order : out).push_back(i);
          const std::size_t inside = order.size();
          if (inside == 0 || inside == 4) continue;
          order.insert(order.end(), out.begin(), out.end());
          int swaps = is_even ? 0 : 1;
          for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j) swaps += order[i] > order[j] ? 1 : 0;
          const auto at = [&](int i, int j) { return crossing(place[order[i]], place[order[j]]); };
          std::vector<std::int32_t> face;
          if (inside == 1) face = {at(0, 1), at(0, 2), at(0, 3)};
          if (inside == 2) face = {at(0, 2), at(0, 3), at(1, 3), at(1, 2)};
          if (inside == 3) face = {at(0, 3), at(1, 3), at(2, 3)};
          if (swaps % 2 == 1) std::ranges::reverse(face);
          for (std::size_t i = 1; i + 1 < face.size(); ++i)
            mesh.add_face(std::array{face[0], face[i], face[i + 1]});
        }
      }
    }
  } while (std::ranges::next_permutation(axes).found);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, deviation);
  for (glm::dvec3& p : mesh.positions) p += glm::dvec3(noise(random), noise(random), noise(random));
  return mesh;
}
Solid turned(const Solid& solid, double angle, const glm::dvec3& axis) {
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1), angle, axis));
  return [=](const glm::dvec3& p) { return solid(p * turn); };
}

AnalyticFaces scanned(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  const std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  const AnalyticMesh samples{.topology = topology,
                             .positions = mesh.positions,
                             .is_sharp = is_sharp,
                             .groups = {},
                             .diagonal = placement_of(mesh).diagonal,
                             .places = VertexPlaces::Samples};
  return make_analytic_faces(samples, find_analytic_parts(samples));
}

struct Scan {
  std::string name;
  Solid solid;
  Kinds kinds;
  std::vector<double> radii;
};
std::vector<Scan> scans() {
  return {{"block",
           [](const glm::dvec3& p) {
             return box(p, {0.8, 0.5, 0.3});
           },
           {6, 0, 0, 0, 0},
           {}},
          {"plate with a bore",
           [](const glm::dvec3& p) {
             return std::max(box(p, {0.8, 0.6, 0.2}), -cylinder(p - glm::dvec3(0.2, 0.1, 0), 0.25));
           },
           {6, 1, 0, 0, 0},
           {0.25}},
          {"angle with two bores",
           [](const glm::dvec3& p) {
             const double angle = std::max(box(p, {0.8, 0.5, 0.6}),
                                           -box(p - glm::dvec3(0.3, 0, 0.3), {0.8, 0.6, 0.6}));
             const glm::dvec3 q = p - glm::dvec3(0.2, 0.05, 0);
             return std::max(
                 {angle, -cylinder(q, 0.2), -cylinder(glm::dvec3(p.z - 0.15, p.y, p.x), 0.18)});
           },
           {8, 2, 0, 0, 0},
           {0.18, 0.2}},
          {"stepped shaft",
           [](const glm::dvec3& p) {
             const double foot = std::max(cylinder(p, 0.6), std::abs(p.z + 0.4) - 0.3),
                          neck = std::max(cylinder(p, 0.3), std::abs(p.z - 0.2) - 0.6);
             return std::min(foot, neck);
           },
           {3, 2, 0, 0, 0},
           {0.3, 0.6}},
          {"cut ball",
           [](const glm::dvec3& p) { return std::max(glm::length(p) - 0.8, p.z - 0.3); },
           {1, 0, 0, 1, 0},
           {0.8}},
          {"ring",
           [](const glm::dvec3& p) {
             return std::sqrt(std::pow(cylinder(p, 0.6), 2) + p.z * p.z) - 0.25;
           },
           {0, 0, 0, 0, 1},
           {0.25, 0.6}}};
}

void expect_scan(const Scan& scan, const PolygonMesh& mesh, double scale) {
  const AnalyticFaces made = scanned(mesh);
  EXPECT_EQ(made.faces_by_kind, scan.kinds) << made.first_reason;
  ASSERT_EQ(made.radii.size(), scan.radii.size());
  for (std::size_t i = 0; i < made.radii.size(); ++i)
    EXPECT_NEAR(made.radii[i], scale * scan.radii[i], 1e-3 * scale * scan.radii[i]);
  EXPECT_TRUE(check_brep(made.brep, placement_of(mesh).diagonal).is_valid());
}

TEST(AnalyticScans, BecomeTheFacesOfTheirPart) {
  for (const Scan& scan : scans()) {
    for (const double angle : {0.3, 1.1}) {
      for (const double deviation : {0.0, 3e-4}) {
        SCOPED_TRACE(scan.name + " at " + std::to_string(angle) + ", " + std::to_string(deviation));
        const Solid solid = turned(scan.solid, angle, glm::normalize(glm::dvec3(1, 2, 3)));
        expect_scan(scan, sampled(solid, 1.4, 50, deviation), 1);
      }
    }
  }
}

// However large they are, wherever they lie, in any order.
TEST(AnalyticScans, AreTheSameHoweverTheyAreWritten) {
  const Scan scan = scans()[1];
  const PolygonMesh mesh =
      sampled(turned(scan.solid, 0.7, glm::normalize(glm::dvec3(3, 1, 2))), 1.4, 60, 2e-4);
  std::vector<std::array<std::int32_t, 3>> faces;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    faces.push_back({face[1], face[2], face[0]});
  }
  std::ranges::shuffle(faces, std::mt19937(3));
  PolygonMesh other;
  for (const glm::dvec3& p : mesh.positions)
    other.positions.push_back(1000.0 * p + glm::dvec3(500, -700, 100));
  for (const auto& face : faces) other.add_face(face);
  expect_scan(scan, mesh, 1);
  expect_scan(scan, other, 1000);
}

// A vertex on an edge is no sample of either side more than of the other: what is said of it is how
// far the points were from the nearest face.
TEST(AnalyticScans, SayHowFarPointsWere) {
  const Scan scan = scans()[0];
  const double deviation = 2e-4;
  const PolygonMesh mesh =
      sampled(turned(scan.solid, 0.7, glm::normalize(glm::dvec3(3, 1, 2))), 1.4, 60, deviation);
  const AnalyticFaces made = scanned(mesh);
  EXPECT_GT(made.largest_distance, 2 * deviation);
  EXPECT_LT(made.largest_distance, 6 * deviation);
}

TEST(AnalyticScans, WhatHasNoNameStaysFreeform) {
  const Solid bumpy = [](const glm::dvec3& p) {
    return glm::length(p) - 0.8 -
           0.1 * std::sin(5 * p.x) * std::sin(4 * p.y + 1) * std::sin(6 * p.z + 2);
  };
  for (const double deviation : {0.0, 2e-4}) {
    const AnalyticFaces made = scanned(sampled(bumpy, 1.2, 50, deviation));
    EXPECT_EQ(made.freeform_parts, 1);
    EXPECT_FALSE(made.first_reason.empty());
  }
}

}  // namespace
}  // namespace planish::test
