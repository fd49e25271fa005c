#include "features/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/vec3.hpp>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kTau = 2 * glm::pi<double>();
constexpr double kSame = 1e-9;

bool is_ear(const PolygonMesh& mesh, const std::vector<std::int32_t>& ring, std::size_t i,
            const dvec3& normal) {
  const std::size_t n = ring.size();
  const dvec3 a = mesh.positions[ring[(i + n - 1) % n]], b = mesh.positions[ring[i]],
              c = mesh.positions[ring[(i + 1) % n]];
  const auto side = [&](const dvec3& p, const dvec3& q, const dvec3& r) {
    return glm::dot(glm::cross(q - p, r - p), normal);
  };
  if (side(a, b, c) <= 1e-12 * glm::dot(c - a, c - a)) return false;
  for (std::size_t k = 0; k < n; ++k) {
    if (k == i || k == (i + 1) % n || k == (i + n - 1) % n) continue;
    const dvec3 p = mesh.positions[ring[k]];
    if (side(a, b, p) >= -kSame && side(b, c, p) >= -kSame && side(c, a, p) >= -kSame) return false;
  }
  return true;
}

// `first(n)`: the corner at which to begin looking for an ear.
template <class First>
PolygonMesh by_ears(const PolygonMesh& mesh, const First& first) {
  PolygonMesh cut = mesh;
  cut.face_offsets = {0};
  cut.face_vertices.clear();
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const dvec3 normal = glm::normalize(area_vector(mesh.positions, face));
    std::vector<std::int32_t> ring(face.begin(), face.end());
    while (ring.size() > 3) {
      const std::size_t n = ring.size();
      std::size_t i = first(n), tries = 0;
      while (!is_ear(mesh, ring, i % n, normal) && ++tries < n) ++i;
      i %= n;
      cut.add_face(std::array{ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
      ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
    }
    cut.add_face(ring);
  }
  return cut;
}

bool is_level(const dvec3& a, const dvec3& b) { return std::abs(a.z - b.z) < kSame; }

using IsSharp = std::function<bool(const dvec3&, const dvec3&)>;

bool all(const dvec3&, const dvec3&) { return true; }
bool none(const dvec3&, const dvec3&) { return false; }

// Of extruded bodies: rims; upright edges where the outline turns by 60 degrees and more.
IsSharp rims_and(const Outline2& outline) {
  std::vector<dvec2> corners;
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const dvec2 in = outline[i] - outline[(i + n - 1) % n], out = outline[(i + 1) % n] - outline[i];
    if (glm::dot(glm::normalize(in), glm::normalize(out)) < 0.5 + kSame)
      corners.push_back(outline[i]);
  }
  return [corners](const dvec3& a, const dvec3& b) {
    if (is_level(a, b)) return true;
    for (const dvec2& corner : corners)
      if (glm::length(dvec2(a) - corner) < kSame) return true;
    return false;
  };
}

// Places by rings of n, from the lowest on, the first and last closed by a face.
PolygonMesh of_rings(const std::vector<std::vector<dvec3>>& rings) {
  PolygonMesh mesh;
  const auto n = static_cast<std::int32_t>(rings.front().size());
  for (const auto& ring : rings)
    for (const dvec3& place : ring) mesh.positions.push_back(place);
  const auto last = static_cast<std::int32_t>(rings.size()) - 1;
  std::vector<std::int32_t> lower, upper;
  for (std::int32_t i = 0; i < n; ++i) {
    lower.push_back(n - 1 - i);
    upper.push_back(last * n + i);
  }
  mesh.add_face(lower);
  for (std::int32_t r = 0; r < last; ++r)
    for (std::int32_t i = 0; i < n; ++i)
      mesh.add_face(
          std::array{r * n + i, r * n + (i + 1) % n, (r + 1) * n + (i + 1) % n, (r + 1) * n + i});
  mesh.add_face(upper);
  return mesh;
}

std::vector<dvec3> ring_at(const Outline2& outline, double z, double scale = 1) {
  std::vector<dvec3> ring;
  for (const dvec2& p : outline) ring.emplace_back(scale * p, z);
  return ring;
}

Outline2 box_outline(double x, double y) { return {{0, 0}, {x, 0}, {x, y}, {0, y}}; }

