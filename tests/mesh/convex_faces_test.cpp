#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "make_scenes/shapes.h"
#include "mesh/test_meshes.h"
#include "planish/mend/faults.h"
#include "planish/mend/repair.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "support/outlines.h"

namespace planish {
namespace {

using glm::dvec3;

PolygonMesh single(std::vector<dvec3> points) {
  PolygonMesh mesh;
  for (std::int32_t v = 0; v < std::int32_t(points.size()); ++v) mesh.face_vertices.push_back(v);
  mesh.face_offsets.push_back(std::int32_t(points.size()));
  mesh.positions = std::move(points);
  return mesh;
}

PolygonMesh letter_l() {
  return single({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}});
}

// The largest inward turn of a corner against its face's Newell normal, in radians.
double largest_inward_turn(const PolygonMesh& mesh) {
  double largest = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto v = mesh.face(f);
    const dvec3 normal = glm::normalize(area_vector(mesh.positions, v));
    for (std::size_t i = 0; i < v.size(); ++i) {
      const dvec3 own = mesh.positions[v[i]];
      const auto flat = [&](std::size_t k) {
        const dvec3 edge = mesh.positions[v[k % v.size()]] - own;
        return edge - glm::dot(edge, normal) * normal;
      };
      const dvec3 next = flat(i + 1), previous = flat(i + v.size() - 1);
      const double sine = glm::dot(glm::cross(next, previous), normal);
      const double cosine = glm::dot(next, previous);
      if (sine < 0) largest = std::max(largest, std::numbers::pi - std::atan2(-sine, cosine));
    }
  }
  return largest;
}

