#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>

#include "make_scenes/shapes.h"
#include "planish/edit/editor.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/refine/guess_surface.h"
#include "planish/refine/refine_mesh.h"
#include "planish/surface/evaluate.h"
#include "support/calls.h"
#include "support/cut_quads.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

// Vertices added between those of uneven triangles: where they lie, what stays, what rides along.

using test::cut_quads;
using test::delaunay_sphere;

RefinedMesh refined(const PolygonMesh& mesh) {
  std::optional<RefinedMesh> made = refine_mesh(mesh, *prepare_mesh(mesh, "mesh"));
  EXPECT_TRUE(made.has_value());
  return made ? *std::move(made) : RefinedMesh{};
}

// Triangles over [0, 8] x [0, 8] whose inner vertices are moved by lot, at a height.
template <class Height>
PolygonMesh uneven_sheet(const Height& height) {
  PolygonMesh mesh = cut_quads(test::flat_grid(8, 8));
  std::mt19937 lot(5);
  const auto share = [&] { return static_cast<double>(lot()) / 4294967296.0 - 0.5; };
  for (glm::dvec3& p : mesh.positions) {
    const double dx = 0.7 * share(), dy = 0.7 * share();
    if (p.x > 0 && p.x < 8) p.x += dx;
    if (p.y > 0 && p.y < 8) p.y += dy;
    p.z = height(p.x, p.y);
  }
  return mesh;
}

double flat(double, double) { return 0; }

struct Errors {
  double normals = 0, distance = 0;  // rms by area, degrees
};

// Of a mesh's facets from the unit sphere.
Errors errors_of_sphere(const PolygonMesh& mesh) {
  double area = 0, normals = 0, distance = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto v = mesh.face(f);
    const glm::dvec3 &a = mesh.positions[v[0]], &b = mesh.positions[v[1]],
                     &c = mesh.positions[v[2]];
    const glm::dvec3 cross = glm::cross(b - a, c - a), middle = (a + b + c) / 3.0;
    const double size = glm::length(cross);
    if (size == 0) continue;
    const double cosine = glm::dot(cross, middle) / size / glm::length(middle);
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
    area += size;
    normals += size * angle * angle;
    distance += size * std::pow(glm::length(middle) - 1, 2);
  }
  return {std::sqrt(normals / area), std::sqrt(distance / area)};
}

// Of the vertex in the middle of an uneven sheet, moved to (4, 4, 0).
VertexJet middle_jet(PolygonMesh mesh) {
  const MeshTopology topology(mesh);
  const std::int32_t middle = test::vertex_at(mesh, {4, 4, 0});
  mesh.positions[middle] = {4, 4, 0};
  const VertexJets jets =
      fit_vertex_jets(mesh.positions, topology, std::vector<char>(topology.edge_count(), 0));
  return jets.jets[jets.jet_of_corner[topology.corners_at(middle).front()]];
}

TEST(VertexJets, HaveTheCurvatureOfAParaboloid) {
  const VertexJet jet = middle_jet(uneven_sheet([](double x, double y) {
    return 0.0025 * (x - 4) * (x - 4) + 0.001 * (x - 4) * (y - 4) - 0.0015 * (y - 4) * (y - 4);
  }));
  EXPECT_NEAR(std::abs(jet.normal.z), 1, 1e-12);
  for (const glm::dvec2& at : {glm::dvec2(4.5, 4), glm::dvec2(3.8, 4.4), glm::dvec2(4.3, 3.5)}) {
    const glm::dvec2 d = at - glm::dvec2(4);
    const double z = 0.0025 * d.x * d.x + 0.001 * d.x * d.y - 0.0015 * d.y * d.y;
    EXPECT_NEAR(jet.on_jet({at, 0}).z, z, 1e-6);
  }
}

