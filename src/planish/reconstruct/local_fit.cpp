// Based on: F. Cazals, M. Pouget, "Estimating Differential Quantities Using Polynomial Fitting of
// Osculating Jets", 2003: a truncated Taylor expansion of the height over the plane of the
// principal components, here of degree 2; and on R. D. Cook, "Detection of Influential Observation
// in Linear Regression", 1977: residuals without refitting, by leverages.
#include "planish/reconstruct/local_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "planish/core/eigenvectors.h"

namespace planish {
namespace {

constexpr int kTerms = 6;  // 1, x, y, x^2, xy, y^2

// 1 - leverage below which a field passes through the point whatever the others do.
constexpr double kLeastRest = 1e-3;

using Terms = std::array<double, kTerms>;

Terms terms_at(double x, double y) { return {1, x, y, x * x, x * y, y * y}; }

// Cholesky's factor of a symmetric positive definite matrix in its lower half; false if it is
// singular to working precision.
bool factorise(std::array<Terms, kTerms>& matrix) {
  constexpr double kSmallestPivot = 1e-12;  // entries are of order 1 by scaling
  for (int i = 0; i < kTerms; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = matrix[i][j];
      for (int k = 0; k < j; ++k) sum -= matrix[i][k] * matrix[j][k];
      if (i == j) {
        if (!(sum > kSmallestPivot)) return false;
        matrix[i][i] = std::sqrt(sum);
      } else {
        matrix[i][j] = sum / matrix[j][j];
      }
    }
  }
  return true;
}

Terms solved(const std::array<Terms, kTerms>& factor, Terms right) {
  for (int i = 0; i < kTerms; ++i) {
    for (int k = 0; k < i; ++k) right[i] -= factor[i][k] * right[k];
    right[i] /= factor[i][i];
  }
  for (int i = kTerms - 1; i >= 0; --i) {
    for (int k = i + 1; k < kTerms; ++k) right[i] -= factor[k][i] * right[k];
    right[i] /= factor[i][i];
  }
  return right;
}

template <class Points>
LocalFit fit_at(const glm::dvec3& point, const Points& points,
                std::span<const Neighbour> neighbours) {
  const auto count = static_cast<double>(neighbours.size());
  const double radius = std::sqrt(neighbours.back().squared_distance);
  if (neighbours.size() <= kTerms || !(radius > 0)) return {};
  std::array<glm::dvec3, kFitNeighbours> offsets;  // from the point, in radii
  const auto nearby = std::span(offsets).first(neighbours.size());
  glm::dvec3 mean(0.0);
  for (std::size_t i = 0; i < nearby.size(); ++i)
    mean += nearby[i] = (points[neighbours[i].index] - point) / radius;
  mean /= count;
  glm::dmat3 covariance(0.0);
  for (const glm::dvec3& offset : nearby) {
    const glm::dvec3 d = offset - mean;
    covariance += glm::outerProduct(d, d);
  }
  const glm::dmat3 axes = eigenvectors(covariance);
  std::array<int, 3> order = {0, 1, 2};
  std::ranges::sort(order, [&](int a, int b) { return covariance[a][a] > covariance[b][b]; });
  const glm::dvec3 e1 = axes[order[0]], e2 = axes[order[1]], normal = axes[order[2]];

  std::array<Terms, kTerms> matrix{};
  Terms solution{};
  for (const glm::dvec3& d : nearby) {
    const Terms terms = terms_at(glm::dot(d, e1), glm::dot(d, e2));
    for (int i = 0; i < kTerms; ++i) {
      solution[i] += terms[i] * glm::dot(d, normal);
      for (int j = 0; j < kTerms; ++j) matrix[i][j] += terms[i] * terms[j];
    }
  }
  if (!factorise(matrix)) return {};
  solution = solved(matrix, solution);
  double squares = 0;
  for (const glm::dvec3& d : nearby) {
    const Terms terms = terms_at(glm::dot(d, e1), glm::dot(d, e2));
    double height = 0;
    for (int i = 0; i < kTerms; ++i) height += solution[i] * terms[i];
    squares += (height - glm::dot(d, normal)) * (height - glm::dot(d, normal));
  }
  // The point is the frame's origin, where only the constant term is left; so its leverage, the
  // share of its own height in its fitted one, is the first entry of the inverse.
  const double leverage = solved(matrix, {1})[0];
  const double rest = 1 - leverage;
  const double degrees = count - kTerms;
  LocalFit fit{.stable = std::abs(solution[0]) < 1,
               .normal = normal,
               .offset = radius * solution[0] * normal,
               .deviation = radius * std::sqrt(squares / degrees),
               .spread = covariance[order[1]][order[1]] / covariance[order[0]][order[0]]};
  if (rest > kLeastRest && degrees > 1) {
    const double without = std::max(squares - solution[0] * solution[0] / rest, 0.0);
    fit.distance = radius * std::abs(solution[0]) / rest;
    fit.others_deviation = radius * std::sqrt(without / ((degrees - 1) * rest));
  }
  return fit;
}

}  // namespace

LocalFit fit_at(std::int32_t index, std::span<const glm::dvec3> points, const PointTree& tree,
                std::int32_t count) {
  std::array<Neighbour, kFitNeighbours> nearest;
  const auto wanted = std::span(nearest).first(static_cast<std::size_t>(count));
  const std::size_t found = tree.find_nearest(points[index], wanted);
  return fit_at(points[index], points, wanted.first(found));
}

LocalFit fit_at(std::int32_t index, const OrderedPoints& points, const OrderedTree& tree,
                std::int32_t count) {
  std::array<Neighbour, kFitNeighbours> nearest;
  const auto wanted = std::span(nearest).first(static_cast<std::size_t>(count));
  const glm::dvec3 point = points[index];
  const std::size_t found = tree.find_nearest(point, index, wanted);
  return fit_at(point, points, wanted.first(found));
}

}  // namespace planish
