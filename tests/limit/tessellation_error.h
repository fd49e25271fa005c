#pragma once

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <tuple>
#include <vector>

#include "limit/limit_case.h"
#include "planish/queries/surface_queries.h"
#include "planish/reconstruct/spatial_search.h"

namespace planish::test {

/// Faces of a tessellation as triangles; quads are cut from their first corner.
inline std::vector<Triangle> triangles_of_surface(const SurfaceMesh& surface) {
  std::vector<Triangle> triangles;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      triangles.push_back({face[0], face[i], face[i + 1]});
  }
  return triangles;
}

/// Largest distances between triangles and a surface, in parts of the diagonal: of about so many
/// places on triangles by closest points, and of ten times as many random places of the surface.
struct TessellationError {
  double to_surface = 0, to_triangles = 0;
  [[nodiscard]] double largest() const { return std::max(to_surface, to_triangles); }
};

inline TessellationError tessellation_error(const LimitCase& c, const SurfaceQueries& queries,
                                            const SurfaceMesh& surface, std::size_t places) {
  const std::vector<Triangle> triangles = triangles_of_surface(surface);
  const std::size_t step = std::max<std::size_t>(1, 4 * triangles.size() / places);
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < 4 * triangles.size(); i += step) {
    const Triangle& t = triangles[i / 4];
    const auto at = [&](std::size_t k) { return surface.positions[t[k % 3]]; };
    points.push_back(i % 4 == 3 ? (at(0) + at(1) + at(2)) / 3.0
                                : 0.5 * (at(i % 4) + at(i % 4 + 1)));
  }
  std::vector<ClosestPoint> closest(points.size());
  queries.closest(points, closest);
  TessellationError error;
  for (const ClosestPoint& p : closest) error.to_surface = std::max(error.to_surface, p.distance);
  std::mt19937 random(17);
  std::vector<SurfaceParameter> at;
  while (at.size() < 10 * places) {
    const SurfaceParameter place = c.any_place(random);
    const auto hidden = c.surface->hidden();
    if (hidden.empty() || hidden[place.face] == 0) at.push_back(place);
  }
  std::vector<SurfacePoint> on(at.size());
  c.limit.evaluate(at, on);
  points.clear();
  for (const SurfacePoint& p : on) points.push_back(p.position);
  error.to_triangles = measure_distances(points, surface.positions, triangles).max;
  const double diagonal = c.surface->placement().diagonal;
  return {error.to_surface / diagonal, error.to_triangles / diagonal};
}

/// How triangles meet.
struct Joints {
  std::int64_t vertices = 0, edges = 0, triangles = 0, boundary_edges = 0;
  std::int64_t bad_edges = 0;      ///< met by more than two, or twice in one direction
  std::int64_t bad_triangles = 0;  ///< with a corner twice
  [[nodiscard]] std::int64_t euler() const { return vertices - edges + triangles; }
};

/// `joined`: vertices in one place count once.
inline Joints joints_of(const SurfaceMesh& surface, bool joined) {
  std::map<std::tuple<double, double, double>, std::int32_t> numbers;
  std::vector<std::int32_t> welded;
  for (const glm::dvec3& p : surface.positions) {
    const auto next = static_cast<std::int32_t>(joined ? numbers.size() : welded.size());
    welded.push_back(joined ? numbers.try_emplace({p.x, p.y, p.z}, next).first->second : next);
  }
  Joints joints;
  std::map<std::pair<std::int32_t, std::int32_t>, std::array<int, 2>> edges;
  std::set<std::int32_t> used;
  for (const Triangle& t : triangles_of_surface(surface)) {
    ++joints.triangles;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = welded[t[k]];
      const std::int32_t b = welded[t[(k + 1) % 3]];
      used.insert(a);
      if (a == b) ++joints.bad_triangles;
      ++edges[std::minmax(a, b)][a < b ? 0 : 1];
    }
  }
  joints.vertices = static_cast<std::int64_t>(used.size());
  joints.edges = static_cast<std::int64_t>(edges.size());
  for (const auto& [ends, count] : edges) {
    if (count[0] > 1 || count[1] > 1) ++joints.bad_edges;
    if (count[0] + count[1] == 1) ++joints.boundary_edges;
  }
  return joints;
}

}  // namespace planish::test
