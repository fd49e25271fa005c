#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace planish {

/// Weighted sum of squared distances to planes, as a function of position.
/// Source: M. Garland, P. Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  glm::dvec3 linear{0.0};
  double constant = 0;
  double weight = 0;

  /// The plane through `point` with a unit normal.
  void add_plane(const glm::dvec3& normal, const glm::dvec3& point, double w) {
    const double offset = glm::dot(normal, point);
    xx += w * normal.x * normal.x;
    xy += w * normal.x * normal.y;
    xz += w * normal.x * normal.z;
    yy += w * normal.y * normal.y;
    yz += w * normal.y * normal.z;
    zz += w * normal.z * normal.z;
    linear -= w * offset * normal;
    constant += w * offset * offset;
    weight += w;
  }
  void add(const Quadric& other) {
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    linear += other.linear;
    constant += other.constant;
    weight += other.weight;
  }
  [[nodiscard]] double at(const glm::dvec3& p) const {
    const glm::dvec3 product(xx * p.x + xy * p.y + xz * p.z, xy * p.x + yy * p.y + yz * p.z,
                             xz * p.x + yz * p.y + zz * p.z);
    // Rounding may take it below 0.
    return glm::max(glm::dot(p, product) + 2 * glm::dot(linear, p) + constant, 0.0);
  }
};

}  // namespace planish