PolygonMesh uv_sphere(int around, int across) {
  PolygonMesh mesh;
  for (int r = 1; r < across; ++r)
    for (int i = 0; i < around; ++i) {
      const double u = kTau * i / around, v = kTau / 2 * r / across;
      mesh.positions.emplace_back(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u),
                                  -std::cos(v));
    }
  const std::int32_t low = mesh.vertex_count(), high = low + 1;
  mesh.positions.emplace_back(0, 0, -1);
  mesh.positions.emplace_back(0, 0, 1);
  for (int i = 0; i < around; ++i) {
    const int j = (i + 1) % around, top = (across - 2) * around;
    mesh.add_face(std::array{low, j, i});
    for (int r = 0; r + 2 < across; ++r)
      mesh.add_face(
          std::array{r * around + i, r * around + j, (r + 1) * around + j, (r + 1) * around + i});
    mesh.add_face(std::array{top + i, top + j, high});
  }
  return mesh;
}

// A house over a x b with walls of 1 and a roof that rises by `pitch` degrees.
PolygonMesh house(double a, double b, double pitch) {
  const double ridge = 1 + b / 2 * std::tan(pitch * kTau / 360);
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {a, 0, 0}, {a, b, 0}, {0, b, 0},         {0, 0, 1},
                    {a, 0, 1}, {a, b, 1}, {0, b, 1}, {0, b / 2, ridge}, {a, b / 2, ridge}};
  for (const std::vector<std::int32_t>& face :
       std::vector<std::vector<std::int32_t>>{{3, 2, 1, 0},
                                              {0, 1, 5, 4},
                                              {2, 3, 7, 6},
                                              {1, 2, 6, 9, 5},
                                              {3, 0, 4, 8, 7},
                                              {4, 5, 9, 8},
                                              {6, 7, 8, 9}})
    mesh.add_face(face);
  return mesh;
}

PolygonMesh chamfered_box(double x, double y, double z, double chamfer) {
  const double c = chamfer;
  const Outline2 inner{{c, c}, {x - c, c}, {x - c, y - c}, {c, y - c}}, outer = box_outline(x, y);
  return of_rings({ring_at(outer, 0), ring_at(outer, z - c), ring_at(inner, z)});
}

Outline2 l_outline() { return {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}; }
Outline2 u_outline() { return {{0, 0}, {3, 0}, {3, 2}, {2, 2}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}; }
Outline2 t_outline() { return {{1, 0}, {2, 0}, {2, 2}, {3, 2}, {3, 3}, {0, 3}, {0, 2}, {1, 2}}; }
Outline2 slot_outline(int steps, double length) {
  Outline2 outline;
  for (const int side : {0, 1})
    for (int i = 0; i <= steps; ++i) {
      const double angle = kTau / 2 * (static_cast<double>(i) / steps + side - 0.5);
      outline.emplace_back(std::cos(angle) + (side ? -length : length), std::sin(angle));
    }
  return outline;
}
// A box with a quarter round of `steps` steps at one edge.
Outline2 rounded_outline(int steps, double radius) {
  Outline2 outline{{0, 0}, {2, 0}};
  for (int i = 0; i <= steps; ++i) {
    const double angle = kTau / 4 * i / steps;
    outline.emplace_back(2 - radius + radius * std::cos(angle),
                         1.5 - radius + radius * std::sin(angle));
  }
  outline.emplace_back(0, 1.5);
  return outline;
}

std::string text(double number) {
  std::string s = std::to_string(number);
  return s.substr(0, s.find('.') + 3);
}

// Polygons, fans and two cuttings by lot.
void add(std::vector<FeatureCase>& cases, const std::string& name, const PolygonMesh& mesh,
         const IsSharp& is_sharp) {
  cases.push_back({name, mesh, is_sharp});
  cases.push_back({name + ", fans", in_fans(mesh), is_sharp});
  for (const std::uint32_t seed : {1u, 2u})
    cases.push_back({name + ", lot " + std::to_string(seed), cut_by_lot(mesh, seed), is_sharp});
}

void add_prisms(std::vector<FeatureCase>& cases, int first) {
  for (int n = first; n <= 16; n += 2)
    for (const double h : {0.25, 0.5, 1.0, 2.0, 4.0}) {
      const Outline2 outline = ellipse(n, 1, 1);
      add(cases, "prism " + std::to_string(n) + " x " + text(h), extruded(outline, h),
          n <= 6 ? IsSharp(all) : rims_and(outline));
    }
}

void add_frustum(std::vector<FeatureCase>& cases, int n, double taper) {
  add(cases, "frustum " + std::to_string(n) + ", " + text(taper),
      extruded(ellipse(n, 1, 1), 1, taper), n <= 6 ? all : is_level);
}

