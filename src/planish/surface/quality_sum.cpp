// Bending: the Dirichlet energy of the unit normals, linear on triangles: half the sum over edges
// of cot(opposite angle) |difference|^2 (Pinkall & Polthier 1993).
#include "planish/surface/quality_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/mesh/angle_between.h"
#include "planish/surface/quad_figures.h"

namespace planish {
namespace {

struct FaceCorners {
  std::span<const glm::dvec3> positions;
  std::span<const glm::vec3> normals;
};

// As area_vector() has it.
glm::dvec3 area_of(std::span<const glm::dvec3> corners) {
  glm::dvec3 area(0.0);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    area += 0.5 * glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  return area;
}

double triangle_bending(const FaceCorners& face, const std::array<std::size_t, 3>& corners) {
  std::array<glm::dvec3, 3> edge, turn;  // each opposite to its corner
  double perimeter = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t a = corners[(k + 1) % 3], b = corners[(k + 2) % 3];
    edge[k] = face.positions[b] - face.positions[a];
    turn[k] = glm::dvec3(face.normals[b]) - glm::dvec3(face.normals[a]);
    perimeter += glm::length(edge[k]);
  }
  const double double_area = glm::length(glm::cross(edge[0], edge[1]));
  if (double_area <= kThinTriangle * perimeter * perimeter) return 0;
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double cotangent = -glm::dot(edge[(k + 1) % 3], edge[(k + 2) % 3]) / double_area;
    sum += 0.5 * cotangent * glm::dot(turn[k], turn[k]);
  }
  return sum;
}

// Quads are cut along their shorter diagonal, other polygons into a fan.
double face_bending(const FaceCorners& face) {
  const std::size_t m = face.positions.size();
  std::size_t first = 0;
  if (m == 4) {
    const glm::dvec3 even = face.positions[2] - face.positions[0];
    const glm::dvec3 odd = face.positions[3] - face.positions[1];
    if (glm::dot(odd, odd) < glm::dot(even, even)) first = 1;
  }
  double sum = 0;
  for (std::size_t i = 1; i + 1 < m; ++i)
    sum += triangle_bending(face, {first, (first + i) % m, (first + i + 1) % m});
  return sum;
}

}  // namespace

void QualitySum::add(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
                     std::span<const glm::dvec3> wanted, bool is_elsewhere) {
  const double share = glm::length(area_of(positions)) / static_cast<double>(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const glm::dvec3 normal(normals[i]);
    const double angle = angle_between(normal, wanted[i]) * 180 / std::numbers::pi;
    whole_ += share;
    if (glm::dot(normal, wanted[i]) < 0) {
      sums_.folded_area += share;
      if (is_elsewhere) sums_.folded_area_elsewhere += share;
    }
    squares_ += share * angle * angle;
    sums_.max_normal_deviation = std::max(sums_.max_normal_deviation, angle);
  }
  sums_.bending += face_bending({positions, normals});
}

SurfaceQuality QualitySum::result() const {
  SurfaceQuality quality = sums_;
  if (whole_ > 0) {
    quality.folded_area /= whole_;
    quality.folded_area_elsewhere /= whole_;
    quality.rms_normal_deviation = std::sqrt(squares_ / whole_);
  }
  return quality;
}

}  // namespace planish
