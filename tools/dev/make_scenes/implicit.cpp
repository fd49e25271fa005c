#include "make_scenes/implicit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "make_scenes/shapes.h"

namespace planish::shapes {

// Based on: Inigo Quilez, "Distance functions" and "Smooth minimum", 2013.

double Ellipsoid::operator()(const glm::dvec3& p) const {
  const glm::dvec3 scaled = (p - centre) / radii;
  const double level = glm::length(scaled);
  const double slope = glm::length(scaled / radii);
  if (slope < 1e-12) return -std::min({radii.x, radii.y, radii.z});
  return level * (level - 1.0) / slope;
}

double Cone::operator()(const glm::dvec3& p) const {
  const glm::dvec3 axis = b - a;
  const double t = std::clamp(glm::dot(p - a, axis) / glm::dot(axis, axis), 0.0, 1.0);
  return glm::distance(p, a + axis * t) - (radius_a + (radius_b - radius_a) * t);
}

double extruded(double distance, double height, double half_height, double rounding) {
  const glm::dvec2 over(distance + rounding, std::abs(height) - half_height + rounding);
  return std::min(std::max(over.x, over.y), 0.0) + glm::length(glm::max(over, glm::dvec2(0.0))) -
         rounding;
}

double rounded_box(const glm::dvec3& p, const glm::dvec3& half_size, double rounding) {
  const glm::dvec3 over = glm::abs(p) - half_size + rounding;
  return std::min(std::max({over.x, over.y, over.z}), 0.0) +
         glm::length(glm::max(over, glm::dvec3(0.0))) - rounding;
}

double smooth_union(double a, double b, double width) {
  const double overlap = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - overlap * overlap * width * 0.25;
}

double smooth_intersection(double a, double b, double width) {
  return -smooth_union(-a, -b, width);
}

double smooth_difference(double a, double b, double width) { return -smooth_union(-a, b, width); }

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

namespace {

// Based on: S. F. F. Gibson, "Constrained Elastic Surface Nets: Generating Smooth Surfaces from
// Binary Segmented Data", 1998.

struct Lattice {
  glm::dvec3 low;
  double cell;
  std::array<std::int32_t, 3> points;  // along each axis
  std::vector<float> values;

  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) * points[1] + y) * points[0] + x;
  }
  [[nodiscard]] glm::dvec3 position(const glm::dvec3& point) const { return low + point * cell; }
};

// The Newton step from a point to the zero set, no longer than `longest`.
glm::dvec3 step_to_surface(double value, const glm::dvec3& slope, double longest) {
  constexpr double kLeastSlopeSquared = 0.01;  // where bodies cancel, the slope may vanish
  const glm::dvec3 move = slope * (-value / std::max(glm::dot(slope, slope), kLeastSlopeSquared));
  const double length = glm::length(move);
  return length > longest ? move * (longest / length) : move;
}

}  // namespace

// From the corners of a small tetrahedron: four evaluations, exact for linear fields.
glm::dvec3 gradient(const Field& field, const glm::dvec3& p) {
  constexpr double kStep = 1e-5;
  constexpr std::array<glm::dvec3, 4> kCorners{
      {{1.0, 1.0, 1.0}, {1.0, -1.0, -1.0}, {-1.0, 1.0, -1.0}, {-1.0, -1.0, 1.0}}};
  glm::dvec3 result(0.0);
  for (const glm::dvec3& corner : kCorners) result += corner * field(p + corner * kStep);
  return result / (4.0 * kStep);
}

// Newton along the gradient; a step never leaves the cell's neighbourhood.
glm::dvec3 projected(const Field& field, glm::dvec3 p, double longest_step) {
  constexpr int kSteps = 12;
  constexpr double kClose = 1e-10;
  for (int step = 0; step < kSteps; ++step) {
    const double value = field(p);
    if (std::abs(value) < kClose) break;
    p += step_to_surface(value, gradient(field, p), longest_step);
  }
  return p;
}

namespace {

Lattice sampled_grid(const Field& field, const SurfaceNetsOptions& options) {
  Lattice lattice{options.low, options.cell, {}, {}};
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = options.high[axis] - options.low[axis];
    lattice.points[axis] = static_cast<std::int32_t>(std::ceil(extent / options.cell)) + 1;
  }
  const auto [nx, ny, nz] = lattice.points;
  lattice.values.resize(static_cast<std::size_t>(nx) * ny * nz);
  for (std::int32_t z = 0; z < nz; ++z) {
    for (std::int32_t y = 0; y < ny; ++y) {
      for (std::int32_t x = 0; x < nx; ++x) {
        const glm::dvec3 p = lattice.position({x, y, z});
        lattice.values[lattice.index(x, y, z)] =
            static_cast<float>(field(options.warp ? options.warp(p) : p));
      }
    }
  }
  return lattice;
}

