#pragma once

#include <optional>

namespace planish {

/// How far a surface may leave the given vertices, of the diagonal.
struct LeaveWithin {
  double within = 0;
  std::optional<double> noise;  ///< where it was measured

  /// What the given points may be moved by: the solve may leave its points by the tolerance.
  [[nodiscard]] double bound(double tolerance) const { return within - tolerance; }
};
inline constexpr double kMostWithin = 0.1;  ///< is above what may be asked for
/// Of measured noise, what is allowed: normals are best at 1 to 1.5.
inline constexpr double kNoiseBound = 1.25;

}  // namespace planish
