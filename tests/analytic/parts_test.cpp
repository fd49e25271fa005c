// Faces on planes, cylinders, cones, spheres and tori of parts whose surfaces are known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "analytic/analytic_case.h"
#include "analytic/profile.h"
#include "planish/analytic/noisy_regions.h"
#include "planish/brep/analytic_faces.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using Kinds = std::array<std::int64_t, kAnalyticKinds>;  // planes, cylinders, cones, spheres, tori

constexpr double kPi = std::numbers::pi;

PolygonMesh shaft() {
  return Profile({0, 0})
      .line({2, 0})
      .line({2, 3})
      .line({1.4, 3.6})
      .line({1, 3.6})
      .line({1, 5})
      .line({0, 5})
      .turned(40);
}
PolygonMesh filleted_shaft() {
  return Profile({0, 0})
      .line({2, 0})
      .line({2, 1})
      .line({1.5, 1})
      .arc({1.5, 1.5}, 0.5, -kPi / 2, -kPi, 8)
      .line({1, 3})
      .arc({0.7, 3}, 0.3, 0, kPi / 2, 6)
      .line({0, 3.3})
      .turned(36);
}
PolygonMesh capsule() {
  return Profile({0, -1})
      .arc({0, 0}, 1, -kPi / 2, 0, 8)
      .line({1, 2})
      .arc({0, 2}, 1, 0, kPi / 2, 8)
      .turned(32);
}
PolygonMesh ring() { return Profile({2.5, 0}).arc({2, 0}, 0.5, 0, 2 * kPi, 16).turned(32); }
// A plate with a round bore through it.
PolygonMesh plate() {
  constexpr int kSteps = 32;
  PolygonMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (int i = 0; i < kSteps; ++i) {
      const double angle = 2 * kPi * i / kSteps, c = std::cos(angle), s = std::sin(angle);
      mesh.positions.emplace_back(c, s, z);
      const double reach = 3 / std::max(std::abs(c), std::abs(s));
      mesh.positions.emplace_back(reach * c, reach * s, z);
    }
  }
  for (int i = 0; i < kSteps; ++i) {
    const int j = (i + 1) % kSteps, up = 2 * kSteps;
    mesh.add_face({{2 * i, 2 * j, 2 * j + 1, 2 * i + 1}});                      // below
    mesh.add_face({{up + 2 * i, up + 2 * i + 1, up + 2 * j + 1, up + 2 * j}});  // above
    mesh.add_face({{2 * i, up + 2 * i, up + 2 * j, 2 * j}});                    // bore
    mesh.add_face({{2 * i + 1, 2 * j + 1, up + 2 * j + 1, up + 2 * i + 1}});    // outside
  }
  return mesh;
}

// Of a ring of two polygons that meet twice a vertex: the welded mesh without doubles.
PolygonMesh welded(const PolygonMesh& mesh) {
  PolygonMesh result;
  std::vector<std::int32_t> number;
  for (const glm::dvec3& p : mesh.positions) {
    const auto found = std::ranges::find_if(
        result.positions, [&](const glm::dvec3& q) { return glm::length(p - q) < 1e-9; });
    number.push_back(static_cast<std::int32_t>(found - result.positions.begin()));
    if (found == result.positions.end()) result.positions.push_back(p);
  }
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<std::int32_t> face;
    for (const std::int32_t v : mesh.face(f)) face.push_back(number[v]);
    result.add_face(face);
  }
  return result;
}

struct Part {
  std::string name;
  PolygonMesh mesh;
  Kinds kinds;
  std::vector<double> radii;  // distinct
};
std::vector<Part> parts() {
  return {{"shaft", shaft(), {3, 2, 1, 0, 0}, {1, 2}},
          {"filleted shaft", filleted_shaft(), {3, 2, 0, 0, 2}, {0.3, 0.5, 0.7, 1, 1.5, 2}},
          {"capsule", capsule(), {0, 1, 0, 2, 0}, {1}},
          {"ring", welded(ring()), {0, 0, 0, 0, 1}, {0.5, 2}},
          {"plate", plate(), {6, 1, 0, 0, 0}, {1}}};
}

