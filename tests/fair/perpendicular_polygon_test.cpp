#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/fold_cure.h"
#include "planish/fair/perpendicular_polygon.h"
#include "planish/fair/vertex_polygon.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using glm::dvec4;

template <class Vector>
SeenFrom<Vector> view_of(const std::vector<Vector>& vectors) {
  return best_view(glm::normalize(vectors[0]), [&](const Vector& direction) {
    return least_seen<Vector>(vectors, direction, [](const Vector& v) { return v; });
  });
}

double worst_of(const std::vector<dvec3>& vectors, const dvec3& direction) {
  double worst = 2;
  for (const dvec3& v : vectors) worst = std::min(worst, glm::dot(direction, v));
  return worst;
}

// Unit vectors in a cone about z.
std::vector<dvec3> cone_of(std::mt19937& random, int count, double widest) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<dvec3> vectors;
  for (int i = 0; i < count; ++i) {
    const double angle = widest * std::sqrt(uniform(random)), turn = 2 * M_PI * uniform(random);
    vectors.emplace_back(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                         std::cos(angle));
  }
  return vectors;
}

// The best of all directions that see one, two or three of the vectors alike.
double best_of_all(const std::vector<dvec3>& vectors) {
  double best = -2;
  const auto take = [&](const dvec3& direction) {
    const double length = glm::length(direction);
    if (length > 1e-12) best = std::max(best, worst_of(vectors, direction / length));
  };
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    take(vectors[i]);
    for (std::size_t j = 0; j < i; ++j) {
      take(vectors[i] + vectors[j]);
      for (std::size_t k = 0; k < j; ++k) {
        const dvec3 across = glm::cross(vectors[j] - vectors[i], vectors[k] - vectors[i]);
        take(across);
        take(-across);
      }
    }
  }
  return best;
}

TEST(BestView, IsTheBestOfAllDirections) {
  std::mt19937 random(1);
  for (int round = 0; round < 400; ++round) {
    const std::vector<dvec3> vectors = cone_of(random, 1 + round % 14, 0.1 + 1.4 * (round % 7) / 6);
    const SeenFrom<dvec3> view = view_of(vectors);
    const double best = best_of_all(vectors);
    ASSERT_NEAR(view.cosine, best, 1e-12) << round;
    ASSERT_NEAR(worst_of(vectors, view.vector), best, 1e-12) << round;
    ASSERT_NEAR(glm::length(view.vector), 1, 1e-12) << round;
  }
}

// Pairs of mirror images tie: which of them is found first decides nothing.
TEST(BestView, IsContinuousWhereVectorsTie) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 200; ++round) {
    std::vector<dvec3> vectors = cone_of(random, 1 + round % 6, 1.4);
    for (std::size_t i = 0, count = vectors.size(); i < count; ++i) {
      const dvec3 v = vectors[i];
      vectors.emplace_back(-v.x, v.y, v.z);
      vectors.push_back(v);  // and once more
    }
    const SeenFrom<dvec3> view = view_of(vectors);
    for (dvec3& v : vectors)
      v = glm::normalize(v + 1e-15 * dvec3(uniform(random), uniform(random), uniform(random)));
    const SeenFrom<dvec3> moved = view_of(vectors);
    ASSERT_LT(glm::distance(view.vector, moved.vector), 1e-7) << round;
    ASSERT_NEAR(view.cosine, moved.cosine, 1e-12) << round;
  }
}

TEST(BestView, IsTheStartWhereNothingSeesAll) {
  const std::vector<dvec3> around = {{1, 0, 0}, {-1, 0, 0.1}, {0, 1, 0}, {0, -1, 0.1}, {0, 0, -1}};
  EXPECT_EQ(view_of(around).vector, around[0]);
  EXPECT_EQ(view_of(around).cosine, 0);
  const std::vector<dvec3> opposite = {{1, 0, 0}, {-1, 0, 0}};
  EXPECT_EQ(view_of(opposite).cosine, 0);
}

// Where the nearest point is the nearest: none lies farther back along it, and it is a sum of them.
TEST(BestView, HasAsManyDimensionsAsItsVectors) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  int seen = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<dvec4> vectors;
    for (int i = 0; i < 3 + round % 20; ++i)
      vectors.emplace_back(normal(random), normal(random), normal(random), 2 + normal(random));
    const SeenFrom<dvec4> view = view_of(vectors);
    if (!(view.cosine > 1e-6)) continue;
    ++seen;
    // By duality: no other direction sees better. A few steps uphill find none.
    for (int other = 0; other < 200; ++other) {
      const dvec4 direction = glm::normalize(
          view.vector + std::pow(10.0, -(other % 7)) *
                            dvec4(normal(random), normal(random), normal(random), normal(random)));
      double worst = 1e9;
      for (const dvec4& v : vectors) worst = std::min(worst, glm::dot(direction, v));
      ASSERT_LT(worst, view.cosine + 1e-12);
    }
  }
  EXPECT_GT(seen, 150);
}

