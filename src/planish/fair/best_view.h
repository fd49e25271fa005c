#pragma once

#include <cmath>

#include "planish/fair/nearest_in_hull.h"

namespace planish {

/// What is seen least from a direction, and the cosine, or product, between the two.
template <class Vector>
struct SeenFrom {
  Vector vector{0.0};
  double cosine = 2;
};

/// The least of `items`, each of which vector_of(item) makes a vector; 2 where there are none.
template <class Vector, class Items, class VectorOf>
[[nodiscard]] SeenFrom<Vector> least_seen(const Items& items, const Vector& direction,
                                          const VectorOf& vector_of) {
  SeenFrom<Vector> least;
  for (const auto& item : items) {
    const Vector vector = vector_of(item);
    const double cosine = dot(direction, vector);
    if (cosine < least.cosine) least = {vector, cosine};
  }
  return least;
}

/// The unit vector from which the worst of some vectors is seen best, with that cosine: where it is
/// above 0, it points to what of their convex hull is nearest to the origin, at that distance, and
/// is a continuous function of them. Else `start`, with the cosine 0. worst_of(direction) returns a
/// SeenFrom; where directions keep to a plane, its vectors do.
template <class Vector, class WorstOf>
[[nodiscard]] SeenFrom<Vector> best_view(const Vector& start, const WorstOf& worst_of) {
  constexpr int kMostSteps = 100;        // a handful suffices
  constexpr double kConverged = 1e-14;   // of the squared distance
  constexpr double kLeastCosine = 1e-9;  // below it the hull has the origin in it
  NearestInHull<Vector> nearest(worst_of(start).vector);
  SeenFrom<Vector> best{start, 0};
  for (int step = 0; step < kMostSteps; ++step) {
    const double distance = std::sqrt(dot(nearest.point(), nearest.point()));
    if (!(distance > kLeastCosine)) return {start, 0};
    const Vector direction = nearest.point() / distance;
    const SeenFrom<Vector> worst = worst_of(direction);
    if (worst.cosine > best.cosine) best = {direction, worst.cosine};
    if (worst.cosine >= (1 - kConverged) * distance || !nearest.add(worst.vector)) break;
  }
  return best;
}

/// `own` where the worst is seen from it well enough, at a fifth of the best cosine, or where none
/// is seen from the best view either; else turned towards the best view as far as that takes.
/// Continuous. normalised(vector, otherwise) is a unit vector, which may keep to a plane.
template <class Vector, class WorstOf, class Normalise>
[[nodiscard]] Vector turned_to_see(const Vector& own, const WorstOf& worst_of,
                                   const Normalise& normalised) {
  constexpr int kTurnSteps = 40;
  constexpr double kSeenShare = 0.2;
  const SeenFrom<Vector> best = best_view(own, worst_of);
  const auto is_seen = [&](const Vector& direction) {
    return worst_of(direction).cosine >= kSeenShare * best.cosine;
  };
  if (best.cosine <= 0 || is_seen(own)) return own;
  const auto between = [&](double share) {
    return normalised((1 - share) * own + share * best.vector, best.vector);
  };
  double least = 0, enough = 1;
  for (int step = 0; step < kTurnSteps; ++step) {
    const double middle = (least + enough) / 2;
    (is_seen(between(middle)) ? enough : least) = middle;
  }
  return between(enough);
}

}  // namespace planish