// However far it bends away: the ring's edges turn by 15 degrees and more.
TEST(VertexJets, AreExactOnABall) {
  constexpr double kRadius = 6;
  const auto height = [](const glm::dvec2& d) {
    return std::sqrt(kRadius * kRadius - glm::dot(d, d)) - kRadius;
  };
  const VertexJet jet = middle_jet(
      uneven_sheet([&](double x, double y) { return height(glm::dvec2(x - 4, y - 4)); }));
  EXPECT_NEAR(std::abs(jet.normal.z), 1, 1e-6);
  for (const glm::dvec2& at : {glm::dvec2(5.5, 4), glm::dvec2(3.2, 5), glm::dvec2(4.3, 2.7)})
    EXPECT_NEAR(jet.on_jet({at, 0}).z, height(at - glm::dvec2(4)), 1e-6);
}

// Thin ellipsoids and tubes, in few and uneven triangles, against their formulas.

PolygonMesh ellipsoid(const glm::dvec3& axes, std::uint32_t seed) {
  PolygonMesh mesh = delaunay_sphere(800, seed);
  for (glm::dvec3& p : mesh.positions) p *= axes;
  return mesh;
}

// Around z: 48 x 7 places, moved by lot along the tube and around it.
PolygonMesh uneven_ring(double tube_radius, std::uint32_t seed) {
  constexpr int kAlong = 48, kAround = 7;
  constexpr double kRound = 2 * std::numbers::pi;
  PolygonMesh mesh;
  std::mt19937 lot(seed);
  const auto moved = [&](int i, int count) {
    return kRound * (i + 0.5 * (static_cast<double>(lot()) / 4294967296.0 - 0.5)) / count;
  };
  for (int i = 0; i < kAlong; ++i) {
    for (int j = 0; j < kAround; ++j) {
      const double u = moved(i, kAlong), v = moved(j, kAround), r = 1 + tube_radius * std::cos(v);
      mesh.positions.emplace_back(r * std::cos(u), r * std::sin(u), tube_radius * std::sin(v));
      const auto at = [&](int di, int dj) {
        return (i + di) % kAlong * kAround + (j + dj) % kAround;
      };
      mesh.add_face(std::array{at(0, 0), at(1, 0), at(1, 1)});
      mesh.add_face(std::array{at(0, 0), at(1, 1), at(0, 1)});
    }
  }
  return mesh;
}

TEST(VertexJets, HaveTheNormalsOfEllipsoidsHoweverThin) {
  struct Row {
    glm::dvec3 axes;
    double degrees;  // rms over the vertices, at most
  };
  for (const auto& [axes, degrees] :
       {Row{{2, 1, 1}, 0.08}, Row{{3, 1, 1}, 0.15}, Row{{5, 1, 1}, 0.3}, Row{{8, 1, 1}, 0.5},
        Row{{1, 1, 0.5}, 0.1}, Row{{1, 1, 1 / 3.0}, 0.5}, Row{{1, 1, 0.2}, 2}}) {
    SCOPED_TRACE(testing::Message() << axes.x << " : " << axes.y << " : " << axes.z);
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
      const PolygonMesh mesh = ellipsoid(axes, seed);
      const MeshTopology topology(mesh);
      const VertexJets jets =
          fit_vertex_jets(mesh.positions, topology, std::vector<char>(topology.edge_count(), 0));
      double sum = 0;
      for (const VertexJet& jet : jets.jets)
        sum += std::pow(angle_between(jet.normal, jet.origin / axes / axes), 2);
      EXPECT_LT(std::sqrt(sum / static_cast<double>(jets.jets.size())) * 180 / std::numbers::pi,
                degrees);
    }
  }
}

struct Ridges {
  int steep = 0, marked = 0;  // edges by which faces turn by more than 60 degrees, and those marked
};

