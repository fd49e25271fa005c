// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/points/cgal_alone.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>
#include <iterator>

namespace planish::bench {

std::vector<Triangle> mesh_by_cgal_alone(std::span<const glm::dvec3> points) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> sites;
  sites.reserve(points.size());
  for (const glm::dvec3& p : points) sites.emplace_back(p.x, p.y, p.z);
  std::vector<std::array<std::size_t, 3>> facets;
  CGAL::advancing_front_surface_reconstruction(sites.begin(), sites.end(),
                                               std::back_inserter(facets));
  std::vector<Triangle> triangles;
  triangles.reserve(facets.size());
  for (const auto& f : facets)
    triangles.push_back({static_cast<std::int32_t>(f[0]), static_cast<std::int32_t>(f[1]),
                         static_cast<std::int32_t>(f[2])});
  return triangles;
}

}  // namespace planish::bench
