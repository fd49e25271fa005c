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

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/reconstruct/point_tree.h"

namespace planish {
namespace {

// Shares of the time when a part is done: the triangulation, the look for the first triangle, the
// front, and CGAL's list of its triangles, which are then turned to one side.
constexpr double kTriangulated = 0.36, kBegun = 0.65, kGrown = 0.84, kListed = 0.94;
constexpr std::size_t kPointsPerReport = 1 << 13;
constexpr std::int64_t kLooksPerReport = 1 << 16;

constexpr double kRadiusRatioBound = 5.0;  // CGAL's defaults
constexpr double kBeta = 0.52;

// How far the front of this thread is. CGAL does not say, but it asks for the priority of every
// facet before the first triangle, selects one triangle after another, twice as many as points on a
// closed surface, and looks at both sides of every facet to list them.
class FrontWatch {
 public:
  FrontWatch(const Callbacks& callbacks, std::size_t points, std::size_t facets)
      : callbacks_(callbacks),
        expected_(2 * static_cast<double>(points)),
        facets_(static_cast<double>(facets)) {
    of_thread = this;
  }
  ~FrontWatch() { of_thread = nullptr; }
  FrontWatch(const FrontWatch&) = delete;
  FrontWatch& operator=(const FrontWatch&) = delete;

  void see_priority() {
    ++asked_;
    look();
  }
  void see_selected() {
    ++selected_;
    listed_ = 0;
    look();
  }
  void see_listed() {
    ++listed_;
    look();
  }

  static inline thread_local FrontWatch* of_thread = nullptr;

 private:
  void look() {
    if (++looks_ % kLooksPerReport != 0) return;
    check_stop();
    const auto part = [](std::int64_t count, double all) { return std::min(count / all, 1.0); };
    double done = std::lerp(kTriangulated, kBegun, part(asked_, facets_));
    if (selected_ > 0) {
      const double grown = std::lerp(kBegun, kGrown, part(selected_, expected_));
      done = std::lerp(grown, kListed, part(listed_, 2 * facets_));
    }
    callbacks_.report("mesh", done_ = std::max(done, done_));
  }

  const Callbacks& callbacks_;
  double expected_, facets_, done_ = 0;
  std::int64_t asked_ = 0, selected_ = 0, listed_ = 0, looks_ = 0;
};

// The default priority of CGAL.
struct WatchedPriority {
  template <class Front, class Cell>
  double operator()(const Front& front, Cell& cell, const int& index) const {
    FrontWatch::of_thread->see_priority();
    return front.smallest_radius_delaunay_sphere(cell, index);
  }
};

// CGAL's cell, which hides what the front does with its facets.
template <class Base>
struct WatchedCell : Base {
  template <class Structure>
  struct Rebind_TDS {
    using Other = WatchedCell<typename Base::template Rebind_TDS<Structure>::Other>;
  };
  using Base::Base;

  void select_facet(int index) {
    FrontWatch::of_thread->see_selected();
    Base::select_facet(index);
  }
  bool is_selected_facet(int index) {
    FrontWatch::of_thread->see_listed();
    return Base::is_selected_facet(index);
  }
};

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Advancing_front_surface_reconstruction_vertex_base_3<Kernel>;
using CellBase = WatchedCell<CGAL::Advancing_front_surface_reconstruction_cell_base_3<Kernel>>;
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
      callbacks.report("mesh", kTriangulated * static_cast<double>(i) / order.size());
    }
    const Delaunay::Vertex_handle vertex = delaunay.insert(sites[order[i]], hint);
    vertex->info() = order[i];
    hint = vertex->cell();
  }
}

// In an order of their own: CGAL's follows addresses in memory.
std::vector<Triangle> triangles_of(const Front& front) {
  std::vector<Triangle> triangles;
  const auto& surface = front.triangulation_data_structure_2();
  for (auto face = surface.faces_begin(); face != surface.faces_end(); ++face) {
    if (!face->is_on_surface()) continue;
    Triangle& triangle = triangles.emplace_back();
    for (int corner = 0; corner < 3; ++corner)
      triangle[corner] = static_cast<std::int32_t>(face->vertex(corner)->vertex_3()->info());
  }
  for (Triangle& t : triangles) std::ranges::rotate(t, std::ranges::min_element(t));
  std::ranges::sort(triangles);
  return triangles;
}

}  // namespace

void advance_front(std::span<const glm::dvec3> points, const TakeTriangles& take,
                   const Callbacks& callbacks) {
  const HostScope host(callbacks);
  Delaunay delaunay;
  triangulate(points, delaunay, callbacks);
  if (delaunay.dimension() < 2)
    throw Error(
        ErrorCode::UnusableMesh,
        formatted("{} points span no surface; at least three that are not on a line are needed",
                  points.size()));
  Front front(delaunay);
  // Of four facets a cell has each with a neighbour.
  const FrontWatch watch(callbacks, points.size(), 2 * delaunay.number_of_cells());
  front.run(kRadiusRatioBound, kBeta);
  std::vector<Triangle> triangles = triangles_of(front);
  callbacks.report("mesh", 1.0);
  take(std::move(triangles));
}

std::vector<Triangle> mesh_by_advancing_front(std::span<const glm::dvec3> points,
                                              const Callbacks& callbacks) {
  std::vector<Triangle> triangles;
  const auto take = [&](std::vector<Triangle> made) { triangles = std::move(made); };
  advance_front(points, take, callbacks);
  return triangles;
}

}  // namespace planish
