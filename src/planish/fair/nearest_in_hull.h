#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

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

}  // namespace planish
