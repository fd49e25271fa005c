#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "planish/surface/surface_quality.h"

namespace planish {

/// The figures of a surface whose faces come one by one; the order decides the last bits.
class QualitySum {
 public:
  /// A face by its corners: positions, unit normals, and the normals that these should be, of any
  /// length, zero where there is none. `is_elsewhere`: it counts in folded_area_elsewhere.
  void add(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
           std::span<const glm::dvec3> wanted, bool is_elsewhere = true);
  /// Of the faces so far; names no places.
  [[nodiscard]] SurfaceQuality result() const;

 private:
  double whole_ = 0, squares_ = 0;
  SurfaceQuality sums_;
};

}  // namespace planish
