#pragma once

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

/// The unit vector from which the worst of some vectors is seen best, with that cosine; nearly,
/// starting from `start`: within about a degree after 60 steps. worst_of(direction) returns a
/// SeenFrom, normalised(vector, otherwise) a unit vector, which may keep to a plane.
/// Source: Badoiu & Clarkson, "Smaller core-sets for balls", 2003.
template <class Vector, class WorstOf, class Normalise>
[[nodiscard]] SeenFrom<Vector> best_view(const Vector& start, int steps, const WorstOf& worst_of,
                                         const Normalise& normalised) {
  SeenFrom<Vector> best{start, -2};
  Vector direction = start;
  for (int step = 0; step < steps; ++step) {
    const SeenFrom<Vector> worst = worst_of(direction);
    if (worst.cosine > best.cosine) best = {direction, worst.cosine};
    direction = normalised(direction + (worst.vector - direction) / (2.0 + step), direction);
  }
  return best;
}

/// `own` where the worst is seen from it well enough, at a fifth of the best cosine, or where none
/// is seen from the best view either; else turned towards the best view as far as that takes.
/// Continuous.
template <class Vector, class WorstOf, class Normalise>
[[nodiscard]] Vector turned_to_see(const Vector& own, const WorstOf& worst_of,
                                   const Normalise& normalised) {
  constexpr int kViewSteps = 60, kTurnSteps = 8;
  constexpr double kSeenShare = 0.2;
  const SeenFrom<Vector> best = best_view(own, kViewSteps, worst_of, normalised);
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
