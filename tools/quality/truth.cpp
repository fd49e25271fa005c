#include "quality/truth.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "planish/mesh/angle_between.h"
#include "planish/reconstruct/triangle_tree.h"

namespace planish::quality {

Truth true_sphere(double radius) {
  return [radius](const glm::dvec3& p) {
    const glm::dvec3 normal = glm::normalize(p);
    return Foot{radius * normal, normal};
  };
}

Truth true_torus(double radius, double tube_radius) {
  return [=](const glm::dvec3& p) {
    const glm::dvec3 middle = radius * glm::normalize(glm::dvec3(p.x, p.y, 0.0));
    const glm::dvec3 normal = glm::normalize(p - middle);
    return Foot{middle + tube_radius * normal, normal};
  };
}

Truth true_zero_set(shapes::Field field) {
  return [field = std::move(field)](const glm::dvec3& p) {
    constexpr double kLongestStep = 0.02;  // surfaces are that near to their shapes
    const glm::dvec3 foot = shapes::projected(field, p, kLongestStep);
    return Foot{foot, glm::normalize(shapes::gradient(field, foot))};
  };
}

namespace {

// A dense mesh in triangles, with normals at its vertices.
struct DenseMesh {
  std::vector<glm::dvec3> positions, normals;
  std::vector<Triangle> triangles;
  TriangleTree tree;

  explicit DenseMesh(const PolygonMesh& mesh)
      : positions(mesh.positions),
        normals(positions.size(), glm::dvec3(0)),
        triangles(triangles_of(mesh)),
        tree(positions, triangles) {
    for (const Triangle& t : triangles) {
      for (int i = 0; i < 3; ++i) {
        const glm::dvec3 a = positions[t[(i + 1) % 3]] - positions[t[i]];
        const glm::dvec3 b = positions[t[(i + 2) % 3]] - positions[t[i]];
        const glm::dvec3 cross = glm::cross(a, b);
        const double length = glm::length(cross);
        if (length > 0) normals[t[i]] += angle_between(a, b) / length * cross;
      }
    }
    for (glm::dvec3& normal : normals) normal /= std::max(glm::length(normal), 1e-300);
  }

  [[nodiscard]] Foot foot(const glm::dvec3& p) const {
    const Triangle& t = triangles[tree.nearest(p).triangle];
    const TriangleShape shape(positions[t[0]], positions[t[1]], positions[t[2]]);
    const glm::dvec3 shares = shape.shares(p);
    glm::dvec3 point(0), normal(0);
    for (int i = 0; i < 3; ++i) {
      point += shares[i] * positions[t[i]];
      normal += shares[i] * normals[t[i]];
    }
    return {point, glm::normalize(normal)};
  }

  static std::vector<Triangle> triangles_of(const PolygonMesh& mesh) {
    std::vector<Triangle> triangles;
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      for (std::size_t i = 2; i < face.size(); ++i)
        triangles.push_back({face[0], face[i - 1], face[i]});
    }
    return triangles;
  }
};

}  // namespace

Truth true_mesh(const PolygonMesh& mesh) {
  return [dense = std::make_shared<const DenseMesh>(mesh)](const glm::dvec3& p) {
    return dense->foot(p);
  };
}

}  // namespace planish::quality
