#include "make_scenes/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <stdexcept>

namespace planish::shapes {

namespace {
constexpr double kCoordinateSteps = 1e6;        // per unit: six decimals in the file
constexpr std::int32_t kLatticeBias = 1 << 20;  // lattice points run from -2^20 to 2^20 - 1
}  // namespace

void add_face(PolygonMesh& mesh, std::initializer_list<std::int32_t> vertices) {
  mesh.add_face(std::span(vertices.begin(), vertices.size()));
}

std::int32_t LatticeVertices::at(const std::array<std::int32_t, 3>& point,
                                 const glm::dvec3& position) {
  std::uint64_t key = 0;
  for (const std::int32_t coordinate : point) {
    key = (key << 21) | static_cast<std::uint64_t>(coordinate + kLatticeBias);
  }
  const auto [entry, is_new] = vertices_.try_emplace(key, mesh_.vertex_count());
  if (is_new) mesh_.positions.push_back(position);
  return entry->second;
}

std::uint64_t edge_key(std::int32_t a, std::int32_t b) {
  const auto [low, high] = std::minmax(a, b);
  return (static_cast<std::uint64_t>(low) << 32) | static_cast<std::uint32_t>(high);
}

glm::dvec3 face_normal(const PolygonMesh& mesh, std::int32_t face) {
  const auto corners = mesh.face(face);
  glm::dvec3 normal(0.0);
  const glm::dvec3 origin = mesh.positions[corners[0]];
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    normal +=
        glm::cross(mesh.positions[corners[i]] - origin, mesh.positions[corners[i + 1]] - origin);
  }
  return normal;
}

void crease_sharp_edges(PolygonMesh& mesh, double degrees) {
  const double least_cosine = std::cos(degrees * std::acos(-1.0) / 180.0);
  std::unordered_map<std::uint64_t, std::int32_t> first_face;
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const auto corners = mesh.face(face);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::int32_t v0 = corners[i];
      const std::int32_t v1 = corners[(i + 1) % corners.size()];
      const auto [entry, is_new] = first_face.try_emplace(edge_key(v0, v1), face);
      if (is_new) continue;
      const glm::dvec3 here = glm::normalize(face_normal(mesh, face));
      const glm::dvec3 there = glm::normalize(face_normal(mesh, entry->second));
      if (glm::dot(here, there) < least_cosine) mesh.creases.push_back({v0, v1});
    }
  }
}

double rounded(double number) {
  // Adding zero turns -0 into 0, which would else show in the file.
  return std::round(number * kCoordinateSteps) / kCoordinateSteps + 0.0;
}

void round_positions(PolygonMesh& mesh) {
  for (glm::dvec3& position : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      position[axis] = rounded(position[axis]);
    }
  }
  for (glm::dvec2& uv : mesh.uvs) uv = {rounded(uv.x), rounded(uv.y)};
}

}  // namespace planish::shapes
