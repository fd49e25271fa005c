#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/fair/fair_topology.h"

namespace planish {

/// The point of the convex hull of some vectors that is nearest to the origin, found vector by
/// vector: whoever adds those that lie farthest back along it ends at the hull of all of them.
/// Source: Wolfe, "Finding the nearest point in a polytope", Mathematical Programming 11, 1976.
template <class Vector>
class NearestInHull {
 public:
  explicit NearestInHull(const Vector& first) : count_(1), point_(first) {
    vectors_[0] = first;
    weights_[0] = 1;
  }

  [[nodiscard]] const Vector& point() const { return point_; }

  /// The hull with `vector` in it, as far as its nearest point goes. False where that is no nearer.
  bool add(const Vector& vector) {
    if (count_ == kMost) return false;
    vectors_[count_] = vector;
    weights_[count_++] = 0;
    Weights wanted;
    while (affine_minimum(wanted)) {
      const bool is_inside =
          std::all_of(wanted.begin(), wanted.begin() + count_, [](double w) { return w > kNone; });
      move_towards(wanted, is_inside ? 1 : share_inside(wanted));
      if (!is_inside) continue;
      return set_point();
    }
    return set_point();
  }

 private:
  static constexpr int kMost = static_cast<int>(Vector::length()) + 1;
  static constexpr double kNone = 1e-15;  // a weight that is none
  using Weights = std::array<double, kMost>;

  // Of the affine hull's point that is nearest to the origin: (V V^T + 1) w is the same for all.
  // False where the vectors span less than that.
  bool affine_minimum(Weights& wanted) const {
    std::array<std::array<double, kMost>, kMost> l{};
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = 1 + dot(vectors_[i], vectors_[j]);
        for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
        if (i == j && !(sum > 1e-14)) return false;
        l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
      }
    }
    double total = 0;
    for (int i = 0; i < count_; ++i) {
      wanted[i] = 1;
      for (int k = 0; k < i; ++k) wanted[i] -= l[i][k] * wanted[k];
      wanted[i] /= l[i][i];
    }
    for (int i = count_ - 1; i >= 0; --i) {
      for (int k = i + 1; k < count_; ++k) wanted[i] -= l[k][i] * wanted[k];
      total += wanted[i] /= l[i][i];
    }
    for (int i = 0; i < count_; ++i) wanted[i] /= total;
    return true;
  }

  // How far weights can go towards those until the first of them is none.
  [[nodiscard]] double share_inside(const Weights& wanted) const {
    double share = 1;
    for (int i = 0; i < count_; ++i)
      if (wanted[i] <= kNone) share = std::min(share, weights_[i] / (weights_[i] - wanted[i]));
    return share;
  }

  // And leaves out those that are none.
  void move_towards(const Weights& wanted, double share) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const double weight = weights_[i] + share * (wanted[i] - weights_[i]);
      if (!(weight > kNone)) continue;
      vectors_[kept] = vectors_[i];
      weights_[kept++] = weight;
    }
    count_ = kept;
  }

  bool set_point() {
    Vector point(0.0);
    double total = 0;
    for (int i = 0; i < count_; ++i) total += weights_[i];
    for (int i = 0; i < count_; ++i) point += weights_[i] / total * vectors_[i];
    const bool is_nearer = dot(point, point) < dot(point_, point_);
    if (is_nearer) point_ = point;
    return is_nearer;
  }

  int count_;
  std::array<Vector, kMost> vectors_;
  Weights weights_;
  Vector point_;
};

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

/// The direction that is nearest to all normals of the faces around a vertex, and the least cosine
/// with them: at 0 no plane through the vertex sees all of them from outside.
struct NormalCap {
  glm::dvec3 normal;  ///< unit
  double cosine;
};

/// The vertex's own normal, with the cosine 0, where there is none; see best_view().
[[nodiscard]] NormalCap smallest_cap(const FairTopology& topology,
                                     std::span<const glm::dvec3> face_normals, std::int32_t vertex,
                                     const glm::dvec3& normal);

/// The vertex's normal where all faces around it are seen from it well enough, at a fifth of the
/// cap's cosine; else turned towards the cap's as far as that takes. Continuous.
[[nodiscard]] glm::dvec3 tilted_normal(const FairTopology& topology,
                                       std::span<const glm::dvec3> face_normals,
                                       std::int32_t vertex, const glm::dvec3& normal);

