#pragma once

#include <glm/mat3x3.hpp>

namespace planish {

/// Eigenvectors of a symmetric matrix as columns, by cyclic Jacobi rotations; the eigenvalues stay
/// on the diagonal of `matrix`.
[[nodiscard]] glm::dmat3 eigenvectors(glm::dmat3& matrix);

}  // namespace planish