Ridges ridges_of(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  std::vector<char> is_sharp(topology.edge_count(), 0);
  mark_ridges(mesh.positions, topology, is_sharp);
  const auto normal = [&](std::int32_t corner) {
    const auto v = topology.face(topology.face_of(corner));
    const glm::dvec3& a = mesh.positions[v[0]];
    return glm::cross(mesh.positions[v[1]] - a, mesh.positions[v[2]] - a);
  };
  Ridges ridges;
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t corner = topology.corner_of(e);
    ridges.marked += is_sharp[e];
    ridges.steep += angle_between(normal(corner), normal(topology.twin(corner))) > 1.0472;
  }
  return ridges;
}

// A tube of seven sides turns by as much as the side of a spike does.
TEST(MarkRidges, PartsWhatJetsDoNotForetell) {
  Ridges tube, spiked;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const Ridges own = ridges_of(uneven_ring(0.1, seed));
    tube.steep += own.steep;
    tube.marked += own.marked;
    PolygonMesh ball = delaunay_sphere(400, seed);
    for (const std::size_t v : {7u, 100u, 200u, 300u}) ball.positions[v] *= seed % 2 ? 1.4 : 0.6;
    const Ridges other = ridges_of(ball);
    spiked.steep += other.steep;
    spiked.marked += other.marked;
  }
  EXPECT_GT(tube.steep, 100);
  EXPECT_LT(tube.marked, 0.05 * tube.steep);
  EXPECT_GT(spiked.steep, 100);
  EXPECT_EQ(spiked.marked, spiked.steep);
}

// Heights by lot are no surface: nothing is put between them that bends more than they do.
TEST(VertexJets, DoNotFollowNoise) {
  std::mt19937 lot(8);
  const PolygonMesh mesh = uneven_sheet(
      [&](double, double) { return 0.02 * (static_cast<double>(lot()) / 4294967296.0 - 0.5); });
  for (const glm::dvec3& p : refined(mesh).mesh.positions) EXPECT_LT(std::abs(p.z), 0.015);
}

TEST(RefineMesh, KeepsTheGivenVerticesFirstAndWhereTheyAre) {
  for (const PolygonMesh& mesh :
       {delaunay_sphere(300, 3), uneven_sheet(flat), test::tetrahedron(), test::bipyramid(50)}) {
    const RefinedMesh made = refined(mesh);
    ASSERT_GT(made.mesh.vertex_count(), mesh.vertex_count());
    EXPECT_TRUE(
        std::equal(mesh.positions.begin(), mesh.positions.end(), made.mesh.positions.begin()));
    EXPECT_EQ(std::ssize(made.added), made.mesh.vertex_count() - mesh.vertex_count());
    EXPECT_TRUE(check(made.mesh).empty());
    EXPECT_EQ(made.source_faces.size(), static_cast<std::size_t>(made.mesh.face_count()));
  }
}

TEST(RefineMesh, LiesNearTheShapeThatWasSampled) {
  for (const int count : {400, 1500}) {
    const PolygonMesh mesh = delaunay_sphere(count, 11);
    const Errors given = errors_of_sphere(mesh), made = errors_of_sphere(refined(mesh).mesh);
    EXPECT_LT(made.normals, 0.4 * given.normals) << count;
    EXPECT_LT(made.distance, 0.3 * given.distance) << count;
  }
}

// Triangles five times as long as wide, along a tube: they need no splits along it.
TEST(RefineMesh, KeepsTrianglesNarrowAlongABend) {
  PolygonMesh mesh = uneven_sheet([](double, double y) {
    const double angle = 0.3 * (y - 4);
    return std::cos(angle) / 0.3;
  });
  const RefinedMesh even = refined(mesh);
  for (glm::dvec3& p : mesh.positions) p.x *= 5;
  const RefinedMesh narrow = refined(mesh);
  EXPECT_LT(narrow.mesh.face_count(), 1.3 * even.mesh.face_count());
}

