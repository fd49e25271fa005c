#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace planish {

/// The circulant that makes an m-gon's corner points X_i = sum_j c_m(j-i) P_j.
enum class Weights {
  /// Doo & Sabin 1978. Curvature is bounded around vertices of valence 3 and 4 and in faces of as
  /// many
  /// corners; with five and more it grows as log(1/r) towards the point, since the step's
  /// eigenvalue 1/4 has Jordan blocks of two there.
  DooSabin,
  Averaged,  ///< the paper, equation (1): average of vertex, centroid and two edge midpoints
};

/// c_m(0..m-1), for m >= 2; sums to 1. m = 2 arises at interior vertices of valence 2.
/// Source: Doo & Sabin 1978; the paper, equation (1).
[[nodiscard]] std::vector<double> face_weights(Weights weights, std::int32_t m);

/// The same for large faces, in time of their corners: with M the mean of the corners and C, S
/// their first Fourier pair, 2/m sum_j cos(2 pi j / m) P_j and likewise with sines,
///
///   X_i = own P_i + beside (P_(i-1) + P_(i+1)) + mean M + turn (cos(2 pi i / m) C + sin(...) S)
///
/// for any m >= 3. A derivation of our own.
struct FaceSumRule {
  double own, beside, mean, turn;

  /// M alone, or all three.
  [[nodiscard]] constexpr std::int32_t sum_count() const { return turn == 0 ? 1 : 3; }
};
[[nodiscard]] constexpr FaceSumRule face_sum_rule(Weights weights) {
  return weights == Weights::Averaged ? FaceSumRule{0.5, 0.125, 0.25, 0}
                                      : FaceSumRule{0.25, 0, 0.75, 0.25};
}

/// Faces of this many corners or more go by those sums, as large rings do. Smaller ones have hardly
/// more corners than sums take columns.
inline constexpr std::int32_t kSummedRing = 32;

/// c_m of all sizes, those that meshes have many of made once.
class FaceWeights {
 public:
  explicit FaceWeights(Weights weights);

  [[nodiscard]] Weights weights() const { return weights_; }
  /// c_m(0..m-1). Large ones are computed into `scratch`, which keeps the last of them and must be
  /// used for nothing else.
  [[nodiscard]] std::span<const double> of(std::int32_t m, std::vector<double>& scratch) const;

 private:
  static constexpr std::int32_t kCachedSize = 64;
  Weights weights_;
  std::array<std::vector<double>, kCachedSize + 1> cached_;
};

/// The smallest eigenvalue of the circulant: the closed form of the spectral bound for one face
/// size, so that the limit-mask matrix of any closed mesh has its spectrum in
/// [min over face sizes, 1].
[[nodiscard]] double smallest_face_eigenvalue(Weights weights, std::int32_t m);

}  // namespace planish
