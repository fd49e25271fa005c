#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// The uniform biquadratic tensor-product B-spline surface of a grid() mesh whose net is extended
/// by one reflected row on every side (2 P_0 - P_1), evaluated from its basis functions. Vertex
/// (i, j) of the grid has parameters (i, j).
class BSplineOracle {
 public:
  BSplineOracle(const PolygonMesh& grid_mesh, int columns, int rows);

  [[nodiscard]] glm::dvec3 point(double u, double v) const;
  [[nodiscard]] glm::dvec3 normal(double u, double v) const;

 private:
  [[nodiscard]] glm::dvec3 control(int i, int j) const;
  template <class BasisU, class BasisV>
  [[nodiscard]] glm::dvec3 sum(const BasisU& basis_u, const BasisV& basis_v) const;

  std::vector<glm::dvec3> net_;  ///< with phantoms, (columns + 3) x (rows + 3)
  int columns_, rows_;
};

}  // namespace planish::test