// Pentagons and hexagons whose vertices lie on a ball.
TEST(RefineMesh, MakesPolygonsOfABallRound) {
  PolygonMesh mesh = shapes::dual(shapes::icosphere(2));
  for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
  const RefinedMesh made = refined(mesh);
  ASSERT_GT(made.mesh.vertex_count(), mesh.vertex_count());
  EXPECT_TRUE(
      std::equal(mesh.positions.begin(), mesh.positions.end(), made.mesh.positions.begin()));
  EXPECT_TRUE(check(made.mesh).empty());
  for (const std::int32_t face : made.source_faces) EXPECT_LT(face, mesh.face_count());
  double farthest = 0;
  for (const glm::dvec3& p : made.mesh.positions)
    farthest = std::max(farthest, std::abs(1 - glm::length(p)));
  double flat = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    glm::dvec3 middle(0);
    for (const std::int32_t v : mesh.face(f)) middle += mesh.positions[v];
    flat = std::max(flat, 1 - glm::length(middle) / mesh.face_size(f));
  }
  EXPECT_LT(farthest, 0.1 * flat);
}

TEST(RefineMesh, LeavesPlanesFlatAndTheirOutlineStraight) {
  const PolygonMesh mesh = uneven_sheet(flat);
  const RefinedMesh made = refined(mesh);
  const MeshTopology topology(made.mesh);
  for (std::int32_t v = 0; v < made.mesh.vertex_count(); ++v) {
    const glm::dvec3& p = made.mesh.positions[v];
    EXPECT_NEAR(p.z, 0, 1e-12);
    const bool is_outside = std::min({p.x, p.y, 8 - p.x, 8 - p.y}) < 1e-9;
    EXPECT_EQ(is_outside, topology.is_boundary_vertex(v));
  }
}

// A roof: the ridge is tagged, its sides are flat, and stay so up to it.
TEST(RefineMesh, SplitsCreasesAndLooksAtEachSideAlone) {
  PolygonMesh mesh = uneven_sheet(flat);
  for (glm::dvec3& p : mesh.positions) {
    if (std::abs(p.x - 4) < 0.5) p.x = 4;
    p.z = -0.3 * std::abs(p.x - 4);
  }
  const MeshTopology topology(mesh);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto [a, b] = topology.edge_vertices(e);
    if (mesh.positions[a].x == 4 && mesh.positions[b].x == 4) mesh.creases.push_back({a, b});
  }
  ASSERT_EQ(mesh.creases.size(), 8u);
  const RefinedMesh made = refined(mesh);
  EXPECT_GT(made.mesh.creases.size(), 8u);
  double length = 0;
  for (const CreaseEdge& crease : made.mesh.creases) {
    const glm::dvec3 &a = made.mesh.positions[crease.v0], &b = made.mesh.positions[crease.v1];
    EXPECT_NEAR(a.x, 4, 1e-12);
    EXPECT_NEAR(b.x, 4, 1e-12);
    EXPECT_EQ(crease.sharpness, kInfiniteSharpness);
    length += glm::distance(a, b);
  }
  EXPECT_NEAR(length, 8, 1e-12);
  for (const glm::dvec3& p : made.mesh.positions) EXPECT_NEAR(p.z, -0.3 * std::abs(p.x - 4), 1e-9);
}