dvec3 total_area(const PolygonMesh& mesh) {
  dvec3 sum(0.0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    sum += area_vector(mesh.positions, mesh.face(f));
  return sum;
}

TEST(ConvexFaces, CutsTheLetterLOnce) {
  const PolygonMesh mesh = letter_l();
  EXPECT_EQ(concave_faces(mesh), std::vector<std::int32_t>{0});
  const ConvexMesh convex = with_convex_faces(mesh);
  EXPECT_EQ(convex.mesh.face_count(), 2);
  EXPECT_EQ(convex.source_faces, (std::vector<std::int32_t>{0, 0}));
  EXPECT_EQ(convex.cut_faces, std::vector<std::int32_t>{0});
  EXPECT_TRUE(convex.concave_faces.empty());
  EXPECT_TRUE(check(convex.mesh).empty());
  EXPECT_EQ(largest_inward_turn(convex.mesh), 0);
  EXPECT_EQ(total_area(convex.mesh), dvec3(0, 0, 3));
  EXPECT_TRUE(concave_faces(convex.mesh).empty());
}

TEST(ConvexFaces, LeavesConvexAndNearlyStraightFacesAlone) {
  // The corner at (1, e) turns inward by about 2 e: below what counts, and above it.
  const auto dented = [](double e) { return single({{0, 0, 0}, {1, e, 0}, {2, 0, 0}, {1, 2, 0}}); };
  const ConvexMesh same = with_convex_faces(dented(0.02));
  EXPECT_EQ(same.mesh.face_vertices, dented(0.02).face_vertices);
  EXPECT_TRUE(same.cut_faces.empty() && same.concave_faces.empty());
  EXPECT_EQ(with_convex_faces(dented(0.03)).mesh.face_count(), 2);
}

// `teeth` teeth upwards.
PolygonMesh comb(int teeth) {
  std::vector<dvec3> points{{0, 0, 0}, {2.0 * teeth, 0, 0}};
  for (int tooth = teeth - 1; tooth >= 0; --tooth) {
    points.push_back({2 * tooth + 2, 5, 0});
    points.push_back({2 * tooth + 1, 1, 0});
  }
  points.push_back({0, 5, 0});
  return single(points);
}

// A band with so many corners on each side, that turns by `turn` radians between two of them.
PolygonMesh spiral(int corners, double turn) {
  std::vector<dvec3> points, inner;
  for (int i = 0; i < corners; ++i) {
    const double angle = turn * i, radius = 1 + 0.4 * angle;
    points.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    inner.insert(inner.begin(), 0.8 * points.back());
  }
  points.insert(points.end(), inner.begin(), inner.end());
  return single(points);
}

// Every second corner turns inward.
PolygonMesh star(int corners) {
  std::vector<dvec3> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners, radius = i % 2 == 0 ? 1.0 : 0.6;
    points.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  return single(points);
}

// Parts that crossed would count their overlap twice.
void expect_parts_of(const ConvexMesh& convex, const PolygonMesh& mesh) {
  EXPECT_TRUE(convex.concave_faces.empty());
  EXPECT_TRUE(check(convex.mesh).empty());
  EXPECT_LT(largest_inward_turn(convex.mesh), 0.0501);
  double sum = 0;
  for (std::int32_t f = 0; f < convex.mesh.face_count(); ++f) {
    const dvec3 area = area_vector(convex.mesh.positions, convex.mesh.face(f));
    EXPECT_GT(area.z, 0);
    sum += glm::length(area);
  }
  EXPECT_NEAR(sum, glm::length(total_area(mesh)), 1e-12 * sum);
}

// Hertel and Mehlhorn: two diagonals at each corner that turns inward are enough.
TEST(ConvexFaces, CutsCombsStarsAndSpiralsInFewParts) {
  const PolygonMesh narrow = spiral(24, 0.5);
  expect_parts_of(with_convex_faces(narrow), narrow);
  const std::pair<PolygonMesh, int> cases[] = {
      {comb(10), 9}, {comb(1000), 999}, {star(5000), 2500}, {spiral(1000, 0.1), 1000}};
  for (const auto& [mesh, inward] : cases) {
    const ConvexMesh convex = with_convex_faces(mesh);
    expect_parts_of(convex, mesh);
    EXPECT_GT(convex.mesh.face_count(), inward / 2);
    EXPECT_LE(convex.mesh.face_count(), 2 * inward + 1);
  }
}

TEST(ConvexFaces, LargeFacesTakeFewQuestions) {
  for (const int corners : {2000, 20'000}) {
    const PolygonMesh mesh = star(corners);
    EXPECT_LT(test::pairs_asked(corners, [&] { (void)with_convex_faces(mesh); }), 200) << corners;
  }
}

// Each corner of a fine arc turns inward by less than what counts.
TEST(ConvexFaces, CutsArcsThatTurnInwardInAll) {
  const auto plate = [](int corners, double turn) {
    const double end = turn * (corners - 1) / 2, top = -6 * std::cos(end);
    std::vector<dvec3> points{{-9, -9, 0}, {9, -9, 0}, {9, top, 0}};
    for (int i = 0; i < corners; ++i) {
      const double angle = end - turn * i;
      points.push_back({6 * std::sin(angle), -6 * std::cos(angle), 0});
    }
    points.push_back({-9, top, 0});
    return single(points);
  };
  EXPECT_TRUE(concave_faces(plate(5, 0.03)).empty());
  for (const auto& [corners, turn] : {std::pair(60, 0.04), std::pair(600, 0.004)}) {
    const PolygonMesh mesh = plate(corners, turn);
    const ConvexMesh convex = with_convex_faces(mesh);
    expect_parts_of(convex, mesh);
    // 2.4 radians in all, 0.1 a part, two diagonals at each corner that is cut; what of it has many
    // corners in rows.
    EXPECT_GE(convex.mesh.face_count(), 12) << corners;
    EXPECT_LE(convex.mesh.face_count(), 49 + corners / 25) << corners;
  }
}

TEST(ConvexFaces, CutsLargeFacesNowhereAlongAnEdge) {
  PolygonMesh mesh = star(2000);
  const ConvexMesh alone = with_convex_faces(mesh);
  // A second face joins corners that a diagonal joins otherwise.
  const auto part = alone.mesh.face(0);
  ASSERT_EQ(part.size(), 3u);
  std::array<std::int32_t, 2> ends{};
  for (std::size_t i = 0; i < 3; ++i)
    if ((part[(i + 1) % 3] - part[i] + 2000) % 2000 != 1) ends = {part[(i + 1) % 3], part[i]};
  const std::int32_t apex = mesh.vertex_count();
  mesh.positions.push_back({0, 0, 1});
  mesh.add_face(std::array{ends[0], ends[1], apex});
  const ConvexMesh convex = with_convex_faces(mesh);
  EXPECT_EQ(convex.mesh.face_count(), alone.mesh.face_count());  // one part less, one face more
}

TEST(ConvexFaces, KeepsRandomPolygonMeshesUsable) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const PolygonMesh mesh = shapes::random_polygon_mesh(
        {.seed = seed, .merged_share = 0.2 * seed, .largest_face = 12, .jitter = 0.05 * seed});
    const ConvexMesh convex = with_convex_faces(mesh);
    EXPECT_FALSE(convex.cut_faces.empty());
    EXPECT_TRUE(convex.concave_faces.empty()) << convex.concave_faces.size();
    EXPECT_TRUE(check(convex.mesh).empty());
    EXPECT_EQ(convex.mesh.positions, mesh.positions);
    EXPECT_LT(glm::length(total_area(convex.mesh)), 1e-9);  // closed, as before
    std::map<std::int32_t, dvec3> areas;
    for (std::int32_t f = 0; f < convex.mesh.face_count(); ++f)
      areas[convex.source_faces[f]] += area_vector(mesh.positions, convex.mesh.face(f));
    for (const auto& [face, area] : areas)
      EXPECT_LT(glm::distance(area, area_vector(mesh.positions, mesh.face(face))), 1e-12);
  }
}

