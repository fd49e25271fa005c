// Bodies in other meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "features/bodies.h"
#include "features/shapes.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;

// An edge with a vertex in its middle is two.
void split_edges(Body& body, Lot& lot) {
  const double share = lot.real(0.1, 0.5);
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  PolygonMesh mesh;
  mesh.positions = body.mesh.positions;
  for (std::int32_t f = 0; f < body.mesh.face_count(); ++f) {
    const auto face = body.mesh.face(f);
    std::vector<std::int32_t> now;
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::int32_t a = face[i], b = face[(i + 1) % face.size()];
      now.push_back(a);
      const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), -1);
      if (is_new && lot.chance(share)) {
        const double at = lot.real(0.3, 0.7);
        place->second = mesh.vertex_count();
        mesh.positions.push_back(mesh.positions[a] + at * (mesh.positions[b] - mesh.positions[a]));
      }
      if (place->second >= 0) now.push_back(place->second);
    }
    mesh.add_face(now);
  }
  body.mesh = std::move(mesh);
}

// Each triangle, some, with a vertex in its plane.
void poke_faces(Body& body, Lot& lot) {
  Body now;
  now.mesh.positions = body.mesh.positions;
  const double share = lot.real(0.1, 0.6);
  for (std::int32_t f = 0; f < body.mesh.face_count(); ++f) {
    const auto face = body.mesh.face(f);
    const bool is_poked = face.size() == 3 && lot.chance(share);
    const std::int32_t v = now.mesh.vertex_count();
    if (!is_poked) {
      now.mesh.add_face(face);
      now.surfaces.push_back(body.surfaces[f]);
      continue;
    }
    const double a = lot.real(0.2, 0.5), b = lot.real(0.2, 0.4);
    const auto& p = now.mesh.positions;
    now.mesh.positions.push_back(a * p[face[0]] + b * p[face[1]] + (1 - a - b) * p[face[2]]);
    for (std::size_t i = 0; i < 3; ++i) {
      now.mesh.add_face(std::array{face[i], face[(i + 1) % 3], v});
      now.surfaces.push_back(body.surfaces[f]);
    }
  }
  body.mesh = std::move(now.mesh);
  body.surfaces = std::move(now.surfaces);
}

}  // namespace

KnownMesh known_mesh(const Body& body) {
  KnownMesh known{body.mesh, {}};
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> first;
  for (std::int32_t f = 0; f < body.mesh.face_count(); ++f) {
    const auto face = body.mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::int32_t a = face[i], b = face[(i + 1) % face.size()];
      const auto [place, is_new] = first.try_emplace(std::minmax(a, b), f);
      const std::int32_t s = body.surfaces[place->second];
      if (!is_new && (s == kFacet || s != body.surfaces[f])) known.sharp.push_back({a, b});
    }
  }
  return known;
}

KnownMesh presented(const Body& body, Lot& lot, std::string& what) {
  Body now = body;
  if (lot.chance(0.3)) {
    what += "; edges split";
    split_edges(now, lot);
  }
  KnownMesh known = known_mesh(now);
  const int cut = lot.whole(0, 2);
  if (cut > 0) {
    what += cut == 1 ? "; in fans" : "; cut by lot";
    now.mesh = cut == 1 ? in_fans(now.mesh)
                        : cut_by_lot(now.mesh, static_cast<std::uint32_t>(lot.whole(0, 1 << 20)));
    now.surfaces.assign(now.mesh.face_count(), 0);
    if (lot.chance(0.3)) {
      what += "; poked";
      poke_faces(now, lot);
    }
  }
  known.mesh = now.mesh;
  const auto change = [&](const auto& to) {
    for (dvec3& p : known.mesh.positions) p = to(p);
  };
  if (lot.chance(0.3)) {
    what += "; jittered";
    known.mesh = jittered(known.mesh, 1e-12, static_cast<std::uint32_t>(lot.whole(0, 1 << 20)));
  }
  if (lot.chance(0.3)) {
    what += "; mirrored";
    FaceList faces = faces_of(known.mesh);
    for (auto& face : faces) std::ranges::reverse(face);
    known.mesh = make_mesh(known.mesh.positions, faces);
    change([](dvec3 p) { return dvec3(-p.x, p.y, p.z); });
  }
  if (lot.chance(0.6)) {
    what += "; turned";
    const dvec3 axis = glm::normalize(dvec3(lot.real(-1, 1), lot.real(-1, 1), lot.real(-1, 1)) +
                                      dvec3(1e-3, 0, 0));
    const double angle = lot.real(0, 2 * glm::pi<double>()), c = std::cos(angle),
                 s = std::sin(angle);
    change([&](const dvec3& p) {
      return c * p + s * glm::cross(axis, p) + (1 - c) * glm::dot(axis, p) * axis;
    });
  }
  if (lot.chance(0.3)) {
    what += "; scaled";
    const double scale = lot.ratio(1e-3, 1e3);
    change([&](const dvec3& p) { return scale * p; });
  }
  if (lot.chance(0.3)) {
    what += "; far";
    const dvec3 far =
        1e3 * glm::length(known.mesh.positions[0] - known.mesh.positions[1]) * dvec3(1, -0.7, 0.4);
    change([&](const dvec3& p) { return p + far; });
  }
  if (lot.chance(0.3)) {
    what += "; beside a ball";
    const PolygonMesh ball = icosphere(2);
    const std::int32_t count = known.mesh.vertex_count();
    const dvec3 by = known.mesh.positions[0] + dvec3(0, 0, 1e4);
    for (const dvec3& p : ball.positions) known.mesh.positions.push_back(10.0 * p + by);
    for (std::vector<std::int32_t> face : faces_of(ball)) {
      for (std::int32_t& v : face) v += count;
      known.mesh.add_face(face);
    }
  }
  if (lot.chance(0.3)) {
    what += "; in another order";
    const Relabelled other =
        relabelled(known.mesh, static_cast<std::uint32_t>(lot.whole(0, 1 << 20)));
    known.mesh = other.mesh;
    for (CreaseEdge& edge : known.sharp)
      edge = {other.new_index[edge.v0], other.new_index[edge.v1]};
  }
  return known;
}

}  // namespace planish::test