// Groups left and right of x = 4, texture coordinates with a seam there, a hole, colours and
// numbers: linear where they were, parted where they were.
TEST(RefineMesh, CarriesWhatRidesOnTheMesh) {
  PolygonMesh mesh = uneven_sheet(flat);
  for (glm::dvec3& p : mesh.positions)
    if (std::abs(p.x - 4) < 0.5) p.x = 4;
  mesh.groups = {{"left", "red"}, {"right", "blue"}};
  VertexAttribute attribute = attribute_of_size("sum", 1, mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3& p = mesh.positions[v];
    attribute.values[v] = static_cast<float>(p.x + 2 * p.y);
    mesh.colors.emplace_back(p.x / 8, p.y / 8, 0.5, 1);
  }
  mesh.attributes = {attribute};
  const auto is_right = [&](std::span<const std::int32_t> face) {
    return std::ranges::any_of(face, [&](std::int32_t v) { return mesh.positions[v].x > 4; });
  };
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const bool right = is_right(mesh.face(f));
    mesh.face_groups.push_back(right ? 1 : 0);
    if (f == 20) mesh.hole_faces.push_back(f);
    for (const std::int32_t v : mesh.face(f)) {
      const glm::dvec3& p = mesh.positions[v];
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.emplace_back(p.x + (right ? 100 : 0), p.y);
    }
  }
  // One coordinate a vertex and side.
  std::map<std::pair<double, double>, std::int32_t> numbers;
  for (std::int32_t& uv : mesh.face_uvs)
    uv = numbers.emplace(std::pair(mesh.uvs[uv].x, mesh.uvs[uv].y), uv).first->second;
  const RefinedMesh made = refined(mesh);
  const PolygonMesh& to = made.mesh;
  ASSERT_EQ(to.face_uvs.size(), to.face_vertices.size());
  double hole_area = 0, right_area = 0;
  for (std::int32_t f = 0; f < to.face_count(); ++f) {
    double low = 8, high = 0;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3& p = to.positions[to.face(f)[i]];
      low = std::min(low, p.x);
      high = std::max(high, p.x);
      const glm::dvec2& uv = to.uvs[to.face_uvs[3 * f + i]];
      EXPECT_NEAR(uv.x, p.x + (to.face_groups[f] == 1 ? 100 : 0), 1e-9);
      EXPECT_NEAR(uv.y, p.y, 1e-9);
    }
    EXPECT_EQ(to.face_groups[f], high > 4 + 1e-9 ? 1 : 0);
    EXPECT_TRUE(low > 4 - 1e-9 || high < 4 + 1e-9);
    const glm::dvec3& a = to.positions[to.face(f)[0]];
    const double area =
        glm::length(glm::cross(to.positions[to.face(f)[1]] - a, to.positions[to.face(f)[2]] - a)) /
        2;
    if (to.face_groups[f] == 1) right_area += area;
    if (std::ranges::count(to.hole_faces, f) > 0) hole_area += area;
  }
  EXPECT_NEAR(right_area, 32, 1e-9);
  const glm::dvec3& corner = mesh.positions[mesh.face(20)[0]];
  EXPECT_NEAR(hole_area,
              glm::length(glm::cross(mesh.positions[mesh.face(20)[1]] - corner,
                                     mesh.positions[mesh.face(20)[2]] - corner)) /
                  2,
              1e-9);
  for (std::size_t v = 0; v < to.positions.size(); ++v) {
    const glm::dvec3& p = to.positions[v];
    EXPECT_NEAR(to.attributes[0].values[v], p.x + 2 * p.y, 1e-4);
    EXPECT_NEAR(to.colors[v].r, p.x / 8, 1e-5);
    EXPECT_EQ(to.colors[v].a, 1);
  }
}

TEST(RefineMesh, GivesTheSameBitsForEveryNumberOfThreadsAndScale) {
  const PolygonMesh mesh = delaunay_sphere(500, 4);
  const RefinedMesh one = tbb::task_arena(1).execute([&] { return refined(mesh); });
  const RefinedMesh many = tbb::task_arena(4).execute([&] { return refined(mesh); });
  EXPECT_EQ(one.mesh.positions, many.mesh.positions);
  EXPECT_EQ(one.mesh.face_vertices, many.mesh.face_vertices);
  PolygonMesh large = mesh;
  for (glm::dvec3& p : large.positions) p *= 1024;
  const RefinedMesh scaled = refined(large);
  EXPECT_EQ(scaled.mesh.face_vertices, one.mesh.face_vertices);
  for (std::size_t v = 0; v < one.mesh.positions.size(); ++v)
    EXPECT_EQ(scaled.mesh.positions[v], 1024.0 * one.mesh.positions[v]);
}

