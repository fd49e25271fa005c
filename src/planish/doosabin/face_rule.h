#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace planish {

/// The circulant that makes an m-gon's corner points X_i = sum_j c_m(j-i) P_j.
enum class Weights {
  DooSabin,  ///< Doo & Sabin 1978: bounded curvature everywhere
  Averaged,  ///< the paper, equation (1): average of vertex, centroid and two edge midpoints
};

/// c_m(0..m-1), for m >= 2; sums to 1. m = 2 arises at interior vertices of valence 2.
/// Source: Doo & Sabin 1978; the paper, equation (1).
[[nodiscard]] std::vector<double> face_weights(Weights weights, std::int32_t m);

/// The smallest eigenvalue of the circulant: the closed form of the spectral bound for one face
/// size, so that the limit-mask matrix of any closed mesh has its spectrum in
/// [min over face sizes, 1].
[[nodiscard]] double smallest_face_eigenvalue(Weights weights, std::int32_t m);

}  // namespace planish
