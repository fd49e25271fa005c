// Based on: F. Cazals, M. Pouget, "Estimating Differential Quantities Using Polynomial Fitting of
// Osculating Jets", 2003: a truncated Taylor expansion of the height over the plane of the
// principal components, here of degree 2.
#include "planish/reconstruct/smooth_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {
namespace {

constexpr int kTerms = 6;  // 1, x, y, x^2, xy, y^2
constexpr std::size_t kSmoothGrain = 256;

using Terms = std::array<double, kTerms>;

Terms terms_at(double x, double y) { return {1, x, y, x * x, x * y, y * y}; }

// Eigenvectors of a symmetric matrix as columns, by cyclic Jacobi rotations; the eigenvalues stay
// on the diagonal of `matrix`.
glm::dmat3 eigenvectors(glm::dmat3& matrix) {
  constexpr int kSweeps = 12;
  glm::dmat3 vectors(1.0);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (matrix[p][q] == 0) continue;
        const double theta = (matrix[q][q] - matrix[p][p]) / (2 * matrix[p][q]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1 / std::hypot(t, 1.0), s = t * c;
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

// Solves a symmetric positive definite system by Cholesky's factorisation; false if it is
// singular to working precision.
bool solve(std::array<Terms, kTerms>& matrix, Terms& right) {
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
  for (int i = 0; i < kTerms; ++i) {
    for (int k = 0; k < i; ++k) right[i] -= matrix[i][k] * right[k];
    right[i] /= matrix[i][i];
  }
  for (int i = kTerms - 1; i >= 0; --i) {
    for (int k = i + 1; k < kTerms; ++k) right[i] -= matrix[k][i] * right[k];
    right[i] /= matrix[i][i];
  }
  return true;
}

struct LocalFit {
  bool stable = false;
  glm::dvec3 offset{0.0};  // from the point to the fitted surface, along its plane's normal
  double deviation = 0;    // standard deviation of the neighbours' heights about the fit
};

LocalFit fit_at(const glm::dvec3& point, std::span<const glm::dvec3> points,
                std::span<const Neighbour> neighbours) {
  const auto count = static_cast<double>(neighbours.size());
  const double radius = std::sqrt(neighbours.back().squared_distance);
  if (neighbours.size() <= kTerms || !(radius > 0)) return {};
  glm::dvec3 mean(0.0);
  for (const Neighbour& n : neighbours) mean += (points[n.index] - point) / radius;
  mean /= count;
  glm::dmat3 covariance(0.0);
  for (const Neighbour& n : neighbours) {
    const glm::dvec3 d = (points[n.index] - point) / radius - mean;
    covariance += glm::outerProduct(d, d);
  }
  const glm::dmat3 axes = eigenvectors(covariance);
  std::array<int, 3> order = {0, 1, 2};
  std::ranges::sort(order, [&](int a, int b) { return covariance[a][a] > covariance[b][b]; });
  const glm::dvec3 e1 = axes[order[0]], e2 = axes[order[1]], normal = axes[order[2]];

  std::array<Terms, kTerms> matrix{};
  Terms solution{};
  for (const Neighbour& n : neighbours) {
    const glm::dvec3 d = (points[n.index] - point) / radius;
    const Terms terms = terms_at(glm::dot(d, e1), glm::dot(d, e2));
    for (int i = 0; i < kTerms; ++i) {
      solution[i] += terms[i] * glm::dot(d, normal);
      for (int j = 0; j < kTerms; ++j) matrix[i][j] += terms[i] * terms[j];
    }
  }
  if (!solve(matrix, solution)) return {};
  double squares = 0;
  for (const Neighbour& n : neighbours) {
    const glm::dvec3 d = (points[n.index] - point) / radius;
    const Terms terms = terms_at(glm::dot(d, e1), glm::dot(d, e2));
    double height = 0;
    for (int i = 0; i < kTerms; ++i) height += solution[i] * terms[i];
    squares += (height - glm::dot(d, normal)) * (height - glm::dot(d, normal));
  }
  // The point is the frame's origin, where only the constant term is left.
  return {.stable = std::abs(solution[0]) < 1,
          .offset = radius * solution[0] * normal,
          .deviation = radius * std::sqrt(squares / (count - kTerms))};
}

LocalFit fit_at(std::int32_t index, std::span<const glm::dvec3> points, const PointTree& tree) {
  std::array<Neighbour, kFitNeighbours> nearest;
  const std::size_t found = tree.find_nearest(points[index], nearest);
  return fit_at(points[index], points, std::span(nearest).first(found));
}

}  // namespace

std::vector<glm::dvec3> smooth_points(std::span<const glm::dvec3> points, std::int32_t rounds,
                                      const Callbacks& callbacks) {
  const HostScope host(callbacks);
  std::vector<glm::dvec3> current(points.begin(), points.end());
  std::vector<glm::dvec3> next(current);
  for (std::int32_t round = 0; round < rounds && !points.empty(); ++round) {
    const PointTree tree(current);
    LoopProgress progress(callbacks, "smooth", (round + 0.1) / rounds, (round + 1.0) / rounds,
                          std::ssize(current));
    parallel_for(current.size(), kSmoothGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const LocalFit fit = fit_at(static_cast<std::int32_t>(i), current, tree);
        next[i] = fit.stable ? current[i] + fit.offset : current[i];
      }
      progress.add(static_cast<std::int64_t>(end - begin));
    });
    std::swap(current, next);
  }
  if (rounds > 0) tell(callbacks, "smooth", 1.0);
  return current;
}

double measure_noise(std::span<const glm::dvec3> points, std::int32_t sample_count) {
  if (points.empty() || sample_count < 1) return 0;
  const PointTree tree(points);
  const std::size_t stride = (points.size() - 1) / static_cast<std::size_t>(sample_count) + 1;
  std::vector<double> deviations;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const LocalFit fit = fit_at(static_cast<std::int32_t>(i), points, tree);
    if (fit.stable) deviations.push_back(fit.deviation);
  }
  if (deviations.empty()) return 0;
  const auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
  std::ranges::nth_element(deviations, middle);
  return *middle;
}

}  // namespace planish