void expect_part(const Part& part, const PolygonMesh& mesh, double scale) {
  const AnalyticFaces made = analytic_faces_of(mesh);
  EXPECT_EQ(made.freeform_parts, 0) << made.first_reason;
  EXPECT_EQ(made.faces_by_kind, part.kinds);
  ASSERT_EQ(made.radii.size(), part.radii.size());
  for (std::size_t i = 0; i < made.radii.size(); ++i)
    EXPECT_NEAR(made.radii[i] / scale, part.radii[i], 1e-6);
  const BrepCheck check = check_brep(made.brep, placement_of(mesh).diagonal);
  EXPECT_TRUE(check.is_valid()) << check.broken_loops << ' ' << check.unmatched_edges << ' '
                                << check.largest_gap;
  EXPECT_LT(made.largest_distance, 1e-6 * placement_of(mesh).diagonal);
}

TEST(AnalyticParts, HaveTheFacesThatTheyWereMadeOf) {
  for (const Part& part : parts()) {
    SCOPED_TRACE(part.name);
    expect_part(part, part.mesh, 1);
  }
}

// However they are turned, scaled, moved, cut to triangles, and their faces ordered.
TEST(AnalyticParts, AreTheSameHoweverTheMeshIsWritten) {
  for (const Part& part : parts()) {
    SCOPED_TRACE(part.name);
    expect_part(part, posed(part.mesh), kPoseScale);
    std::vector<std::vector<std::int32_t>> triangles;
    for (std::int32_t f = 0; f < part.mesh.face_count(); ++f) {
      const auto face = part.mesh.face(f);
      for (std::size_t i = 1; i + 1 < face.size(); ++i)
        triangles.push_back({face[0], face[i], face[i + 1]});
    }
    std::ranges::shuffle(triangles, std::mt19937(7));
    PolygonMesh cut;
    cut.positions = part.mesh.positions;
    for (const auto& triangle : triangles) cut.add_face(triangle);
    expect_part(part, cut, 1);
    // float32, as STL has them.
    for (glm::dvec3& p : cut.positions) p = glm::dvec3(glm::vec3(p));
    expect_part(part, cut, 1);
  }
}

// Normal, of each coordinate.
PolygonMesh noisy(PolygonMesh mesh, double deviation) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, deviation);
  for (glm::dvec3& p : mesh.positions) p += glm::dvec3(noise(random), noise(random), noise(random));
  return mesh;
}
void expect_noisy_part(const Part& part, const PolygonMesh& mesh, std::optional<double> tolerance) {
  const AnalyticFaces made = analytic_faces_of(mesh, {}, {}, tolerance);
  EXPECT_EQ(made.faces_by_kind, part.kinds) << made.first_reason;
  ASSERT_EQ(made.radii.size(), part.radii.size());
  for (std::size_t i = 0; i < made.radii.size(); ++i)
    EXPECT_NEAR(made.radii[i], part.radii[i], 1e-3 * part.radii[i]);
  EXPECT_TRUE(check_brep(made.brep, placement_of(mesh).diagonal).is_valid());
}

// As a scan has it: a tenth of the tolerance.
TEST(AnalyticParts, NoisyOnesAreTakenWithinATolerance) {
  for (const Part& part : parts()) {
    SCOPED_TRACE(part.name);
    const PolygonMesh mesh = noisy(part.mesh, 1e-5 * placement_of(part.mesh).diagonal);
    EXPECT_NE(analytic_faces_of(mesh, {}, {}, 1e-6).faces_by_kind, part.kinds);
    expect_noisy_part(part, mesh, 1e-4);
  }
}

// In meshes fine enough to tell noise from shape it is measured.
TEST(AnalyticParts, NoisyOnesAreTakenByTheirNoise) {
  const PolygonMesh filleted = Profile({0, 0})
                                   .line({2, 0})
                                   .line({2, 1})
                                   .line({1.5, 1})
                                   .arc({1.5, 1.5}, 0.5, -kPi / 2, -kPi, 24)
                                   .line({1, 3})
                                   .arc({0.7, 3}, 0.3, 0, kPi / 2, 18)
                                   .line({0, 3.3})
                                   .turned(108);
  const std::vector<Part> all = parts();
  for (const Part& part :
       {all[0], Part{"fine filleted shaft", filleted, all[1].kinds, all[1].radii}, all[2],
        all[4]}) {
    SCOPED_TRACE(part.name);
    for (const double deviation : {3e-6, 1e-5, 3e-5})
      expect_noisy_part(part, noisy(part.mesh, deviation * placement_of(part.mesh).diagonal), {});
  }
}

