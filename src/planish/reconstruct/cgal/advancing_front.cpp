// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: D. Cohen-Steiner, F. Da, "A Greedy Delaunay-based Surface Reconstruction Algorithm",
// 2004, as built in CGAL's package Advancing_front_surface_reconstruction.
#include "planish/reconstruct/cgal/advancing_front.h"

#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/reconstruct/bounding_cube.h"

namespace planish {
namespace {

// Share of the time that the Delaunay triangulation takes, and how often the front asks for a
// priority per point: both only for progress.
constexpr double kTriangulationShare = 0.55;
constexpr double kQuestionsPerPoint = 70.0;
constexpr std::int64_t kQuestionsPerReport = 1 << 16;
constexpr std::size_t kPointsPerReport = 1 << 13;

constexpr double kRadiusRatioBound = 5.0;  // CGAL's defaults
constexpr double kBeta = 0.52;

// The default priority of CGAL; the only place in which the front can be watched and stopped.
struct WatchedPriority {
  const Callbacks* callbacks;
  std::int64_t* questions;
  double expected;

  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, const int& index) const {
    if (++*questions % kQuestionsPerReport == 0) {
      check_stop();
      const double done = std::min(static_cast<double>(*questions) / expected, 1.0);
      callbacks->report("mesh", kTriangulationShare + (1 - kTriangulationShare) * done);
    }
    return front.smallest_radius_delaunay_sphere(cell, index);
  }
};

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Advancing_front_surface_reconstruction_vertex_base_3<Kernel>;
using CellBase = CGAL::Advancing_front_surface_reconstruction_cell_base_3<Kernel>;
using Delaunay =
    CGAL::Delaunay_triangulation_3<Kernel,
                                   CGAL::Triangulation_data_structure_3<VertexBase, CellBase>>;
using Front = CGAL::Advancing_front_surface_reconstruction<Delaunay, WatchedPriority>;
using Point = Kernel::Point_3;

// CGAL takes triangles for degenerate where a determinant, of the fourth power of lengths, is below
// 1e-21: clouds of 1e-4 across fell apart, and those of 1e-6 had no surface. By a power of two
// nothing else changes.
double scale_of(std::span<const glm::dvec3> points) {
  constexpr int kExponent = 10;  // of the largest extent
  const double largest = bounding_cube(points).side;
  if (largest == 0) return 1;
  return std::ldexp(1.0, std::clamp(kExponent - std::ilogb(largest), -1000, 1000));
}

// Inserted along a space-filling curve, as CGAL does for a range, but in slices.
void triangulate(std::span<const glm::dvec3> points, Delaunay& delaunay,
                 const Callbacks& callbacks) {
  if (points.empty()) return;  // CGAL's property map takes the first site's address
  std::vector<Point> sites;
  sites.reserve(points.size());
  const double scale = scale_of(points);
  for (const glm::dvec3& p : points) sites.emplace_back(scale * p.x, scale * p.y, scale * p.z);
  std::vector<std::size_t> order(sites.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  using Map = CGAL::Pointer_property_map<Point>::const_type;
  CGAL::spatial_sort(order.begin(), order.end(),
                     CGAL::Spatial_sort_traits_adapter_3<Kernel, Map>(
                         CGAL::make_property_map(std::as_const(sites))));
  Delaunay::Cell_handle hint;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kPointsPerReport == 0) {
      check_stop();
      callbacks.report("mesh", kTriangulationShare * static_cast<double>(i) / order.size());
    }
    const Delaunay::Vertex_handle vertex = delaunay.insert(sites[order[i]], hint);
    vertex->info() = order[i];
    hint = vertex->cell();
  }
}

}  // namespace

std::vector<Triangle> mesh_by_advancing_front(std::span<const glm::dvec3> points,
                                              const Callbacks& callbacks) {
  const HostScope host(callbacks);
  Delaunay delaunay;
  triangulate(points, delaunay, callbacks);
  if (delaunay.dimension() < 2)
    throw Error(ErrorCode::UnusableMesh,
                std::to_string(points.size()) +
                    " points span no surface; at least three that are not on a line are needed");
  std::int64_t questions = 0;
  Front front(delaunay,
              WatchedPriority{.callbacks = &callbacks,
                              .questions = &questions,
                              .expected = kQuestionsPerPoint * static_cast<double>(points.size())});
  front.run(kRadiusRatioBound, kBeta);

  std::vector<Triangle> triangles;
  const auto& surface = front.triangulation_data_structure_2();
  for (auto face = surface.faces_begin(); face != surface.faces_end(); ++face) {
    if (!face->is_on_surface()) continue;
    Triangle& triangle = triangles.emplace_back();
    for (int corner = 0; corner < 3; ++corner)
      triangle[corner] = static_cast<std::int32_t>(face->vertex(corner)->vertex_3()->info());
  }
  // CGAL's order follows addresses in memory; ours does not.
  for (Triangle& t : triangles) std::ranges::rotate(t, std::ranges::min_element(t));
  std::ranges::sort(triangles);
  callbacks.report("mesh", 1.0);
  return triangles;
}

}  // namespace planish
