// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/nearest/cgal_tree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace planish::bench {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using CgalTriangle = Kernel::Triangle_3;
using Triangles = std::vector<CgalTriangle>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 cgal_point(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

}  // namespace

struct CgalTree::Parts {
  Triangles triangles;
  Tree tree;
};

CgalTree::CgalTree(const SurfaceMesh& surface) : parts_(std::make_unique<Parts>()) {
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    const auto at = [&](std::size_t i) { return cgal_point(surface.positions[face[i]]); };
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      parts_->triangles.emplace_back(at(0), at(i), at(i + 1));
  }
  parts_->tree.insert(parts_->triangles.begin(), parts_->triangles.end());
  parts_->tree.build();
  parts_->tree.accelerate_distance_queries();
}

CgalTree::~CgalTree() = default;

void CgalTree::distances(std::span<const glm::dvec3> points, std::span<double> result) const {
  for (std::size_t i = 0; i < points.size(); ++i)
    result[i] = std::sqrt(parts_->tree.squared_distance(cgal_point(points[i])));
}

}  // namespace planish::bench