// Whether both ends lie on one circle about the axis.
bool is_rim(const dvec3& a, const dvec3& b) {
  return is_level(a, b) && std::abs(glm::length(dvec2(a)) - glm::length(dvec2(b))) < kSame;
}

void add_pipe(std::vector<FeatureCase>& cases, int n, double inner, double height) {
  add(cases, "pipe " + std::to_string(n),
      hollow(ellipse(n, 1, 1), ellipse(n, inner, inner), height), is_rim);
}

void add_extruded(std::vector<FeatureCase>& cases, const std::string& name,
                  const Outline2& outline) {
  add(cases, name, extruded(outline, 1), rims_and(outline));
}

IsSharp ridge_of_radius(double radius) {
  return [radius](const dvec3& a, const dvec3& b) {
    return is_level(a, b) && std::abs(glm::length(dvec2(a)) - radius) < kSame;
  };
}

}  // namespace

Outline2 ellipse(int n, double a, double b) {
  Outline2 outline;
  for (int i = 0; i < n; ++i)
    outline.emplace_back(a * std::cos(kTau * i / n), b * std::sin(kTau * i / n));
  return outline;
}

PolygonMesh extruded(const Outline2& outline, double height, double taper) {
  return of_rings({ring_at(outline, 0), ring_at(outline, height, taper)});
}

PolygonMesh hollow(const Outline2& outer, const Outline2& inner, double height) {
  PolygonMesh mesh;
  const auto n = static_cast<std::int32_t>(outer.size());
  for (const double z : {0.0, height}) {
    for (const dvec3& p : ring_at(outer, z)) mesh.positions.push_back(p);
    for (const dvec3& p : ring_at(inner, z)) mesh.positions.push_back(p);
  }
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t j = (i + 1) % n;
    mesh.add_face(std::array{i, j, 2 * n + j, 2 * n + i});
    mesh.add_face(std::array{n + j, n + i, 3 * n + i, 3 * n + j});
    mesh.add_face(std::array{j, i, n + i, n + j});
    mesh.add_face(std::array{2 * n + i, 2 * n + j, 3 * n + j, 3 * n + i});
  }
  return mesh;
}

PolygonMesh in_fans(const PolygonMesh& mesh) {
  return by_ears(mesh, [](std::size_t) { return std::size_t{1}; });
}

PolygonMesh cut_by_lot(const PolygonMesh& mesh, std::uint32_t seed) {
  std::mt19937 random(seed);
  return by_ears(mesh, [&](std::size_t n) { return random() % n; });
}

std::vector<FeatureCase> tuned_cases() {
  std::vector<FeatureCase> cases;
  add_prisms(cases, 6);
  for (const double h : {0.25, 1.0, 2.7, 4.0})
    add(cases, "box 1 x 1 x " + text(h), extruded(box_outline(1, 1), h), all);
  for (const double taper : {0.5, 0.8})
    for (const int n : {4, 8, 12}) add_frustum(cases, n, taper);
  add(cases, "L", extruded(l_outline(), 1), all);
  for (const double pitch : {30.0, 20.0})
    add(cases, "house, pitch " + text(pitch), house(3, 2, pitch), all);
  for (const double chamfer : {0.1, 0.05})
    add(cases, "box with chamfers of " + text(chamfer), chamfered_box(1, 1, 1, chamfer), all);
  for (const int n : {8, 16}) add_pipe(cases, n, 0.5, 2);
  for (const int n : {8, 16, 32})
    add(cases, "cone " + std::to_string(n), with_base(cone(n, 1), n), ridge_of_radius(1));
  add_extruded(cases, "slot 4", slot_outline(4, 2));
  add_extruded(cases, "rounded box 3", rounded_outline(3, 0.5));
  add(cases, "tetrahedron", tetrahedron(), all);
  add(cases, "octahedron", bipyramid(4), all);
  add(cases, "icosahedron", icosphere(0), none);
  add(cases, "sphere 6 x 4", uv_sphere(6, 4), none);
  add(cases, "sphere 12 x 8", uv_sphere(12, 8), none);
  for (const int n : {8, 12})
    add(cases, "torus " + std::to_string(n), torus(2 * n, n, 1, 0.4), none);
  return cases;
}

