// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "planish/surface/surface_mesh.h"

namespace planish::bench {

/// CGAL's AABB tree over a tessellation, quads cut from their first corner.
class CgalTree {
 public:
  explicit CgalTree(const SurfaceMesh& surface);
  ~CgalTree();

  /// From points to the triangles, one after the other.
  void distances(std::span<const glm::dvec3> points, std::span<double> result) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace planish::bench
