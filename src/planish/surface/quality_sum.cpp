#include "planish/surface/quality_sum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/surface/folded_places.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/quad_figures.h"

namespace planish {

ApexNormals::ApexNormals(const PolygonMesh& mesh) : mesh_(mesh) {
  if (mesh.corners.empty()) return;
  is_apex_.resize(mesh.positions.size(), 0);
  for (const CornerVertex& corner : mesh.corners)
    is_apex_[corner.vertex] = corner.sharpness >= kInfiniteSharpness ? 1 : 0;
  for (const CreaseEdge& crease : mesh.creases) is_apex_[crease.v0] = is_apex_[crease.v1] = 0;
  // Who is next to a vertex in its faces, less who is before it: nothing where faces go around.
  std::vector<std::uint32_t> around(mesh.positions.size(), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::int32_t from = face[i], to = face[(i + 1) % face.size()];
      around[from] += static_cast<std::uint32_t>(to);
      around[to] -= static_cast<std::uint32_t>(from);
    }
  }
  for (std::size_t v = 0; v < around.size(); ++v)
    if (around[v] != 0) is_apex_[v] = 0;
  if (std::ranges::find(is_apex_, 1) == is_apex_.end()) is_apex_.clear();
}

const glm::dvec3* ApexNormals::apex_of(std::int32_t face) const {
  if (is_apex_.empty()) return nullptr;
  const glm::dvec3* apex = nullptr;
  for (const std::int32_t v : mesh_.face(face))
    if (is_apex_[v] != 0) apex = &mesh_.positions[v];
  return apex;
}

void leave_out_apex(const glm::dvec3& apex, std::span<const glm::dvec3> positions,
                    std::span<glm::vec3> normals) {
  constexpr double kSame = 1e-6;  // squared, of the side behind
  const std::size_t count = positions.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t before = (k + count - 1) % count, behind = (k + 1) % count;
    const glm::dvec3 off = positions[k] - apex, side = positions[behind] - positions[k];
    if (glm::dot(off, off) > kSame * glm::dot(side, side)) continue;
    const glm::vec3 sum = normals[before] + normals[behind];
    if (const float length = glm::length(sum); length > 0) normals[k] = sum / length;
    return;
  }
}

namespace {

// Bending: the Dirichlet energy of the unit normals, linear on triangles: half the sum over edges
// of cot(opposite angle) |difference|^2 (Pinkall & Polthier 1993).

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

namespace {

// `input`, and `ancestor` of each face in it: null and empty where the reference is another shape.
SurfaceQuality measured_quality(const SurfaceMesh& surface, const ReferenceNormal& reference,
                                std::span<const std::uint8_t> is_beside_folds,
                                const PolygonMesh* input, std::span<const std::int32_t> ancestor) {
  std::optional<ApexNormals> apexes;
  if (input != nullptr) apexes.emplace(*input);
  QualitySum sum;
  FoldedPlaces places;
  StopCheck stop;
  std::vector<glm::dvec3> positions, wanted;
  std::vector<glm::vec3> normals;
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    stop.step();
    positions.clear();
    normals.clear();
    wanted.clear();
    const bool is_elsewhere = is_beside_folds.empty() || is_beside_folds[f] == 0;
    for (const std::int32_t v : surface.face(f)) {
      const auto corner = static_cast<std::int32_t>(wanted.size());
      positions.push_back(surface.positions[v]);
      normals.push_back(surface.normals[v]);
      wanted.push_back(reference(f, corner));
    }
    const glm::dvec3* apex = apexes ? apexes->apex_of(ancestor[f]) : nullptr;
    if (apex != nullptr) leave_out_apex(*apex, positions, normals);
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (input != nullptr && glm::dot(glm::dvec3(normals[i]), wanted[i]) < 0)
        places.add({ancestor[f], positions[i]}, is_elsewhere);
    sum.add(positions, normals, wanted, is_elsewhere);
  }
  SurfaceQuality quality = sum.result();
  quality.folded_places = places.take();
  return quality;
}

}  // namespace

SurfaceQuality surface_quality(const SurfaceMesh& surface, const ReferenceNormal& reference,
                               std::span<const std::uint8_t> is_beside_folds) {
  return measured_quality(surface, reference, is_beside_folds, nullptr, {});
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
      beside_folds(surface, input), &input, ancestor);
}

}  // namespace planish
