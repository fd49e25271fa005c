#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "planish/mesh/placement.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_numbering.h"
#include "planish/patches/patch_plan.h"

namespace planish {

/// The unit normal of the output's facets around a row, hidden ones included, weighted by area; +Z
/// where they have none. For rows whose tangents are parallel.
class FacetNormals {
 public:
  FacetNormals(const PatchMesh& mesh, const PatchNumbering& numbering, const PatchClasses& classes,
               const double* state, const Placement& placement)
      : mesh_(mesh),
        numbering_(numbering),
        classes_(classes),
        state_(state),
        placement_(placement) {}

  [[nodiscard]] glm::vec3 at(const PatchTile& tile, std::int64_t row) const;

 private:
  struct Sample {
    std::int32_t corner, a, b;
  };
  [[nodiscard]] std::vector<Sample> samples_of(const PatchTile& tile, std::int64_t row) const;
  [[nodiscard]] glm::dvec3 point(const PatchPlace& place, std::int32_t sample) const;
  [[nodiscard]] glm::dvec3 cells_around(const Sample& sample) const;
  [[nodiscard]] glm::dvec3 polygon(std::int32_t face) const;

  const PatchMesh& mesh_;
  const PatchNumbering& numbering_;
  const PatchClasses& classes_;
  const double* state_;
  const Placement& placement_;
};

}  // namespace planish