std::vector<FeatureCase> held_out_cases() {
  std::vector<FeatureCase> cases;
  add_prisms(cases, 5);
  for (const double h : {0.4, 0.7, 1.7, 3.0})
    add(cases, "box 1 x 1 x " + text(h), extruded(box_outline(1, 1), h), all);
  for (const double taper : {0.3, 0.65, 0.9})
    for (const int n : {5, 9, 16}) add_frustum(cases, n, taper);
  add(cases, "U", extruded(u_outline(), 1), all);
  add(cases, "T", extruded(t_outline(), 0.3), all);
  for (const double pitch : {45.0, 12.0})
    add(cases, "house, pitch " + text(pitch), house(4, 1.5, pitch), all);
  for (const double chamfer : {0.15, 0.02})
    add(cases, "box with chamfers of " + text(chamfer), chamfered_box(2, 1, 0.7, chamfer), all);
  for (const int n : {7, 12, 24}) add_pipe(cases, n, 0.8, 1);
  for (const int n : {10, 24})
    add(cases, "cone " + std::to_string(n), with_base(cone(n, 2), n), ridge_of_radius(1));
  for (const int n : {10, 12, 20})
    add_extruded(cases, "oval " + std::to_string(n), ellipse(n, 1.5, 1));
  add_extruded(cases, "slot 6", slot_outline(6, 1));
  add_extruded(cases, "rounded box 4", rounded_outline(4, 0.3));
  add(cases, "icosphere 1", icosphere(1), none);
  add(cases, "icosphere 2", icosphere(2), none);
  add(cases, "sphere 8 x 6", uv_sphere(8, 6), none);
  add(cases, "sphere 16 x 8", uv_sphere(16, 8), none);
  add(cases, "torus 10", torus(30, 10, 1, 0.3), none);
  // A pipe of six sides, as a prism has.
  add(cases, "torus 6", torus(18, 6, 1, 0.3), is_rim);
  return cases;
}

namespace {

PolygonMesh turned_about(PolygonMesh mesh, const dvec3& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return moved(std::move(mesh), [&](const dvec3& p) {
    return c * p + s * glm::cross(axis, p) + (1 - c) * glm::dot(axis, p) * axis;
  });
}

}  // namespace

PolygonMesh turned(PolygonMesh mesh) {
  return turned_about(std::move(mesh), glm::normalize(dvec3(0.3, -0.7, 0.5)), 1.1);
}

PolygonMesh mirrored(const PolygonMesh& mesh) {
  FaceList faces = faces_of(mesh);
  for (auto& face : faces) std::ranges::reverse(face);
  return moved(make_mesh(mesh.positions, faces),
               [](const dvec3& p) { return dvec3(-p.x, p.y, p.z); });
}

EdgeSet set_of(const std::vector<CreaseEdge>& edges) {
  EdgeSet set;
  for (const CreaseEdge& edge : edges) set.insert(std::minmax(edge.v0, edge.v1));
  return set;
}

namespace {

// Bodies in other meshes.

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
  if (lot.chance(0.3)) {
    what += "; jittered";
    known.mesh = jittered(known.mesh, 1e-12, static_cast<std::uint32_t>(lot.whole(0, 1 << 20)));
  }
  if (lot.chance(0.3)) {
    what += "; mirrored";
    known.mesh = mirrored(known.mesh);
  }
  if (lot.chance(0.6)) {
    what += "; turned";
    const dvec3 axis = glm::normalize(dvec3(lot.real(-1, 1), lot.real(-1, 1), lot.real(-1, 1)) +
                                      dvec3(1e-3, 0, 0));
    known.mesh = turned_about(std::move(known.mesh), axis, lot.real(0, 2 * glm::pi<double>()));
  }
  if (lot.chance(0.3)) {
    what += "; scaled";
    const double scale = lot.ratio(1e-3, 1e3);
    known.mesh = moved(std::move(known.mesh), [&](const dvec3& p) { return scale * p; });
  }
  if (lot.chance(0.3)) {
    what += "; far";
    const dvec3 far =
        1e3 * glm::length(known.mesh.positions[0] - known.mesh.positions[1]) * dvec3(1, -0.7, 0.4);
    known.mesh = moved(std::move(known.mesh), [&](const dvec3& p) { return p + far; });
  }
  if (lot.chance(0.3)) {
    what += "; beside a ball";
    const dvec3 by = known.mesh.positions[0] + dvec3(0, 0, 1e4);
    const PolygonMesh both[] = {known.mesh,
                                moved(icosphere(2), [&](const dvec3& p) { return 10.0 * p + by; })};
    known.mesh = merged_meshes(both).mesh;
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