TEST(TurnedToSee, TurnsExactlyAsFarAsItMust) {
  std::mt19937 random(4);
  int turned = 0;
  for (int round = 0; round < 300; ++round) {
    const std::vector<dvec3> vectors = cone_of(random, 3 + round % 9, 1.3);
    const dvec3 own = cone_of(random, 1, 1.5)[0];
    const auto see = [&](const dvec3& direction) {
      return least_seen<dvec3>(vectors, direction, [](const dvec3& v) { return v; });
    };
    const dvec3 found =
        turned_to_see(own, see, [](const dvec3& v, const dvec3&) { return glm::normalize(v); });
    const double wanted = 0.2 * view_of(vectors).cosine;
    if (see(own).cosine >= wanted) {
      EXPECT_EQ(found, own);
    } else {
      ++turned;
      ASSERT_NEAR(see(found).cosine, wanted, 1e-9) << round;
    }
  }
  EXPECT_GT(turned, 50);
}

using std::int32_t;

// A cone of n triangles over points at uneven angles and distances; vertex n is its tip.
PolygonMesh uneven_cone(int n, double height, std::uint32_t seed) {
  std::mt19937 engine(seed);
  const auto unit = [&] { return engine() * 0x1p-32; };
  std::vector<double> gaps;
  for (int i = 0; i < n; ++i) gaps.push_back(std::pow(unit(), 3) + 0.01);
  double sum = 0, angle = 0;
  for (const double gap : gaps) sum += gap;
  PolygonMesh mesh;
  for (int i = 0; i < n; ++i) {
    const double radius = 0.3 + unit();
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                0.3 * height * unit());
    // No gap of half a turn, or the edges do not surround the tip.
    angle += std::min(gaps[i] / sum, 0.45) * 2 * std::numbers::pi;
  }
  mesh.positions.emplace_back(0.0, 0.0, height);
  for (int i = 0; i < n; ++i) mesh.add_face(std::array{n, i, (i + 1) % n});
  return mesh;
}

struct Cone : FairCase {
  explicit Cone(const PolygonMesh& polygons)
      : FairCase(polygons),
        offsets(std::size_t(topology.state_size), dvec3(0.0)),
        tip(mesh.vertex_count() - 1) {}
  [[nodiscard]] std::vector<dvec3> polygon(const dvec3& normal) {
    PerpendicularScratch scratch;
    build_perpendicular_polygon(topology, given, tip, normal,
                                FaceHeights(topology, given).size_at(tip), scratch, offsets);
    std::vector<dvec3> points;
    for (int32_t i = topology.ring_offsets[tip]; i < topology.ring_offsets[tip + 1]; ++i) {
      points.push_back(offsets[topology.ring_corners[i]]);
    }
    return points;
  }
  [[nodiscard]] dvec3 edge(int32_t i) const {
    return given[topology.ring_next[topology.ring_offsets[tip] + i]] - given[tip];
  }
  [[nodiscard]] dvec3 tip_normal() const {
    return NetSamples{topology, given, offsets}.at_vertex(tip);
  }

  std::vector<dvec3> offsets;
  int32_t tip;
};

TEST(PerpendicularPolygon, ItsSidesCrossTheEdgesAtRightAngles) {
  int built = 0;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    Cone cone(uneven_cone(3 + int(seed % 9), 0.2, seed));
    const dvec3 normal(0, 0, 1);
    const std::vector<dvec3> points = cone.polygon(normal);
    const auto n = points.size();
    dvec3 sum(0.0);
    double farthest = 0;
    for (const dvec3& p : points) {
      sum += p;
      farthest = std::max(farthest, glm::length(p));
    }
    std::vector<glm::dvec2> flat_edges(n);
    std::vector<double> weights(n);
    for (std::size_t i = 0; i < n; ++i) {
      flat_edges[i] = glm::normalize(glm::dvec2(cone.edge(int32_t(i))));
    }
    if (chain_share(balance(flat_edges, weights)) < 1) continue;  // of a circle
    ++built;
    EXPECT_GT(farthest, 0.0);
    EXPECT_LT(glm::length(sum), 1e-12);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(points[i].z, 0, 1e-15);
      const dvec3 side = points[i] - points[(i + n - 1) % n];
      const dvec3 edge = cone.edge(int32_t(i));
      const dvec3 flat(edge.x, edge.y, 0);
      // To balance()'s own tolerance: its first side closes the polygon.
      if (i > 0) {
        EXPECT_NEAR(glm::dot(side, flat), 0, 1e-14);
      }
      EXPECT_GT(glm::dot(glm::cross(flat, side), normal), 0) << seed;
    }
  }
  EXPECT_GT(built, 20);
}

