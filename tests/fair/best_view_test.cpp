#include "planish/fair/perpendicular_polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <random>
#include <vector>

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

}  // namespace
}  // namespace planish::test
