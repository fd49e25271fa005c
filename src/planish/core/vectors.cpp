#include "planish/core/vectors.h"

#include <cmath>
#include <glm/matrix.hpp>

#include "planish/core/portable_math.h"

namespace planish {

glm::dmat3 eigenvectors(glm::dmat3& matrix) {
  constexpr int kSweeps = 12;
  constexpr double kCoupling = 1e-18;  // far below rounding
  glm::dmat3 vectors(1.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double coupling =
        std::abs(matrix[0][1]) + std::abs(matrix[0][2]) + std::abs(matrix[1][2]);
    if (coupling <= kCoupling * (matrix[0][0] + matrix[1][1] + matrix[2][2])) break;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (matrix[p][q] == 0) continue;
        const double theta = (matrix[q][q] - matrix[p][p]) / (2 * matrix[p][q]);
        const double t =
            std::copysign(1.0, theta) / (std::abs(theta) + portable::hypot(theta, 1.0));
        const double c = 1 / portable::hypot(t, 1.0), s = t * c;
        glm::dmat3 rotation(1.0);
        rotation[p][p] = rotation[q][q] = c;
        rotation[p][q] = -s;
        rotation[q][p] = s;
        matrix = glm::transpose(rotation) * matrix * rotation;
        vectors = vectors * rotation;
      }
    }
  }
  return vectors;
}

}  // namespace planish
