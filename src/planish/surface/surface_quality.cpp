// Bending: the Dirichlet energy of the unit normals, linear on triangles: half the sum over edges
// of cot(opposite angle) |difference|^2 (Pinkall & Polthier 1993).
#include "planish/surface/surface_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "planish/core/stop.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/folded_edges.h"
#include "planish/surface/folded_places.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/quad_figures.h"

namespace planish {

namespace {

double triangle_bending(const SurfaceMesh& surface, const std::array<std::int32_t, 3>& corners) {
  std::array<glm::dvec3, 3> edge, turn;  // each opposite to its corner
  double perimeter = 0;
  for (int k = 0; k < 3; ++k) {
    const std::int32_t a = corners[(k + 1) % 3], b = corners[(k + 2) % 3];
    edge[k] = surface.positions[b] - surface.positions[a];
    turn[k] = glm::dvec3(surface.normals[b]) - glm::dvec3(surface.normals[a]);
    perimeter += glm::length(edge[k]);
  }
  const double double_area = glm::length(glm::cross(edge[0], edge[1]));
  if (double_area <= kThinTriangle * perimeter * perimeter) return 0;
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double cotangent = -glm::dot(edge[(k + 1) % 3], edge[(k + 2) % 3]) / double_area;
    sum += 0.5 * cotangent * glm::dot(turn[k], turn[k]);
  }
  return sum;
}

// Quads are cut along their shorter diagonal, other polygons into a fan.
double face_bending(const SurfaceMesh& surface, std::span<const std::int32_t> face) {
  std::size_t first = 0;
  if (face.size() == 4) {
    const glm::dvec3 even = surface.positions[face[2]] - surface.positions[face[0]];
    const glm::dvec3 odd = surface.positions[face[3]] - surface.positions[face[1]];
    if (glm::dot(odd, odd) < glm::dot(even, even)) first = 1;
  }
  double sum = 0;
  const std::size_t m = face.size();
  for (std::size_t i = 1; i + 1 < m; ++i) {
    sum +=
        triangle_bending(surface, {face[first], face[(first + i) % m], face[(first + i + 1) % m]});
  }
  return sum;
}

// `ancestor`: one per face, or empty: no places are wanted.
SurfaceQuality measured_quality(const SurfaceMesh& surface, const ReferenceNormal& reference,
                                std::span<const std::uint8_t> is_beside_folds,
                                std::span<const std::int32_t> ancestor) {
  SurfaceQuality quality;
  FoldedPlaces places;
  double whole = 0, sum_of_squares = 0;
  StopCheck stop;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    stop.step();
    const auto vertices = surface.face(f);
    const double share = glm::length(area_vector(surface.positions, vertices)) /
                         static_cast<double>(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const glm::dvec3 normal(surface.normals[vertices[i]]);
      const glm::dvec3 wanted = reference(f, static_cast<std::int32_t>(i));
      // atan2 keeps its digits where the angle is small.
      const double angle =
          std::atan2(glm::length(glm::cross(normal, wanted)), glm::dot(normal, wanted)) * 180 /
          std::numbers::pi;
      whole += share;
      if (glm::dot(normal, wanted) < 0) {
        const bool is_elsewhere = is_beside_folds.empty() || is_beside_folds[f] == 0;
        quality.folded_area += share;
        if (is_elsewhere) quality.folded_area_elsewhere += share;
        if (!ancestor.empty())
          places.add({ancestor[f], surface.positions[vertices[i]]}, is_elsewhere);
      }
      sum_of_squares += share * angle * angle;
      quality.max_normal_deviation = std::max(quality.max_normal_deviation, angle);
    }
    quality.bending += face_bending(surface, vertices);
  }
  if (whole > 0) {
    quality.folded_area /= whole;
    quality.folded_area_elsewhere /= whole;
    quality.rms_normal_deviation = std::sqrt(sum_of_squares / whole);
  }
  quality.folded_places = places.take();
  return quality;
}

}  // namespace

SurfaceQuality surface_quality(const SurfaceMesh& surface, const ReferenceNormal& reference,
                               std::span<const std::uint8_t> is_beside_folds) {
  return measured_quality(surface, reference, is_beside_folds, {});
}

std::vector<std::uint8_t> beside_folds(const SurfaceMesh& surface, const PolygonMesh& input) {
  const FoldedEdges folds = folded_edges(input);
  const std::vector<std::int32_t> ancestor = ancestor_faces(surface, input);
  std::vector<std::uint8_t> result(ancestor.size());
  std::transform(ancestor.begin(), ancestor.end(), result.begin(),
                 [&](std::int32_t face) { return folds.is_beside[face]; });
  return result;
}

SurfaceQuality surface_quality(const SurfaceMesh& surface, const PolygonMesh& input) {
  const std::vector<std::int32_t> ancestor = ancestor_faces(surface, input);
  glm::dvec3 normal(0.0);
  return measured_quality(
      surface,
      [&](std::int64_t face, std::int32_t corner) {
        if (corner == 0) normal = area_vector(input.positions, input.face(ancestor[face]));
        return normal;
      },
      beside_folds(surface, input), ancestor);
}

}  // namespace planish