// Mean of the crossings on the cell's twelve edges, in lattice steps from its low corner.
glm::dvec3 crossing_mean(const Lattice& lattice, std::int32_t x, std::int32_t y, std::int32_t z) {
  glm::dvec3 sum(0.0);
  int count = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<std::int32_t, 3> from{corner & 1, corner >> 1 & 1, corner >> 2};
    for (int axis = 0; axis < 3; ++axis) {
      if (from[axis] != 0) continue;
      std::array<std::int32_t, 3> to = from;
      to[axis] = 1;
      const double a = lattice.values[lattice.index(x + from[0], y + from[1], z + from[2])];
      const double b = lattice.values[lattice.index(x + to[0], y + to[1], z + to[2])];
      if ((a < 0.0) == (b < 0.0)) continue;
      glm::dvec3 crossing(from[0], from[1], from[2]);
      crossing[axis] = a / (a - b);
      sum += crossing;
      ++count;
    }
  }
  return glm::dvec3(x, y, z) + sum / static_cast<double>(count);
}

PolygonMesh polygonised(const Lattice& lattice) {
  PolygonMesh mesh;
  LatticeVertices vertices(mesh);
  const auto vertex = [&](const std::array<std::int32_t, 3>& cell) {
    return vertices.at(cell, lattice.position(crossing_mean(lattice, cell[0], cell[1], cell[2])));
  };
  for (std::int32_t z = 1; z + 1 < lattice.points[2]; ++z) {
    for (std::int32_t y = 1; y + 1 < lattice.points[1]; ++y) {
      for (std::int32_t x = 1; x + 1 < lattice.points[0]; ++x) {
        for (int axis = 0; axis < 3; ++axis) {
          std::array<std::int32_t, 3> next{x, y, z};
          ++next[axis];
          const bool here = lattice.values[lattice.index(x, y, z)] < 0.0f;
          const bool there = lattice.values[lattice.index(next[0], next[1], next[2])] < 0.0f;
          if (here == there) continue;
          // The four cells around the lattice edge, counter-clockwise seen from its far end.
          std::array<std::int32_t, 4> corners;
          constexpr std::array<std::array<int, 2>, 4> kAround{{{1, 1}, {0, 1}, {0, 0}, {1, 0}}};
          for (int i = 0; i < 4; ++i) {
            std::array<std::int32_t, 3> cell{x, y, z};
            cell[(axis + 1) % 3] -= kAround[i][0];
            cell[(axis + 2) % 3] -= kAround[i][1];
            corners[here ? i : 3 - i] = vertex(cell);
          }
          mesh.add_face(corners);
        }
      }
    }
  }
  return mesh;
}

// One step towards the mean of the surrounding faces' centroids, along the surface only.
void relax(PolygonMesh& mesh, const Field& field, double longest_step) {
  constexpr double kShare = 0.5;
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
  std::vector<double> weights(mesh.positions.size(), 0.0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const double area = std::sqrt(glm::length(face_normal(mesh, f)));
    glm::dvec3 centroid(0.0);
    for (const std::int32_t v : mesh.face(f)) centroid += mesh.positions[v] * 0.25;
    for (const std::int32_t v : mesh.face(f)) {
      sums[v] += centroid * area;
      weights[v] += area;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    glm::dvec3& p = mesh.positions[v];
    const glm::dvec3 slope = gradient(field, p);
    const glm::dvec3 normal = slope / std::max(glm::length(slope), 1e-12);
    glm::dvec3 move = (sums[v] / weights[v] - p) * kShare;
    move -= normal * glm::dot(normal, move);
    p += move;
    p += step_to_surface(field(p), slope, longest_step);
  }
}

}  // namespace

PolygonMesh surface_nets(const Field& field, const SurfaceNetsOptions& options) {
  PolygonMesh mesh = polygonised(sampled_grid(field, options));
  for (glm::dvec3& p : mesh.positions) {
    if (options.warp) p = options.warp(p);
    p = projected(field, p, options.cell);
  }
  for (int step = 0; step < options.relax_steps; ++step) relax(mesh, field, options.cell);
  for (glm::dvec3& p : mesh.positions) p = projected(field, p, options.cell);
  return mesh;
}

}  // namespace planish::shapes
