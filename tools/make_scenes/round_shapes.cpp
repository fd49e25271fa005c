#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <stdexcept>
#include <unordered_map>

#include "make_scenes/mesh_builder.h"
#include "make_scenes/shapes.h"

namespace planish::shapes {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::int32_t kHighestLevel = 11;  // 84 M triangles; the next would pass 2^27 vertices

PolygonMesh icosahedron() {
  const double golden = std::numbers::phi;
  PolygonMesh mesh;
  for (const double one : {-1.0, 1.0}) {
    for (const double ratio : {-golden, golden}) {
      mesh.positions.emplace_back(0.0, one, ratio);
      mesh.positions.emplace_back(one, ratio, 0.0);
      mesh.positions.emplace_back(ratio, 0.0, one);
    }
  }
  // Triangles are the triples at the edge length 2, turned outward.
  const auto is_edge = [&](std::int32_t a, std::int32_t b) {
    return std::abs(glm::distance(mesh.positions[a], mesh.positions[b]) - 2.0) < 1e-9;
  };
  for (std::int32_t a = 0; a < 12; ++a) {
    for (std::int32_t b = a + 1; b < 12; ++b) {
      for (std::int32_t c = b + 1; c < 12; ++c) {
        if (!is_edge(a, b) || !is_edge(b, c) || !is_edge(c, a)) continue;
        const glm::dvec3& p = mesh.positions[a];
        const glm::dvec3 normal = glm::cross(mesh.positions[b] - p, mesh.positions[c] - p);
        if (glm::dot(normal, p) > 0.0) {
          add_face(mesh, {a, b, c});
        } else {
          add_face(mesh, {a, c, b});
        }
      }
    }
  }
  for (glm::dvec3& position : mesh.positions) position = glm::normalize(position);
  return mesh;
}

PolygonMesh split_on_sphere(const PolygonMesh& coarse) {
  PolygonMesh fine;
  fine.positions = coarse.positions;
  std::unordered_map<std::uint64_t, std::int32_t> midpoints;
  const auto midpoint = [&](std::int32_t a, std::int32_t b) {
    const auto [entry, is_new] = midpoints.try_emplace(edge_key(a, b), fine.vertex_count());
    if (is_new) {
      fine.positions.push_back(glm::normalize(fine.positions[a] + fine.positions[b]));
    }
    return entry->second;
  };
  for (std::int32_t face = 0; face < coarse.face_count(); ++face) {
    const auto corners = coarse.face(face);
    const std::int32_t ab = midpoint(corners[0], corners[1]);
    const std::int32_t bc = midpoint(corners[1], corners[2]);
    const std::int32_t ca = midpoint(corners[2], corners[0]);
    add_face(fine, {corners[0], ab, ca});
    add_face(fine, {corners[1], bc, ab});
    add_face(fine, {corners[2], ca, bc});
    add_face(fine, {ab, bc, ca});
  }
  return fine;
}

}  // namespace

PolygonMesh torus(const TorusOptions& options) {
  if (options.ring_count < 3 || options.tube_count < 3) {
    throw std::invalid_argument("torus: both counts must be at least 3");
  }
  PolygonMesh mesh;
  const std::int32_t rings = options.ring_count;
  const std::int32_t tubes = options.tube_count;
  mesh.positions.reserve(static_cast<std::size_t>(rings) * tubes);
  for (std::int32_t i = 0; i < rings; ++i) {
    const double along = kTurn * i / rings;
    for (std::int32_t j = 0; j < tubes; ++j) {
      const double around = kTurn * j / tubes;
      const double distance = options.radius + options.tube_radius * std::cos(around);
      mesh.positions.emplace_back(distance * std::cos(along), distance * std::sin(along),
                                  options.tube_radius * std::sin(around));
    }
  }
  mesh.face_vertices.reserve(static_cast<std::size_t>(rings) * tubes * 4);
  mesh.face_offsets.reserve(static_cast<std::size_t>(rings) * tubes + 1);
  for (std::int32_t i = 0; i < rings; ++i) {
    const std::int32_t here = i * tubes;
    const std::int32_t next = (i + 1) % rings * tubes;
    for (std::int32_t j = 0; j < tubes; ++j) {
      const std::int32_t up = (j + 1) % tubes;
      add_face(mesh, {here + j, next + j, next + up, here + up});
    }
  }
  return mesh;
}

PolygonMesh icosphere(std::int32_t level) {
  if (level < 0 || level > kHighestLevel) {
    throw std::invalid_argument("icosphere: level must be 0 to 11");
  }
  PolygonMesh mesh = icosahedron();
  for (std::int32_t i = 0; i < level; ++i) mesh = split_on_sphere(mesh);
  return mesh;
}

PolygonMesh pole_sphere(std::int32_t segment_count, std::int32_t ring_count) {
  if (segment_count < 3 || ring_count < 1) {
    throw std::invalid_argument("pole_sphere: at least 3 segments and 1 ring");
  }
  PolygonMesh mesh;
  // ring_count + 1 circles evenly between the poles, from the south.
  for (std::int32_t ring = 0; ring <= ring_count; ++ring) {
    const double latitude = std::numbers::pi * (ring + 1) / (ring_count + 2);
    for (std::int32_t i = 0; i < segment_count; ++i) {
      const double longitude = kTurn * i / segment_count;
      mesh.positions.emplace_back(std::sin(latitude) * std::cos(longitude),
                                  std::sin(latitude) * std::sin(longitude), -std::cos(latitude));
    }
  }
  const std::int32_t pole = mesh.vertex_count();
  mesh.positions.emplace_back(0.0, 0.0, 1.0);
  std::vector<std::int32_t> cap;
  for (std::int32_t i = segment_count - 1; i >= 0; --i) cap.push_back(i);
  mesh.add_face(cap);
  for (std::int32_t ring = 0; ring <= ring_count; ++ring) {
    for (std::int32_t i = 0; i < segment_count; ++i) {
      const std::int32_t a = ring * segment_count + i;
      const std::int32_t b = ring * segment_count + (i + 1) % segment_count;
      if (ring < ring_count) {
        add_face(mesh, {a, b, b + segment_count, a + segment_count});
      } else {
        add_face(mesh, {a, b, pole});
      }
    }
  }
  return mesh;
}

}  // namespace planish::shapes