TEST(ConvexFaces, CutsNowhereAlongAnEdge) {
  // The only way out of the dent at 1 is to 3, which a second face already joins with it.
  PolygonMesh mesh = single({{0, 0, 0}, {1, 0.5, 0}, {2, 0, 0}, {1, 2, 0}});
  mesh.positions.push_back({1, 1, 1});
  mesh.add_face(std::array{1, 3, 4});
  const ConvexMesh convex = with_convex_faces(mesh);
  EXPECT_TRUE(convex.cut_faces.empty());
  EXPECT_EQ(convex.concave_faces, std::vector<std::int32_t>{0});
  EXPECT_EQ(convex.mesh.face_vertices, mesh.face_vertices);
}

TEST(ConvexFaces, CarryWhatRidesOnThem) {
  PolygonMesh mesh = letter_l();
  mesh.positions.push_back({3, 0, 0});
  mesh.add_face(std::array{1, 6, 2});
  for (std::int32_t corner = 0; corner < 9; ++corner) mesh.uvs.push_back(glm::dvec2(corner, 0));
  mesh.face_uvs = {8, 7, 6, 5, 4, 3, 2, 1, 0};
  mesh.groups = {{"body", ""}, {"fin", ""}};
  mesh.face_groups = {0, 1};
  mesh.hole_faces = {0};
  mesh.creases = {{2, 3, kInfiniteSharpness}};
  const ConvexMesh convex = with_convex_faces(mesh);
  EXPECT_EQ(convex.mesh.face_groups, (std::vector<std::int32_t>{0, 0, 1}));
  EXPECT_EQ(convex.mesh.hole_faces, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(convex.mesh.creases.size(), 1u);
  ASSERT_EQ(convex.mesh.face_uvs.size(), convex.mesh.face_vertices.size());
  for (std::size_t c = 0; c < 8; ++c)  // those of the first face
    EXPECT_EQ(convex.mesh.face_uvs[c], 8 - convex.mesh.face_vertices[c]);
  EXPECT_EQ(convex.mesh.face_uvs[8], 2);
}

TEST(ConvexFaces, LeaveWhatHasNoInsideAlone) {
  const PolygonMesh bow = single({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}});
  EXPECT_EQ(with_convex_faces(bow).mesh.face_count(), 1);
  const PolygonMesh point = single({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  EXPECT_EQ(with_convex_faces(point).mesh.face_count(), 1);
}

}  // namespace
}  // namespace planish

