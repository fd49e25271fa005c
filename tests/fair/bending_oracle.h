#pragma once

#include <Eigen/Dense>
#include <glm/vec3.hpp>
#include <span>

#include "planish/fair/fair_topology.h"

namespace planish::test {

/// The linearised bending of a net as dense matrices, written from its formula: rows of lines
/// times heights of corners. Slow on purpose.
struct BendingOracle {
  BendingOracle(const FairTopology& topology, std::span<const glm::dvec3> given,
                std::span<const glm::dvec3> normals, std::span<const glm::dvec3> offsets);

  [[nodiscard]] double energy(const Eigen::VectorXd& heights) const {
    return (values + matrix * heights).squaredNorm();
  }
  /// The heights of least energy among those whose sum over every vertex's polygon is 0; corners
  /// that must stay have 0.
  [[nodiscard]] Eigen::VectorXd minimiser() const;

  Eigen::MatrixXd matrix;       ///< 2 x corners rows, one column a corner
  Eigen::VectorXd values;       ///< at heights 0
  Eigen::MatrixXd constraints;  ///< one row a vertex: the sum over its polygon, or each corner
};

}  // namespace planish::test