// Length of the edges whose faces turn by more than 90 degrees.
double folded_length(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  const auto normal = [&](std::int32_t face) {
    const auto v = topology.face(face);
    const glm::dvec3& a = mesh.positions[v[0]];
    return glm::cross(mesh.positions[v[1]] - a, mesh.positions[v[2]] - a);
  };
  double length = 0;
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const std::int32_t corner = topology.corner_of(e);
    if (glm::dot(normal(topology.face_of(corner)),
                 normal(topology.face_of(topology.twin(corner)))) > 0)
      continue;
    const auto [a, b] = topology.edge_vertices(e);
    length += glm::distance(mesh.positions[a], mesh.positions[b]);
  }
  return length;
}

TEST(RefineMesh, TurnsNoTriangleOver) {
  EXPECT_EQ(folded_length(refined(delaunay_sphere(1000, 9)).mesh), 0);
  // Balls with a spike and a pit, through whose sides no smooth surface passes.
  double given = 0, made = 0;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    for (const std::size_t place : {0u, 3u}) {
      PolygonMesh spiked = delaunay_sphere(400, seed);
      spiked.positions[7 + 31 * place] *= 1.8;
      spiked.positions[90 + 37 * place] *= 0.4;
      given += folded_length(spiked);
      made += folded_length(refined(spiked).mesh);
    }
  }
  ASSERT_GT(given, 10);
  EXPECT_LT(made, 1.15 * given);
}

TEST(RefineMesh, LeavesMeshesThatAreNoTriangles) {
  const PolygonMesh mesh = test::cube();
  EXPECT_FALSE(refine_mesh(mesh, *prepare_mesh(mesh, "mesh")).has_value());
}

TEST(RefineMesh, LeavesUnusedVerticesWhereTheyAre) {
  PolygonMesh mesh = delaunay_sphere(100, 2);
  const RefinedMesh plain = refined(mesh);
  mesh.positions.insert(mesh.positions.begin() + 10, glm::dvec3(5, 5, 5));
  for (std::int32_t& v : mesh.face_vertices)
    if (v >= 10) ++v;
  const RefinedMesh made = refined(mesh);
  EXPECT_EQ(made.mesh.positions[10], glm::dvec3(5, 5, 5));
  PolygonMesh without = made.mesh;
  without.positions.erase(without.positions.begin() + 10);
  EXPECT_EQ(without.positions, plain.mesh.positions);
}

TEST(RmsTurn, IsThatOfTheEdgesThatAreNoCreases) {
  PolygonMesh mesh = test::prism(4);
  PolygonMesh box = cut_quads(mesh);
  const MeshTopology topology(box);
  const double all = rms_turn(box, *prepare_mesh(box, "box"));
  EXPECT_GT(all, 60);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto [a, b] = topology.edge_vertices(e);
    box.creases.push_back({a, b});
  }
  EXPECT_EQ(rms_turn(box, *prepare_mesh(box, "box")), 0);
}

// The surface through given and added vertices: nearer to the shape, through every given vertex.

FittedMesh fitted(const PolygonMesh& mesh, RefineChoice refine, MeshFitOptions options = {}) {
  options.refine = refine;
  return fit_mesh(mesh, "mesh", *make_cpu_backend(), options);
}

SurfaceMesh surface_of(const FittedMesh& fit, int level) {
  return evaluate(fit.mesh, fit.fit, *make_cpu_backend(), fit.evaluate_options(level));
}

// Of the unit sphere, rms over the vertices of a level, in degrees.
double normals_off(const FittedMesh& fit, int level) {
  const SurfaceMesh surface = surface_of(fit, level);
  double sum = 0;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const double cosine =
        glm::dot(glm::normalize(surface.positions[i]), glm::dvec3(surface.normals[i]));
    sum += std::pow(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi, 2);
  }
  return std::sqrt(sum / static_cast<double>(surface.positions.size()));
}

