#include "planish/refine/guess_surface.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/mesh/angle_between.h"

namespace planish {
namespace {

constexpr int kBlends = 2;
constexpr int kLooks = 4;             // parts of a face's edges
constexpr double kLeastRidge = 0.52;  // 30 degrees, between faces

}  // namespace

GuessSurface::GuessSurface(std::span<const glm::dvec3> positions, const MeshTopology& topology,
                           std::span<const char> is_line, std::span<const char> is_sharp)
    : positions_(positions),
      topology_(topology),
      jets_(fit_vertex_jets(positions, topology, is_sharp)) {
  make_curves(is_line, is_sharp);
  is_flat_.assign(topology.face_count(), 0);
  std::vector<char> is_flat(topology.face_count());
  parallel_each(is_flat.size(), 64,
                [&](std::size_t f) { is_flat[f] = turns_too_far(static_cast<std::int32_t>(f)); });
  parallel_each(static_cast<std::size_t>(topology.edge_count()), 64, [&](std::size_t e) {
    const std::int32_t corner = topology.corner_of(static_cast<std::int32_t>(e));
    const std::int32_t twin = topology.twin(corner);
    if (twin < 0 || is_sharp[e] || !is_ridge(corner, twin)) return;
    for (const std::int32_t side : {corner, twin})
      std::atomic_ref(is_flat[topology.face_of(side)]).store(1, std::memory_order_relaxed);
  });
  is_flat_ = std::move(is_flat);
}

// Whether the guess turns by more than faces may where two of them meet. Where these turn by little
// it may between slivers, which is no ridge.
bool GuessSurface::is_ridge(std::int32_t corner, std::int32_t twin) const {
  if (angle_between(face_normal(topology_.face_of(corner)), face_normal(topology_.face_of(twin))) <
      kLeastRidge)
    return false;
  const auto place = [&](std::int32_t side, double along, double inwards) {
    FacePlace made{topology_.face_of(side), glm::dvec3(0)};
    const int i = topology_.place_of(side);
    made.weights[i] = (1 - along) * (1 - inwards);
    made.weights[(i + 1) % 3] = along * (1 - inwards);
    made.weights[(i + 2) % 3] = inwards;
    return at(made);
  };
  for (int k = 0; k < kLooks; ++k) {
    const double begin = static_cast<double>(k) / kLooks, end = begin + 1.0 / kLooks;
    const double middle = (begin + end) / 2;
    const glm::dvec3 p = place(corner, begin, 0), q = place(corner, end, 0);
    const glm::dvec3 left = glm::cross(q - p, place(corner, middle, 1.0 / kLooks) - p);
    const glm::dvec3 right = glm::cross(place(twin, 1 - middle, 1.0 / kLooks) - p, q - p);
    if (!(glm::dot(left, right) >= kLeastSmoothCosine * glm::length(left) * glm::length(right)))
      return true;
  }
  return false;
}

bool GuessSurface::turns_too_far(std::int32_t face) const {
  std::array<glm::dvec3, (kLooks + 1) * (kLooks + 2) / 2> points;
  const auto number = [](int i, int j) { return (i + j) * (i + j + 1) / 2 + j; };
  for (int i = 0; i <= kLooks; ++i)
    for (int j = 0; i + j <= kLooks; ++j)
      points[number(i, j)] = at({face, glm::dvec3(kLooks - i - j, i, j) / double(kLooks)});
  const glm::dvec3 normal = face_normal(face);
  const auto turns = [&](const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r) {
    const glm::dvec3 part = glm::cross(q - p, r - p);
    return !(glm::dot(part, normal) >=
             kLeastSmoothCosine * glm::length(part) * glm::length(normal));
  };
  for (int i = 0; i < kLooks; ++i) {
    for (int j = 0; i + j < kLooks; ++j) {
      const glm::dvec3 &p = points[number(i, j)], &q = points[number(i + 1, j)],
                       &r = points[number(i, j + 1)];
      if (turns(p, q, r)) return true;
      if (i + j + 1 < kLooks && turns(q, points[number(i + 1, j + 1)], r)) return true;
    }
  }
  return false;
}

void GuessSurface::make_curves(std::span<const char> is_line, std::span<const char> is_sharp) {
  const std::int32_t edges = topology_.edge_count();
  const auto ends_surface = [&](std::int32_t edge) {
    return is_sharp[edge] || topology_.is_boundary_edge(edge);
  };
  // Others are only too sharp to be guessed, and stay straight.
  const auto is_curved = [&](std::int32_t edge) {
    return topology_.is_boundary_edge(edge) || (is_line[edge] && is_sharp[edge]);
  };
  // The one or two lines at a vertex, -1: none, -2: more than two.
  std::vector<std::array<std::int32_t, 2>> lines(topology_.vertex_count(), {-1, -1});
  for (std::int32_t e = 0; e < edges; ++e) {
    if (!is_curved(e)) continue;
    const auto [a, b] = topology_.edge_vertices(e);
    for (const std::int32_t v : {a, b}) {
      auto& two = lines[v];
      if (two[0] == -1) {
        two[0] = e;
      } else {
        two[1] = two[1] == -1 ? e : -2;
      }
    }
  }
  // Direction at a vertex from vertex `from` on: of the circle through three vertices of a line.
  const auto direction = [&](std::int32_t v, std::int32_t edge) {
    const auto [a, b] = topology_.edge_vertices(edge);
    const std::int32_t far = a == v ? b : a;
    const glm::dvec3 along = positions_[far] - positions_[v];
    const auto& two = lines[v];
    if (!is_curved(edge) || two[1] < 0) return along;
    const std::int32_t other = two[0] == edge ? two[1] : two[0];
    const auto [c, d] = topology_.edge_vertices(other);
    const glm::dvec3 back = positions_[v] - positions_[c == v ? d : c];
    const double l1 = glm::dot(along, along), l0 = glm::dot(back, back);
    if (!(l0 > 0) || !(l1 > 0) || glm::dot(along, back) < kLeastSmoothCosine * std::sqrt(l0 * l1))
      return along;
    const glm::dvec3 tangent = along / l1 + back / l0;
    return tangent * (std::sqrt(l1) / glm::length(tangent));
  };
  curve_of_corner_.assign(topology_.corner_count(), -1);
  for (std::int32_t e = 0; e < edges; ++e) {
    if (!ends_surface(e)) continue;
    const std::int32_t corner = topology_.corner_of(e), twin = topology_.twin(corner);
    const auto [a, b] = topology_.edge_vertices(e);
    const glm::dvec3 begin = direction(a, e), end = -direction(b, e);
    curve_of_corner_[corner] = static_cast<std::int32_t>(curves_.size());
    curves_.push_back({begin, end});
    if (twin < 0) continue;
    curve_of_corner_[twin] = static_cast<std::int32_t>(curves_.size());
    curves_.push_back({-end, -begin});
  }
}

glm::dvec3 GuessSurface::curve_point(std::int32_t corner, double t) const {
  const Curve& curve = curves_[curve_of_corner_[corner]];
  const glm::dvec3 p = positions_[topology_.vertex_of(corner)];
  const glm::dvec3 q = positions_[topology_.vertex_of(topology_.next(corner))];
  const double s = 1 - t;
  return s * s * (1 + 2 * t) * p + t * t * (1 + 2 * s) * q +
         s * t * (s * curve.begin - t * curve.end);
}

glm::dvec3 GuessSurface::face_normal(std::int32_t face) const {
  const std::span<const std::int32_t> v = topology_.face(face);
  const glm::dvec3& a = positions_[v[0]];
  return glm::cross(positions_[v[1]] - a, positions_[v[2]] - a);
}

glm::dvec3 GuessSurface::flat_point(const FacePlace& place) const {
  const std::span<const std::int32_t> v = topology_.face(place.face);
  return place.weights.x * positions_[v[0]] + place.weights.y * positions_[v[1]] +
         place.weights.z * positions_[v[2]];
}

glm::dvec3 GuessSurface::blend(const FacePlace& place) const {
  const std::int32_t first = topology_.first_corner(place.face);
  glm::dvec3 weights = place.weights * place.weights;
  weights /= weights.x + weights.y + weights.z;
  glm::dvec3 point = flat_point(place);
  for (int round = 0; round < kBlends; ++round) {
    glm::dvec3 sum(0);
    for (int i = 0; i < 3; ++i)
      if (weights[i] > 0)
        sum += weights[i] * jets_.jets[jets_.jet_of_corner[first + i]].on_jet(point);
    point = sum;
  }
  return point;
}

glm::dmat3 GuessSurface::turning(std::int32_t vertex) const {
  glm::dmat3 turning(0);
  double most = 0;
  for (const std::int32_t corner : topology_.corners_at(vertex)) {
    const VertexJet& jet = jets_.jets[jets_.jet_of_corner[corner]];
    const auto& [a, b, c] = jet.quadric;
    const double bending = a * a + 2 * b * b + c * c;
    if (!(bending > most)) continue;
    most = bending;
    // Where e1 and e2 turn the normal to.
    const glm::dvec3 u = a * jet.e1 + b * jet.e2, v = b * jet.e1 + c * jet.e2;
    turning = glm::outerProduct(u, u) + glm::outerProduct(v, v);
  }
  return turning;
}

glm::dvec3 GuessSurface::at(const FacePlace& place) const {
  const std::int32_t first = topology_.first_corner(place.face);
  if (is_flat_[place.face]) return flat_point(place);
  glm::dvec3 point = blend(place);
  for (int i = 0; i < 3; ++i) {
    if (curve_of_corner_[first + i] < 0) continue;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double along = place.weights[i] + place.weights[j];
    if (!(along > 0)) continue;
    const double share = place.weights[j] / along;
    FacePlace foot{place.face, glm::dvec3(0)};
    foot.weights[i] = 1 - share;
    foot.weights[j] = share;
    const double fade = (1 - place.weights[k]) * (1 - place.weights[k]);
    point += fade * (curve_point(first + i, share) - blend(foot));
  }
  return point;
}

}  // namespace planish