TEST(AnalyticParts, NoiseIsThatOfTheVertices) {
  const PolygonMesh fine = Profile({0, -1})
                               .arc({0, 0}, 1, -kPi / 2, 0, 40)
                               .line({1, 2})
                               .arc({0, 2}, 1, 0, kPi / 2, 40)
                               .turned(160);
  for (const double deviation : {1e-5, 1e-4, 1e-3}) {
    const PolygonMesh mesh = noisy(fine, deviation);
    const MeshTopology topology(mesh);
    std::vector<std::int32_t> faces(static_cast<std::size_t>(mesh.face_count()));
    std::iota(faces.begin(), faces.end(), 0);
    const std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
    EXPECT_NEAR(noise_of(mesh.positions, topology, is_sharp, faces), deviation, 0.25 * deviation);
  }
}

// A prism between two polygons, above each edge of which lies one edge and its ends: below it may
// have further vertices.
PolygonMesh prism(const std::vector<glm::dvec2>& above, int times_below, double height) {
  PolygonMesh mesh;
  const auto count = static_cast<std::int32_t>(above.size()), below = times_below * count;
  for (const glm::dvec2& p : above) mesh.positions.emplace_back(p, height);
  for (std::int32_t i = 0; i < below; ++i) {
    const double part = static_cast<double>(i % times_below) / times_below;
    const glm::dvec2 from = above[i / times_below], to = above[(i / times_below + 1) % count];
    mesh.positions.emplace_back((1 - part) * from + part * to, 0);
  }
  std::vector<std::int32_t> top, bottom;
  for (std::int32_t i = 0; i < count; ++i) {
    top.push_back(i);
    std::vector<std::int32_t> side;
    for (std::int32_t k = 0; k <= times_below; ++k)
      side.push_back(count + (times_below * i + k) % below);
    side.push_back((i + 1) % count);
    side.push_back(i);
    mesh.add_face(side);
  }
  for (std::int32_t i = below; i-- > 0;) bottom.push_back(count + i);
  mesh.add_face(top);
  mesh.add_face(bottom);
  return mesh;
}

// Programs that know triangles only cut facets, not the cylinder: along the cut vertices lie inside
// it, on some facets or on all.
TEST(AnalyticParts, FacetsThatWereCutAreOfTheirCylinder) {
  constexpr int kSides = 32;
  constexpr double kRadius = 2, kFlat = 1.5;
  std::vector<glm::dvec2> whole, cut;
  for (int i = 0; i < kSides; ++i)
    whole.emplace_back(kRadius * std::cos(2 * kPi * i / kSides),
                       kRadius * std::sin(2 * kPi * i / kSides));
  for (int i = 0; i < kSides; ++i) {
    const glm::dvec2 p = whole[i], q = whole[(i + 1) % kSides];
    if (p.x <= kFlat) cut.push_back(p);
    if ((p.x - kFlat) * (q.x - kFlat) < 0) cut.push_back(p + (kFlat - p.x) / (q.x - p.x) * (q - p));
  }
  const double sag = kRadius * (1 - std::cos(kPi / kSides));
  struct Case {
    PolygonMesh mesh;
    std::int64_t planes;
    double least_sag;  // of the vertex that lies deepest
  };
  for (const auto& [mesh, planes, least_sag] :
       {Case{prism(whole, 2, 5), 2, 0.999 * sag}, Case{prism(cut, 1, 5), 3, 0.05 * sag},
        Case{prism(cut, 3, 5), 3, 0.8 * sag}}) {
    SCOPED_TRACE(planes);
    const AnalyticFaces made = analytic_faces_of(mesh);
    EXPECT_EQ(made.freeform_parts, 0) << made.first_reason;
    EXPECT_EQ(made.faces_by_kind, (Kinds{planes, 1, 0, 0, 0}));
    ASSERT_EQ(made.radii.size(), 1u);
    EXPECT_NEAR(made.radii[0], kRadius, 1e-9);
    EXPECT_GT(made.largest_distance, least_sag);
    EXPECT_LT(made.largest_distance, 1.001 * sag);
    const double below = 0.9 * least_sag / placement_of(mesh).diagonal;
    EXPECT_EQ(analytic_faces_of(mesh, {}, {}, below).faces_by_kind[1], 0);
    EXPECT_TRUE(check_brep(made.brep, placement_of(mesh).diagonal).is_valid());
  }
}