TEST(FitRefined, IsNearerToTheShapeAndPassesEveryGivenVertex) {
  const PolygonMesh mesh = test::delaunay_sphere(600, 1);
  const FittedMesh plain = fitted(mesh, RefineChoice::Off), made = fitted(mesh, RefineChoice::Auto);
  EXPECT_TRUE(plain.added_vertices.empty());
  ASSERT_FALSE(made.added_vertices.empty());
  EXPECT_LT(normals_off(made, 1), 0.25 * normals_off(plain, 2));
  const SurfaceMesh surface = surface_of(made, 1);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    EXPECT_LT(glm::distance(surface.positions[v], mesh.positions[v]), 1e-12);
  EXPECT_THAT(made.choice->faces_reason, testing::HasSubstr("--refine off"));
  EXPECT_LT(made.choice->best().bending,
            0.5 * made.choice->of(CandidateFaces::Given, InterpolationMethod::Fair)->bending);
  EXPECT_EQ(made.source_vertices[5], 5);
  EXPECT_EQ(made.source_vertices.back(), -1);
}

TEST(FitRefined, AddsNothingToQuadsAndTheirHalves) {
  for (const PolygonMesh& mesh :
       {test::torus(24, 12, 1, 0.4), test::cut_quads(test::torus(32, 16, 1, 0.4)),
        test::cut_quads(test::flat_grid(9, 9)), test::cube()})
    EXPECT_TRUE(fitted(mesh, RefineChoice::Auto).added_vertices.empty());
}

TEST(FitRefined, AddsWhereThatIsAskedFor) {
  MeshFitOptions options;
  options.method = InterpolationMethod::Fair;
  const FittedMesh made = fitted(test::icosphere(2), RefineChoice::On, options);
  EXPECT_FALSE(made.added_vertices.empty());
  EXPECT_EQ(made.options.method, InterpolationMethod::Fair);
  // Auto leaves a method that was named as it is.
  EXPECT_TRUE(
      fitted(test::delaunay_sphere(200, 2), RefineChoice::Auto, options).added_vertices.empty());
}

TEST(FitRefined, HasACageThatCanBeVerified) {
  const PolygonMesh mesh = test::delaunay_sphere(200, 5);
  MeshFitOptions options;
  options.method = InterpolationMethod::Fair;
  const FittedMesh made = fitted(mesh, RefineChoice::On, options);
  const PolygonMesh cage = control_cage(made.mesh, made.fit, made.options.sharp);
  VerifyOptions verify;
  verify.fit.method = InterpolationMethod::Fair;
  verify.fit.quads = QuadChoice::Off;
  verify.fit.refine = RefineChoice::On;
  const Verification right = verify_cage(cage, mesh, verify);
  EXPECT_TRUE(right.confirmed);
  EXPECT_LT(right.error.max, 1e-12);
  verify.fit.refine = RefineChoice::Off;
  (void)test::message_of(ErrorCode::UnusableMesh, [&] { (void)verify_cage(cage, mesh, verify); });
}

// Some of few points look as if they were halves of quads.
TEST(FitRefined, IsTakenBeforeQuadsThatBendMore) {
  int both = 0, worse = 0;
  for (int seed = 1; seed <= 40; ++seed) {
    const PolygonMesh mesh = test::delaunay_sphere(20 + 2 * seed, static_cast<unsigned>(seed));
    MeshFitOptions round;
    round.chooses_creases = false;
    const FittedMesh made = fitted(mesh, RefineChoice::Auto, round);
    if (!made.choice->of(CandidateFaces::Quads, InterpolationMethod::Fair)) continue;
    SCOPED_TRACE(seed);
    ++both;
    if (made.added_vertices.empty()) continue;
    const FittedMesh plain = fitted(mesh, RefineChoice::Off, round);
    EXPECT_EQ(made.paired_count, 0);
    EXPECT_EQ(made.choice->best().faces, CandidateFaces::Refined);
    worse += normals_off(made, 1) >= normals_off(plain, 2);
  }
  EXPECT_GT(both, 0);
  EXPECT_LE(worse, 1) << "what bends least is not always nearest through so few points";
}

