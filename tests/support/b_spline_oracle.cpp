#include "support/b_spline_oracle.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace planish::test {

using glm::dvec3;

namespace {

// The quadratic B-spline of integer knots shifted to be centred on 0.
double basis(double t) {
  t = std::abs(t);
  if (t <= 0.5) return 0.75 - t * t;
  return t < 1.5 ? (1.5 - t) * (1.5 - t) / 2 : 0;
}
double basis_slope(double t) {
  if (std::abs(t) <= 0.5) return -2 * t;
  return std::abs(t) < 1.5 ? std::copysign(1.5 - std::abs(t), -t) : 0;
}

}  // namespace

BSplineOracle::BSplineOracle(const PolygonMesh& grid_mesh, int columns, int rows)
    : columns_(columns), rows_(rows) {
  const auto vertex = [&](int i, int j) { return grid_mesh.positions[j * (columns + 1) + i]; };
  const auto extended_row = [&](int i, int j) {
    if (i < 0) return 2.0 * vertex(0, j) - vertex(1, j);
    if (i > columns) return 2.0 * vertex(columns, j) - vertex(columns - 1, j);
    return vertex(i, j);
  };
  for (int j = -1; j <= rows + 1; ++j) {
    for (int i = -1; i <= columns + 1; ++i) {
      net_.push_back(j < 0      ? 2.0 * extended_row(i, 0) - extended_row(i, 1)
                     : j > rows ? 2.0 * extended_row(i, rows) - extended_row(i, rows - 1)
                                : extended_row(i, j));
    }
  }
}

dvec3 BSplineOracle::control(int i, int j) const { return net_[(j + 1) * (columns_ + 3) + i + 1]; }

template <class BasisU, class BasisV>
dvec3 BSplineOracle::sum(const BasisU& basis_u, const BasisV& basis_v) const {
  dvec3 result(0.0);
  for (int j = -1; j <= rows_ + 1; ++j) {
    for (int i = -1; i <= columns_ + 1; ++i) result += basis_u(i) * basis_v(j) * control(i, j);
  }
  return result;
}

dvec3 BSplineOracle::point(double u, double v) const {
  return sum([&](int i) { return basis(u - i); }, [&](int j) { return basis(v - j); });
}

dvec3 BSplineOracle::normal(double u, double v) const {
  const dvec3 du =
      sum([&](int i) { return basis_slope(u - i); }, [&](int j) { return basis(v - j); });
  const dvec3 dv =
      sum([&](int i) { return basis(u - i); }, [&](int j) { return basis_slope(v - j); });
  return glm::normalize(glm::cross(du, dv));
}

}  // namespace planish::test