// Two facets that go on as the planes beside them are a fillet, not if they meet these in edges.
TEST(AnalyticParts, TwoFacetsBetweenPlanesAreAFillet) {
  for (const bool touches : {true, false}) {
    SCOPED_TRACE(touches);
    std::vector<glm::dvec2> outline{{0, -3}, {touches ? 4 : 4.5, -3}};
    for (const double angle : {0.0, 22.5, 45.0})
      outline.emplace_back(3 + std::cos(angle * kDegree), 1 + std::sin(angle * kDegree));
    outline.emplace_back(2, 2 + std::sqrt(2.0));
    outline.emplace_back(0, 2 + std::sqrt(2.0));
    const AnalyticFaces made = analytic_faces_of(prism(outline, 1, 3));
    EXPECT_EQ(made.faces_by_kind[1], touches ? 1 : 0);
    if (!touches) continue;
    EXPECT_EQ(made.freeform_parts, 0) << made.first_reason;
    EXPECT_EQ(made.faces_by_kind, (Kinds{7, 1, 0, 0, 0}));
    EXPECT_NEAR(made.radii.at(0), 1, 1e-9);
  }
}

TEST(AnalyticParts, WhatHasNoNameStaysFreeform) {
  PolygonMesh bumpy = capsule();
  for (glm::dvec3& p : bumpy.positions) p *= 1 + 0.05 * std::sin(3 * p.x) * std::cos(2 * p.y + p.z);
  const AnalyticFaces made = analytic_faces_of(bumpy);
  EXPECT_EQ(made.parts, 1);
  EXPECT_EQ(made.freeform_parts, 1);
  EXPECT_TRUE(made.brep.faces.empty());
  EXPECT_FALSE(made.first_reason.empty());
  EXPECT_EQ(analytic_faces_of(noisy(bumpy, 1e-4)).freeform_parts, 1);
}

// Each row of a body that is turned lies on a cone, which is none of its profile's.
TEST(AnalyticParts, RowsOfAFreeformBodyAreNoCones) {
  for (const int steps : {40, 90}) {
    SCOPED_TRACE(steps);
    Profile vase({0, 0});
    vase.line({1, 0});
    for (int i = 1; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      vase.line({1 + 0.4 * std::sin(5 * t) + 0.1 * std::sin(13 * t), 3 * t});
    }
    vase.line({0, 3});
    const PolygonMesh mesh = vase.turned(48);
    Kinds found{};
    for (const AnalyticRegion& region : AnalyticCase(mesh).found().regions.regions)
      ++found[static_cast<std::size_t>(region.surface.kind)];
    EXPECT_EQ(found, (Kinds{2, 0, 0, 0, 0}));
  }
}

TEST(AnalyticParts, AreTakenOneByOne) {
  PolygonMesh bumpy = capsule();
  for (glm::dvec3& p : bumpy.positions) p *= 1 + 0.05 * std::sin(3 * p.x) * std::cos(2 * p.y + p.z);
  const AnalyticFaces made = analytic_faces_of(beside(shaft(), bumpy, 9));
  EXPECT_EQ(made.parts, 2);
  EXPECT_EQ(made.freeform_parts, 1);
  EXPECT_EQ(made.faces_by_kind, (Kinds{3, 2, 1, 0, 0}));
}

// The two sides of a border of groups are two faces of one surface.
TEST(AnalyticParts, GroupsEndFaces) {
  const PolygonMesh mesh = shaft();
  std::vector<std::int32_t> groups(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    glm::dvec3 middle(0.0);
    for (const std::int32_t v : mesh.face(f)) middle += mesh.positions[v];
    groups[f] = middle.y > 0 ? 1 : 0;
  }
  const AnalyticFaces made = analytic_faces_of(mesh, groups);
  EXPECT_EQ(made.freeform_parts, 0) << made.first_reason;
  EXPECT_EQ(made.faces_by_kind, (Kinds{6, 4, 2, 0, 0}));
  EXPECT_TRUE(check_brep(made.brep, placement_of(mesh).diagonal).is_valid());
}

TEST(AnalyticParts, AreTheSameForEveryCallAndStopWhenAsked) {
  const PolygonMesh mesh = filleted_shaft();
  const AnalyticFaces one = analytic_faces_of(mesh), two = analytic_faces_of(mesh);
  EXPECT_EQ(one.brep.vertices, two.brep.vertices);
  const Callbacks stop{.cancelled = [] { return true; }};
  EXPECT_ANY_THROW((void)analytic_faces_of(mesh, {}, stop));
}

}  // namespace
}  // namespace planish::test
