#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The similarity that centres a model and scales its bounding box to unit diagonal:
/// model = centre + diagonal * unit. All solving happens in unit coordinates.
struct Placement {
  glm::dvec3 centre{0.0};
  double diagonal = 1.0;

  [[nodiscard]] glm::dvec3 to_unit(const glm::dvec3& model) const {
    return (model - centre) / diagonal;
  }
  [[nodiscard]] glm::dvec3 to_model(const glm::dvec3& unit) const {
    return centre + diagonal * unit;
  }
};

/// The placement of the vertices that faces name; unused vertices do not count. A mesh whose used
/// vertices coincide gets diagonal 1.
[[nodiscard]] Placement placement_of(const PolygonMesh& mesh);

/// Whether two of the vertices that faces name differ; the bounding box of others has no diagonal.
[[nodiscard]] bool has_extent(const PolygonMesh& mesh);

/// The placement of all these positions.
[[nodiscard]] Placement placement_of(std::span<const glm::dvec3> positions);

}  // namespace planish