namespace planish::test {
namespace {

using glm::dvec2;
using std::numbers::pi;

double area_of(const Outline& outline) {
  double sum = 0;
  for (std::size_t i = 0; i < outline.size(); ++i)
    sum += cross(outline[i], outline[(i + 1) % outline.size()]);
  return sum;
}

std::vector<std::size_t> all_corners(const Outline& outline) {
  std::vector<std::size_t> part(outline.size());
  std::iota(part.begin(), part.end(), std::size_t{0});
  return part;
}

TEST(CornerSwirl, IsNoneOfAffineRegularPolygons) {
  for (const int n : {3, 4, 33, 1000}) {
    Outline outline;
    for (int i = 0; i < n; ++i) {
      const dvec2 p(std::cos(2 * pi * i / n), std::sin(2 * pi * i / n));
      outline.emplace_back(5 + 3 * p.x + p.y, 0.1 * p.y - 2);
    }
    EXPECT_LT(corner_swirl(outline), 1e-9) << n;
    EXPECT_EQ(corner_swirl(Outline(outline.rbegin(), outline.rend())), n / 2.0);
  }
}

// Angles moved by a wave that leaves the first Fourier pair as it was, up to the wave's square.
TEST(CornerSwirl, CountsCorners) {
  constexpr int kCorners = 1000;
  constexpr double kMoved = 1e-3;
  Outline outline;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * pi * i / kCorners, at = angle + kMoved * std::sin(3 * angle);
    outline.emplace_back(std::cos(at), std::sin(at));
  }
  EXPECT_NEAR(corner_swirl(outline), kMoved * kCorners / (2 * pi), 1e-3);
}

std::vector<std::pair<const char*, Outline>> outlines() {
  return {{"rounded square", rounded_square(100, 0.5)},
          {"square with small arcs", rounded_square(64, 0.1)},
          {"slot", slot(100, 4)},
          {"half disc", pie_slice(300, 180)},
          {"pie slice", pie_slice(100, 20)},
          {"two corners", pie_slice(500, 90)}};
}

// Every side of the polygon belongs to one part, every diagonal to two, none of them crosses.
TEST(EvenParts, AreThePolygon) {
  for (const auto& [name, outline] : outlines()) {
    SCOPED_TRACE(name);
    ASSERT_GT(corner_swirl(outline), kMostSwirl);
    std::map<std::pair<std::size_t, std::size_t>, int> asked;
    const auto parts = even_parts(outline, all_corners(outline), [&](std::size_t a, std::size_t b) {
      ++asked[std::minmax(a, b)];
      return true;
    });
    std::map<std::pair<std::size_t, std::size_t>, int> edges;
    double sum = 0;
    for (const auto& part : parts) {
      Outline places;
      for (const std::size_t corner : part) places.push_back(outline[corner]);
      EXPECT_LE(corner_swirl(places), kMostSwirl);
      EXPECT_GT(area_of(places), 0);
      sum += area_of(places);
      for (std::size_t i = 0; i < part.size(); ++i)
        ++edges[std::minmax(part[i], part[(i + 1) % part.size()])];
    }
    EXPECT_NEAR(sum, area_of(outline), 1e-9 * sum);
    EXPECT_LE(parts.size(), outline.size());
    EXPECT_EQ(asked.size(), parts.size() - 1);
    for (const auto& [edge, count] : edges) {
      const std::size_t apart = edge.second - edge.first;
      const bool is_side = apart == 1 || apart == outline.size() - 1;
      EXPECT_EQ(count, is_side ? 1 : 2);
      EXPECT_EQ(asked.contains(edge), !is_side);
    }
  }
}

// Where every diagonal may cut, or none.
std::vector<std::vector<std::size_t>> parts_of(const Outline& outline, bool may_cut = true) {
  return even_parts(outline, all_corners(outline),
                    [&](std::size_t, std::size_t) { return may_cut; });
}

TEST(EvenParts, AreMostlyQuadsBetweenFinelyDrawnSides) {
  for (const Outline& outline : {rounded_square(100, 0.5), slot(100, 4), pie_slice(300, 180)}) {
    const auto parts = parts_of(outline);
    const auto quads =
        std::ranges::count_if(parts, [](const auto& part) { return part.size() == 4; });
    EXPECT_GT(4 * quads, 3 * std::ssize(parts));
  }
}

TEST(EvenParts, TakeFewQuestions) {
  for (const int steps : {500, 5000})
    for (const Outline& outline :
         {rounded_square(steps, 0.5), slot(steps, 4), pie_slice(4 * steps, 90)})
      EXPECT_LT(pairs_asked(outline.size(), [&] { (void)parts_of(outline); }), 200) << steps;
}

TEST(EvenParts, StayWholeWhereNothingMayCut) {
  const Outline outline = slot(100, 4);
  const auto parts = parts_of(outline, false);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].size(), outline.size());
}

}  // namespace
}  // namespace planish::test