/// The least cosine between a unit direction and the normals of the faces around a vertex.
[[nodiscard]] double least_face_cosine(const FairTopology& topology,
                                       std::span<const glm::dvec3> face_normals,
                                       std::int32_t vertex, const glm::dvec3& direction);

/// Scratch memory, reused from vertex to vertex.
struct PerpendicularScratch {
  std::vector<glm::dvec2> edges, points;
  std::vector<double> weights;
};

/// Heights of faces over their longest sides; of polygons half of them, as they narrow towards it.
/// Those of large faces, at each of whose vertices they are asked for, are found once.
class FaceHeights {
 public:
  FaceHeights(const FairTopology& topology, std::span<const glm::dvec3> given);
  [[nodiscard]] double of(std::int32_t face) const;
  /// How far the control points of a perpendicular polygon may lie from the vertex: half the least
  /// height of the faces around it.
  [[nodiscard]] double size_at(std::int32_t vertex) const;

 private:
  [[nodiscard]] double measured(std::int32_t face) const;

  const FairTopology& topology_;
  std::span<const glm::dvec3> given_;
  std::vector<double> of_large_;  // by FairTopology::large_faces
};

/// Replaces the polygon around a smooth or dart vertex, in `offsets`, by a small one in the plane
/// of `normal` (unit) whose sides are at right angles to the edges that they cross, its mean 0:
/// neither edges nor faces fold beside polygons of this kind that are small enough, nor does the
/// vertex itself (see README.md). Where the edges do not surround the vertex in the plane there is
/// none, and evenly spread points on a circle stand in; in between both are blended. `size`: how
/// far the points may lie from the vertex.
void build_perpendicular_polygon(const FairTopology& topology, std::span<const glm::dvec3> given,
                                 std::int32_t vertex, const glm::dvec3& normal, double size,
                                 PerpendicularScratch& scratch, std::span<glm::dvec3> offsets);

/// How much of balanced weights is taken where they are usable so far (vertex_polygon.h); the
/// rest of a polygon is that of a circle. 1 but for a short ramp.
[[nodiscard]] double chain_share(double usable);

/// What stands at a vertex with sharp edges; `offsets`: the state relative to the given points,
/// changed in place.
struct CurveSite {
  const FairTopology& topology;
  std::span<const glm::dvec3> given, face_normals;
  std::span<glm::dvec3> offsets;
  const FaceHeights& heights;
  std::int32_t vertex;
  /// From the vertex to another one.
  [[nodiscard]] glm::dvec3 edge(std::int32_t other) const { return given[other] - given[vertex]; }
};

/// As build_perpendicular_polygon() at a crease or boundary vertex: in every sector a chain from
/// one curve point to the other whose parts are at right angles to the edges that they cross, the
/// sharp ones included. The curve keeps its direction there and takes the length that fits; the
/// sector's limit normal does not turn over where the curve turns by less than a right angle to
/// either side. Where a sector's edges all lie to one side the points of a half circle stand in.
/// The sector's plane leans, about the curve, so that it sees all faces if any does; by how much is
/// chosen where `lean` is not (fair_topology.h).
void build_perpendicular_crease(const CurveSite& site, glm::vec2& lean,
                                PerpendicularScratch& scratch);

/// The same at a corner, where every face has its own plane: the polygon around a circle. Where the
/// sharp edges on both sides of a sector meet or cross, as at the tip of a slit, they are drawn
/// apart, where that turns fewer faces back: which sectors is chosen where `lean` is not.
void build_perpendicular_corner(const CurveSite& site, glm::vec2& lean);

/// Scales all control points of the vertex, those on its curves too.
void scale_curve_vertex(const CurveSite& site, double factor);

/// Least cosine between the limit normals of a crease or boundary vertex's sectors and their faces.
[[nodiscard]] double least_sector_cosine(const FairTopology& topology,
                                         std::span<const glm::dvec3> face_normals,
                                         std::span<const glm::dvec3> offsets, std::int32_t vertex);

/// At a corner: the largest part of a face's way from the vertex to its opposite side that the next
/// step leads its control point, which draws it towards a regular fan between the curve points.
/// Long sharp edges beside small faces lead it far out of them.
[[nodiscard]] double farthest_fan_point(const FairTopology& topology,
                                        std::span<const glm::dvec3> given,
                                        std::span<const glm::dvec3> offsets, std::int32_t vertex);

}  // namespace planish
