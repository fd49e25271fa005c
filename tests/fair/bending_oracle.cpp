#include "fair/bending_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

namespace planish::test {

using glm::dvec3;
using std::int32_t;

namespace {

constexpr double kShortestPart = 0.001;

struct NetReader {
  const FairTopology& topology;
  std::span<const dvec3> given, normals, offsets;

  int32_t vertex(int32_t index) const {
    return index < topology.corner_count
               ? topology.corner_vertices[index]
               : topology.curve_points[index - topology.corner_count].vertex;
  }
  dvec3 point(int32_t index) const { return given[vertex(index)] + offsets[index]; }
  bool moves(int32_t index) const {
    return index < topology.corner_count && topology.has_polygon(vertex(index));
  }
};

}  // namespace

BendingOracle::BendingOracle(const FairTopology& topology, std::span<const dvec3> given,
                             std::span<const dvec3> normals, std::span<const dvec3> offsets) {
  const NetReader net{topology, given, normals, offsets};
  const int32_t n = topology.corner_count;
  matrix = Eigen::MatrixXd::Zero(2 * n, n);
  values = Eigen::VectorXd::Zero(2 * n);
  for (int32_t f = 0; f < topology.face_count; ++f) {
    const int32_t first = topology.face_offsets[f], m = topology.face_size(f);
    for (int32_t i = 0; i < m; ++i) {
      const int32_t own = first + i, next = first + (i + 1) % m, previous = first + (i + m - 1) % m;
      const int32_t after = topology.corner_ccw[own], before = topology.corner_cw[own];
      const dvec3 area =
          glm::cross(net.point(next) - net.point(after), net.point(previous) - net.point(before)) /
          4.0;
      const dvec3 normal = glm::normalize(area);
      const std::array<std::pair<int32_t, int32_t>, 2> lines{{{next, after}, {previous, before}}};
      for (int line = 0; line < 2; ++line) {
        const auto [far, near] = lines[line];
        const double far_length = glm::distance(net.point(far), net.point(own));
        const double near_length = glm::distance(net.point(near), net.point(own));
        const double whole = far_length + near_length;
        const double part = std::min(far_length, near_length) / whole;
        const double weight =
            std::sqrt(glm::length(area)) * std::clamp(part / kShortestPart - 1, 0.0, 1.0);
        const dvec3 bend = (net.point(far) - net.point(own)) / far_length -
                           (net.point(own) - net.point(near)) / near_length;
        const int32_t row = 2 * own + line;
        values[row] = weight * 2 / whole * glm::dot(normal, bend);
        const std::map<int32_t, double> factors{{far, 1 / far_length},
                                                {near, 1 / near_length},
                                                {own, -1 / far_length - 1 / near_length}};
        for (const auto& [index, factor] : factors) {
          if (!net.moves(index)) continue;
          matrix(row, index) =
              weight * 2 / whole * factor * glm::dot(normal, normals[net.vertex(index)]);
        }
      }
    }
  }

  std::vector<Eigen::VectorXd> sums;
  for (int32_t v = 0; v < topology.vertex_count; ++v) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
    for (int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
      sum[topology.ring_corners[i]] = 1;
      if (topology.has_polygon(v)) continue;
      sums.push_back(sum);  // each by itself
      sum.setZero();
    }
    if (topology.has_polygon(v)) sums.push_back(sum);
  }
  constraints.resize(static_cast<Eigen::Index>(sums.size()), n);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    constraints.row(static_cast<Eigen::Index>(i)) = sums[i].transpose();
  }
}

Eigen::VectorXd BendingOracle::minimiser() const {
  const Eigen::Index n = matrix.cols(), m = constraints.rows();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + m, n + m);
  system.topLeftCorner(n, n) = matrix.transpose() * matrix;
  system.topRightCorner(n, m) = constraints.transpose();
  system.bottomLeftCorner(m, n) = constraints;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + m);
  right.head(n) = -matrix.transpose() * values;
  return system.completeOrthogonalDecomposition().solve(right).head(n);
}

}  // namespace planish::test
