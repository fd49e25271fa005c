// Based on: Rusinkiewicz, "Estimating Curvatures and Their Derivatives on Triangle Meshes", 2004:
// a symmetric 2 x 2 form in the tangent plane, fitted to finite differences of normals. Here per
// vertex over the edges that leave it, since the normals are exact at vertices.
#include "planish/surface/normal_curvatures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/group_by.h"
#include "planish/core/parallel.h"
#include "planish/core/work.h"

namespace planish {
namespace {

// Below this the edges around a vertex leave the form open: two directions only, or none. Rows are
// of unit size, so the determinant of a full set is of order 1.
constexpr double kOpenForm = 1e-9;

// Of a large face's other corners so many are asked, evenly spaced: all of them for each of them
// would take the square of its size.
constexpr std::size_t kMostOthers = 32;

struct FaceCorner {
  std::int32_t face, place;
};

Groups<FaceCorner> corners_by_vertex(const SurfaceMesh& surface) {
  return group_by<FaceCorner>(surface.positions.size(), [&](const auto& take) {
    for (std::int64_t f = 0; f < surface.face_count(); ++f) {
      std::int32_t place = 0;
      for (const std::int32_t v : surface.face(f))
        take(v, FaceCorner{static_cast<std::int32_t>(f), place++});
    }
  });
}

struct Tangents {
  glm::dvec3 u, v;
};

Tangents tangents_of(const glm::dvec3& normal) {
  const glm::dvec3 axis = std::abs(normal.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 u = glm::normalize(glm::cross(normal, axis));
  return {u, glm::cross(normal, u)};
}

// Normal equations of E x^2 + 2 F x y + G y^2 = curvature.
struct FormFit {
  std::array<double, 6> matrix{};  // upper triangle by rows
  std::array<double, 3> right{};

  void add(double x, double y, double curvature) {
    const std::array<double, 3> row{x * x, 2 * x * y, y * y};
    int at = 0;
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) matrix[at++] += row[r] * row[c];
      right[r] += row[r] * curvature;
    }
  }

  // {E, F, G}; zeros where the form is open.
  [[nodiscard]] std::array<double, 3> solve() const {
    const auto& [a, b, c, d, e, f] = matrix;
    const auto& [p, q, r] = right;
    const double determinant = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c);
    if (std::abs(determinant) < kOpenForm) return {};
    return {(p * (d * f - e * e) - b * (q * f - e * r) + c * (q * e - d * r)) / determinant,
            (a * (q * f - e * r) - p * (b * f - e * c) + c * (b * r - q * c)) / determinant,
            (a * (d * r - q * e) - b * (b * r - q * c) + p * (b * e - d * c)) / determinant};
  }
};

std::array<double, 3> form_at(const SurfaceMesh& surface, std::size_t vertex,
                              std::span<const FaceCorner> corners, std::int64_t& asked) {
  const glm::dvec3 normal(surface.normals[vertex]);
  const Tangents tangents = tangents_of(normal);
  FormFit fit;
  const auto add = [&](std::int32_t other) {
    const glm::dvec3 along = surface.positions[other] - surface.positions[vertex];
    const double square = glm::dot(along, along);
    double x = glm::dot(along, tangents.u), y = glm::dot(along, tangents.v);
    const double length = std::hypot(x, y);
    if (!(length > 0)) return;
    x /= length;
    y /= length;
    fit.add(x, y, glm::dot(glm::dvec3(surface.normals[other]) - normal, along) / square);
  };
  for (const auto& [f, place] : corners) {
    // The other corners of a quad: both neighbours, and the diagonal, without which a grid's two
    // directions would leave the mixed term open.
    const auto face = surface.face(f);
    const std::size_t others = face.size() - 1;
    asked += static_cast<std::int64_t>(std::min(others, kMostOthers));
    if (others <= kMostOthers) {
      for (const std::int32_t other : face) add(other);
      continue;
    }
    for (std::size_t k = 0; k < kMostOthers; ++k) {
      const std::size_t way = 1 + k * (others - 1) / (kMostOthers - 1);
      add(face[(static_cast<std::size_t>(place) + way) % face.size()]);
    }
  }
  return fit.solve();
}

}  // namespace

Curvatures curvatures_of_normals(const SurfaceMesh& surface) {
  const Groups<FaceCorner> corners = corners_by_vertex(surface);
  Curvatures result;
  result.mean.resize(surface.positions.size());
  result.gaussian.resize(surface.positions.size());
  parallel_for(surface.positions.size(), 1024, [&](std::size_t begin, std::size_t end) {
    std::int64_t asked = 0;
    for (std::size_t v = begin; v < end; ++v) {
      const auto [e, f, g] = form_at(surface, v, corners.of(v), asked);
      result.mean[v] = static_cast<float>((e + g) / 2);
      result.gaussian[v] = static_cast<float>(e * g - f * f);
    }
    count_work(Work::Pairs, asked);
  });
  return result;
}

}  // namespace planish