// The first Fourier pair's cross product has the sign of the polygon's turning, by Rado, Kneser
// and Choquet's theorem, however uneven the edges are.
TEST(PerpendicularPolygon, LimitNormalIsThePlanesHoweverUnevenTheEdges) {
  int built = 0;
  for (std::uint32_t seed = 1; seed <= 300; ++seed) {
    Cone cone(uneven_cone(3 + int(seed % 40), 0.2, seed));
    (void)cone.polygon(dvec3(0, 0, 1));
    const dvec3 normal = cone.tip_normal();
    if (glm::length(normal) == 0) continue;
    ++built;
    EXPECT_GT(normal.z, 0.999 * glm::length(normal)) << seed;
  }
  EXPECT_GT(built, 100);
}

// The circle's normal is that of the plane too.
TEST(PerpendicularPolygon, IsACircleWhereTheEdgesDoNotSurroundTheVertex) {
  Cone side(uneven_cone(5, 5, 2));  // a spike seen from its side
  const std::vector<dvec3> points = side.polygon(dvec3(1, 0, 0));
  const double radius = glm::length(points[0]);
  EXPECT_GT(radius, 0.0);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(points[i].x, 0, 1e-15);
    EXPECT_NEAR(glm::length(points[i]), radius, 1e-14);
    EXPECT_NEAR(glm::dot(points[i], points[(i + 1) % 5]), radius * radius * std::cos(2 * M_PI / 5),
                1e-14);
  }
  EXPECT_GT(side.tip_normal().x, 0.0);
}

TEST(SmallestCap, IsTheSameFromAllFacesOfARegularCorner) {
  const FairCase c(cube());
  const NormalCap cap =
      smallest_cap(c.topology, c.face_normals, 7, glm::normalize(dvec3(1, 0.1, 0)));
  EXPECT_NEAR(cap.cosine, 1 / std::sqrt(3.0), 0.02);
  EXPECT_GT(glm::dot(cap.normal, glm::normalize(dvec3(1, 1, 1))), 0.999);
}

TEST(SmallestCap, TiltsANormalOnlyAsFarAsItMust) {
  const FairCase c(cube());
  const dvec3 good = glm::normalize(dvec3(1, 1, 0.5));
  EXPECT_EQ(tilted_normal(c.topology, c.face_normals, 7, good), good);
  const dvec3 bad = glm::normalize(dvec3(1, 1, -0.5));
  const dvec3 tilted = tilted_normal(c.topology, c.face_normals, 7, bad);
  const double cosine = least_face_cosine(c.topology, c.face_normals, 7, tilted);
  EXPECT_GE(cosine, 0.2 / std::sqrt(3.0) - 0.01);
  EXPECT_LT(cosine, 0.2 / std::sqrt(3.0) + 0.02);
}

// Nothing can be built about a curve without a direction: what stands there comes half as near.
TEST(PerpendicularCrease, WithoutADirectionItsPointsComeHalfAsNear) {
  const FairCase c(flat_grid(2, 2));
  const FairTopology& topology = c.topology;
  constexpr int32_t kVertex = 1;  // in the middle of a side
  ASSERT_EQ(topology.kind(kVertex), VertexKind::Crease);
  const auto sector = topology.sectors[static_cast<std::size_t>(
      topology.sector_offsets[topology.crease_of_vertex[kVertex]])];
  const dvec3 offset(1, 2, 3);
  std::vector<dvec3> offsets(static_cast<std::size_t>(topology.state_size), offset);
  offsets[static_cast<std::size_t>(sector.curve0)] = dvec3(0.0);
  std::vector<dvec3> expected = offsets;
  for (const int32_t corner : topology.ring(sector).corners)
    expected[static_cast<std::size_t>(corner)] = 0.5 * offset;
  expected[static_cast<std::size_t>(sector.curve1)] = 0.5 * offset;
  const FaceHeights heights(topology, c.given);
  glm::vec2 lean(0.0F);
  PerpendicularScratch scratch;
  build_perpendicular_crease({topology, c.given, c.face_normals, offsets, heights, kVertex}, lean,
                             scratch);
  EXPECT_EQ(offsets, expected);
}

// The fan's point of a square lies on its diagonal: with control points a tenth of the sides along
// them, and one a tenth of the square, it has gone a tenth of the way to the opposite side.
TEST(FanPoint, IsMeasuredAlongTheWayToTheOppositeSide) {
  const FairCase c(flat_grid(2, 2));
  const FairTopology& topology = c.topology;
  constexpr int32_t kVertex = 0;  // of one square
  const auto corner =
      topology.ring_corners[static_cast<std::size_t>(topology.ring_offsets[kVertex])];
  const auto at = [](int32_t index) { return static_cast<std::size_t>(index); };
  const dvec3 along = c.given[1] - c.given[0], across = c.given[3] - c.given[0];
  for (const double part : {0.1, 0.4, 2.0}) {
    std::vector<dvec3> offsets(at(topology.state_size), dvec3(0.0));
    offsets[at(corner)] = part * (along + across);
    offsets[at(topology.corner_cw[at(corner)])] = part * along;
    offsets[at(topology.corner_ccw[at(corner)])] = part * across;
    EXPECT_NEAR(farthest_fan_point(topology, c.given, offsets, kVertex), part, 1e-12);
  }
}

}  // namespace
}  // namespace planish::test