TEST(FitRefined, IsWrittenALevelLess) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  EXPECT_EQ(made.density.level(), 1);
  EXPECT_EQ(fitted(test::delaunay_sphere(200, 5), RefineChoice::Off).density.level(), 2);
}

TEST(FitRefined, IsNotLeftBehindWithinABound) {
  MeshFitOptions options;
  options.fit.within = 1e-3;
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto, options);
  EXPECT_TRUE(made.added_vertices.empty());
}

TEST(FitRefined, HasWarningsOfTheSurfaceThatIsTakenAlone) {
  const PolygonMesh mesh = test::delaunay_sphere(200, 5);
  std::vector<Warning> told;
  MeshFitOptions options;
  options.fit.callbacks.warning = [&](const Warning& warning) { told.push_back(warning); };
  const FittedMesh made = fitted(mesh, RefineChoice::Auto, options);
  ASSERT_EQ(told.size(), made.warnings.size());
  for (std::size_t i = 0; i < told.size(); ++i)
    EXPECT_EQ(told[i].message, made.warnings[i].message);
}

// Each added vertex by the weights of the given ones that move, and by nothing else.
TEST(FitRefined, IsEditedByItsGivenVertices) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  ASSERT_FALSE(made.added_vertices.empty());
  const auto given =
      static_cast<std::int32_t>(made.mesh.positions.size() - made.added_vertices.size());
  Editor editor(made);
  const std::vector<glm::dvec3> before(editor.points().begin(), editor.points().end());
  const std::array<std::int32_t, 2> vertices{7, 11};
  const glm::dvec3 way(0.02, -0.01, 0.03);
  editor.move(vertices, std::array{before[7] + way, before[11] - way});
  const auto way_of = [&](std::int32_t v) { return v == 7 ? way : v == 11 ? -way : glm::dvec3(0); };
  int followed = 0;
  for (std::int32_t v = 0; v < std::ssize(before); ++v) {
    glm::dvec3 expected(0);
    if (v < given) {
      expected = way_of(v);
    } else {
      const AddedVertex& added = made.added_vertices[v - given];
      for (int k = 0; k < 3; ++k) expected += added.weights[k] * way_of(added.vertices[k]);
      followed += expected != glm::dvec3(0);
    }
    EXPECT_LT(glm::distance(editor.points()[v] - before[v], expected), 1e-15);
  }
  EXPECT_GT(followed, 4);
  EXPECT_LT(editor.measured_error(), 1e-12);
  editor.undo();
  EXPECT_TRUE(std::ranges::equal(editor.points(), before));
  // They go on to follow where all is made anew.
  editor.refit();
  editor.move(std::array{7}, std::array{before[7] + way});
  EXPECT_GT(glm::distance(editor.points()[7], before[7]), 0.03);
  EXPECT_TRUE(std::any_of(before.begin() + given, before.end(), [&](const glm::dvec3& p) {
    return editor.points()[&p - before.data()] != p;
  }));
}

TEST(FitRefined, LetsNobodyMoveOrSelectAnAddedVertex) {
  const FittedMesh made = fitted(test::delaunay_sphere(200, 5), RefineChoice::Auto);
  const auto given =
      static_cast<std::int32_t>(made.mesh.positions.size() - made.added_vertices.size());
  Editor editor(made);
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                               [&] { editor.move(std::array{given}, std::array{glm::dvec3(0)}); }),
              testing::HasSubstr("the mesh has 0 to 199"));
  const Selection selection = editor.select(std::array{7}, 0.5);
  EXPECT_GT(selection.vertices.size(), 3u);
  EXPECT_TRUE(std::ranges::all_of(selection.vertices, [&](std::int32_t v) { return v < given; }));
  EXPECT_EQ(selection.weights.size(), selection.vertices.size());
  editor.transform(selection, glm::dmat4(1.01));
  EXPECT_LT(editor.measured_error(), 1e-12);
}

}  // namespace
}  // namespace planish
