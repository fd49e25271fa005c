#include "planish/fair/fair_topology.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/work.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

constexpr std::size_t kTopologyGrain = 4096;

void number_corners(const PolygonMesh& mesh, FairTopology& topology) {
  topology.vertex_count = mesh.vertex_count();
  topology.face_count = mesh.face_count();
  topology.face_offsets = mesh.face_offsets;
  topology.corner_vertices = mesh.face_vertices;
  topology.corner_count = static_cast<std::int32_t>(mesh.face_vertices.size());
}

// Writes the ring of one vertex, whose range of the ring arrays is known.
void write_ring(const VertexRing& ring, std::int32_t vertex, FairTopology& topology) {
  const std::int32_t first = topology.ring_offsets[vertex];
  const std::int32_t n = topology.valence(vertex);
  bool regular = true;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t corner = ring.faces[i];
    const std::int32_t face = topology.corner_faces[corner];
    const std::int32_t face_first = topology.face_offsets[face];
    const std::int32_t face_end = topology.face_offsets[face + 1];
    topology.ring_corners[first + i] = corner;
    topology.ring_next[first + i] =
        topology.corner_vertices[corner + 1 == face_end ? face_first : corner + 1];
    topology.ring_previous[first + i] =
        topology.corner_vertices[corner == face_first ? face_end - 1 : corner - 1];
    topology.corner_ccw[corner] = ring.faces[i + 1 == n ? 0 : i + 1];
    topology.corner_cw[corner] = ring.faces[i == 0 ? n - 1 : i - 1];
    regular = regular && face_end - face_first == 4;
  }
  for (const VertexRing::Sector& sector : ring.sectors) {
    topology.corner_cw[ring.faces[sector.first]] = sector.curve0;
    topology.corner_ccw[ring.faces[sector.first + sector.count - 1]] = sector.curve1;
  }
  topology.is_regular[vertex] = regular;
}

void gather_rings(const Subdivision& subdivision, FairTopology& topology) {
  topology.corner_faces = subdivision.topology().corner_faces();
  topology.ring_offsets = subdivision.topology().corner_offsets();
  const auto vertex_count = static_cast<std::size_t>(topology.vertex_count);
  const auto corner_count = static_cast<std::size_t>(topology.corner_count);
  for (auto* array : {&topology.ring_corners, &topology.ring_next, &topology.ring_previous,
                      &topology.corner_ccw, &topology.corner_cw}) {
    *array = std::vector<std::int32_t>(corner_count);
  }
  topology.is_regular.resize(vertex_count);
  topology.kinds.resize(vertex_count);
  std::transform(subdivision.features().vertex_kinds.begin(),
                 subdivision.features().vertex_kinds.end(), topology.kinds.begin(),
                 [](VertexKind kind) { return static_cast<std::uint8_t>(kind); });
  parallel_for(vertex_count, kTopologyGrain, [&](std::size_t begin, std::size_t end) {
    VertexRing ring;
    for (std::size_t v = begin; v < end; ++v) {
      gather_ring(subdivision, static_cast<std::int32_t>(v), ring);
      write_ring(ring, static_cast<std::int32_t>(v), topology);
    }
  });
}

void gather_sharp_places(const Subdivision& subdivision, FairTopology& topology) {
  topology.corner_points = subdivision.features().corner_vertices;
  topology.sector_offsets.push_back(0);
  if (!subdivision.has_sharp_edges()) return;

  const MeshTopology& base = subdivision.topology();
  topology.curve_points.resize(2 *
                               static_cast<std::size_t>(subdivision.features().sharp_edge_count));
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const auto [v0, v1] =
        base.edge_vertices(subdivision.edge_of_sharp(static_cast<std::int32_t>(s / 2)));
    topology.curve_points[s] = {s % 2 == 0 ? v0 : v1, s % 2 == 0 ? v1 : v0, -1, -1};
  }

  VertexRing ring;
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
    const VertexKind kind = topology.kind(v);
    if (kind != VertexKind::Crease && kind != VertexKind::Dart) continue;
    gather_ring(subdivision, v, ring);
    if (kind == VertexKind::Dart) {
      for (const std::int32_t corner : base.corners_at(v)) {
        const std::int32_t edge = base.edge_of(corner);
        const std::int32_t sharp = subdivision.sharp_of_edge(edge);
        if (sharp < 0) continue;
        const int end = base.edge_vertices(edge).first == v ? 0 : 1;
        topology.curve_points[2 * sharp + end].corner_after = ring.faces[ring.dart_face];
        topology.curve_points[2 * sharp + end].corner_before =
            topology.corner_cw[ring.faces[ring.dart_face]];
      }
      continue;
    }
    if (topology.crease_of_vertex.empty()) {
      topology.crease_of_vertex.assign(static_cast<std::size_t>(topology.vertex_count), -1);
    }
    topology.crease_of_vertex[v] = static_cast<std::int32_t>(topology.crease_vertices.size());
    topology.crease_vertices.push_back(v);
    for (const VertexRing::Sector& sector : ring.sectors) {
      topology.sectors.push_back(
          {v, topology.ring_offsets[v] + sector.first, sector.count, sector.curve0, sector.curve1});
    }
    topology.sector_offsets.push_back(static_cast<std::int32_t>(topology.sectors.size()));
  }
}

void mark_near_curves(FairTopology& topology, FairHalo* halo) {
  std::vector<std::uint8_t>& near = topology.is_near_curve;
  near.resize(static_cast<std::size_t>(topology.vertex_count));
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) near[v] = !topology.has_polygon(v);
  if (!halo && std::find(near.begin(), near.end(), 1) == near.end()) return;
  constexpr int kEdges = 2;
  for (int edge = 0; edge < kEdges; ++edge) {
    if (halo) halo->exchange_vertices(near);
    const std::vector<std::uint8_t> last = near;
    for (std::int32_t v = 0; v < topology.vertex_count; ++v) {
      const FairTopology::Ring ring = topology.ring(v);
      for (std::int32_t i = 0; i < ring.size(); ++i)
        near[v] |= last[ring.next[i]] | last[ring.previous[i]];
    }
  }
  if (halo) halo->exchange_vertices(near);
}

void gather_edges(const Subdivision& subdivision, FairTopology& topology) {
  const MeshTopology& base = subdivision.topology();
  const auto count = static_cast<std::size_t>(base.edge_count());
  const auto is_smooth = [&](std::int32_t e) { return subdivision.sharp_of_edge(e) < 0; };
  const SelectedBlocks blocks = count_selected(count, is_smooth);
  topology.edge_corners.resize(static_cast<std::size_t>(blocks.total));
  for_selected(count, blocks, is_smooth, [&](std::size_t e, std::int32_t number) {
    topology.edge_corners[number] = base.corner_of(static_cast<std::int32_t>(e));
  });
}

void fill_unit_circle(FairTopology& topology) {
  std::vector<bool> arises;
  const auto mark = [&](std::int32_t n) {
    if (static_cast<std::size_t>(n) >= arises.size())
      arises.resize(static_cast<std::size_t>(n) + 1);
    arises[n] = true;
  };
  for (std::int32_t f = 0; f < topology.face_count; ++f) mark(topology.face_size(f));
  for (std::int32_t v = 0; v < topology.vertex_count; ++v) mark(topology.valence(v));

  FairTopology::UnitCircle& circle = topology.unit_circle;
  circle.offsets.assign(arises.size(), -1);
  for (std::size_t n = 0; n < arises.size(); ++n) {
    if (!arises[n]) continue;
    circle.offsets[n] = static_cast<std::int32_t>(circle.points.size());
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
      circle.points.emplace_back(portable::cos(angle), portable::sin(angle));
    }
  }
}

}  // namespace

FairTopology make_fair_topology(const PolygonMesh& mesh, const Subdivision& subdivision,
                                FairHalo* halo) {
  FairTopology topology;
  topology.state_size = subdivision.state_size();
  number_corners(mesh, topology);
  gather_rings(subdivision, topology);
  gather_sharp_places(subdivision, topology);
  mark_near_curves(topology, halo);
  gather_edges(subdivision, topology);
  fill_unit_circle(topology);
  for (std::int32_t f = 0; f < topology.face_count; ++f)
    if (topology.face_size(f) >= topology.large_size) topology.large_faces.push_back(f);
  return topology;
}

std::vector<KeptPlane> kept_planes(const PolygonMesh& mesh, const Subdivision& subdivision) {
  const MeshTopology& topology = subdivision.topology();
  std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e)
    is_sharp[e] = subdivision.sharp_of_edge(e) >= 0 ? 1 : 0;
  return find_kept_planes(mesh, topology, is_sharp);
}

PlanePlaces plane_places(const FairTopology& topology, std::span<const KeptPlane> planes) {
  PlanePlaces places;
  if (planes.empty()) return places;
  places.of_vertex.assign(static_cast<std::size_t>(topology.vertex_count), -1);
  places.of_sector.assign(topology.sectors.size(), -1);
  for (const auto& [vertex, face] : planes) {
    if (topology.kind(vertex) == VertexKind::Corner) continue;
    places.of_vertex[vertex] = face;
    if (topology.has_polygon(vertex)) continue;
    const std::int32_t crease = topology.crease_of_vertex[vertex];
    for (std::int32_t s = topology.sector_offsets[crease]; s < topology.sector_offsets[crease + 1];
         ++s) {
      const auto is_of_plane = [&](std::int32_t corner) {
        return topology.corner_faces[corner] == face;
      };
      if (std::ranges::any_of(topology.ring(topology.sectors[s]).corners, is_of_plane))
        places.of_sector[s] = face;
    }
  }
  return places;
}

using glm::dvec2;
using glm::dvec3;

dvec2 VertexFrame::project(const dvec3& vector) const {
  return {glm::dot(vector, tangent1), glm::dot(vector, tangent2)};
}

namespace {

constexpr std::size_t kFrameGrain = 8192;
constexpr std::size_t kVertexGrain = 1024;
// Of the sum of the angles: a normal below this is what cancellation left.
constexpr double kCancelled = 1e-6;

// Cosine between a corner's own normal and its face's from which the corner's counts alone; and
// sine of its angle: straight corners have no normal of their own.
constexpr double kOwnNormalCosine = 0.5;
constexpr double kStraightSine = 0.05;

dvec3 normalised(const dvec3& vector) {
  const double length = glm::length(vector);
  return length > 0 ? vector / length : dvec3(0.0, 0.0, 1.0);
}

// How far a corner's own normal counts, 0 to 1; the rest is its face's.
double own_normal_part(const dvec3& a, const dvec3& b, const dvec3& turn, double length,
                       const dvec3& face_normal) {
  const double cosine = glm::dot(turn, face_normal) / length;
  const double sine = length / std::sqrt(glm::dot(a, a) * glm::dot(b, b));
  return std::clamp(cosine / kOwnNormalCosine, 0.0, 1.0) * std::min(sine / kStraightSine, 1.0);
}

// The angle from a to b counter-clockwise about a unit normal, 0 to a full turn.
double angle_about(const dvec3& a, const dvec3& b, const dvec3& turn, const dvec3& normal) {
  const double cosine = glm::dot(a, b) - glm::dot(a, normal) * glm::dot(b, normal);
  const double angle = portable::atan2(glm::dot(turn, normal), cosine);
  return angle < 0 ? angle + 2 * std::numbers::pi : angle;
}

}  // namespace

std::vector<dvec3> unit_face_normals(const FairTopology& topology, std::span<const dvec3> given) {
  std::vector<dvec3> normals(static_cast<std::size_t>(topology.face_count));
  parallel_each(normals.size(), kFrameGrain, [&](std::int32_t face) {
    normals[face] = normalised(area_vector(given, topology.face(face)));
  });
  return normals;
}

dvec3 angle_weighted_normal(const FairTopology& topology, std::span<const dvec3> given,
                            std::span<const dvec3> face_normals, std::int32_t vertex,
                            const FairTopology::Ring& ring) {
  dvec3 sum(0.0);
  double angles = 0;
  for (std::int32_t i = 0; i < ring.size(); ++i) {
    const dvec3 a = given[ring.next[i]] - given[vertex];
    const dvec3 b = given[ring.previous[i]] - given[vertex];
    const dvec3 turn = glm::cross(a, b);
    const double length = glm::length(turn);
    const std::int32_t face = topology.corner_faces[ring.corners[i]];
    double own_part = 0;
    if (length > 0) {
      own_part = own_normal_part(a, b, turn, length, face_normals[face]);
      const double own_angle = own_part * portable::atan2(length, glm::dot(a, b));
      angles += own_angle;
      sum += own_angle / length * turn;
    } else if (topology.face_size(face) == 3) {
      continue;  // without area: its face has no normal either
    }
    if (own_part == 1) continue;
    const double face_angle = (1 - own_part) * angle_about(a, b, turn, face_normals[face]);
    angles += face_angle;
    sum += face_angle * face_normals[face];
  }
  const double length = glm::length(sum);
  if (length > kCancelled * angles) return sum / length;
  sum = dvec3(0.0);
  for (const std::int32_t corner : ring.corners) sum += face_normals[topology.corner_faces[corner]];
  return normalised(sum);
}

std::vector<dvec3> vertex_normals(const FairTopology& topology, std::span<const dvec3> given,
                                  std::span<const dvec3> face_normals, const PlanePlaces& planes) {
  std::vector<dvec3> normals(given.size());
  parallel_each(normals.size(), kVertexGrain, [&](std::int32_t v) {
    const std::int32_t plane = planes.of(v);
    normals[v] = plane >= 0
                     ? face_normals[plane]
                     : angle_weighted_normal(topology, given, face_normals, v, topology.ring(v));
  });
  return normals;
}

// Source: Duff et al., "Building an orthonormal basis, revisited", 2017.
VertexFrame frame_of(const dvec3& n) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1.0 / (sign + n.z);
  const double b = n.x * n.y * a;
  return {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

dvec2 ring_direction(const FairTopology& topology, std::span<const dvec3> given,
                     std::int32_t vertex, const VertexFrame& frame) {
  const auto next = topology.ring(vertex).next;
  const auto circle = topology.unit_circle.of(topology.valence(vertex));
  dvec2 sum(0.0);
  for (std::size_t i = 0; i < next.size(); ++i) {
    const dvec2 edge = frame.project(given[next[i]] - given[vertex]);
    const double length = glm::length(edge);
    if (!(length > 0)) continue;
    // Turned back by the place's angle.
    sum += dvec2(edge.x * circle[i].x + edge.y * circle[i].y,
                 edge.y * circle[i].x - edge.x * circle[i].y) /
           length;
  }
  const double length = glm::length(sum);
  return length > 0 ? sum / length : dvec2(1.0, 0.0);
}

RingAxes ring_axes(const FairTopology& topology, std::span<const dvec3> given, std::int32_t vertex,
                   const dvec3& normal) {
  const VertexFrame frame = frame_of(normal);
  const dvec2 direction = ring_direction(topology, given, vertex, frame);
  return {direction.x * frame.tangent1 + direction.y * frame.tangent2,
          direction.x * frame.tangent2 - direction.y * frame.tangent1};
}

glm::vec2 lean_towards(const FairTopology& topology, std::span<const dvec3> given,
                       std::int32_t vertex, const dvec3& normal, const dvec3& target) {
  if (target == normal) return glm::vec2(0.0F);
  const RingAxes axes = ring_axes(topology, given, vertex, normal);
  const dvec2 flat(glm::dot(target, axes.along), glm::dot(target, axes.left));
  const double sine = glm::length(flat);
  if (!(sine > 0)) return glm::vec2(0.0F);
  return glm::vec2(portable::atan2(sine, glm::dot(target, normal)) / sine * flat);
}

dvec3 leaning_normal(const FairTopology& topology, std::span<const dvec3> given,
                     std::int32_t vertex, const dvec3& normal, const glm::vec2& lean) {
  const dvec2 wanted(lean);
  const double angle = glm::length(wanted);
  if (!(angle > 0)) return normal;
  const RingAxes axes = ring_axes(topology, given, vertex, normal);
  return portable::cos(angle) * normal +
         portable::sin(angle) / angle * (wanted.x * axes.along + wanted.y * axes.left);
}

namespace {

// Based on: Doo & Sabin 1978. Their weights are 1/4 at the vertex, 3/4 for the mean and a first
// Fourier term: X_i = P_i / 4 + 3/4 mean + (cos_i C + sin_i S) / (2 m), C = sum cos_j P_j.

constexpr std::size_t kOffsetGrain = 8192;

struct FaceStep {
  const FairTopology& topology;
  std::span<const dvec3> given, points;
  std::span<dvec3> offsets;

  void triangle(std::int32_t first) const {
    const std::int32_t* v = &topology.corner_vertices[first];
    for (int i = 0; i < 3; ++i) {
      const dvec3& own = points[v[i]];
      offsets[first + i] = (own - given[v[i]]) + (points[v[(i + 1) % 3]] - own) / 6.0 +
                           (points[v[(i + 2) % 3]] - own) / 6.0;
    }
  }

  void quad(std::int32_t first) const {
    const std::int32_t* v = &topology.corner_vertices[first];
    for (int i = 0; i < 4; ++i) {
      const dvec3& own = points[v[i]];
      offsets[first + i] = (own - given[v[i]]) +
                           (3.0 * (points[v[(i + 1) % 4]] - own) +
                            3.0 * (points[v[(i + 3) % 4]] - own) + (points[v[(i + 2) % 4]] - own)) /
                               16.0;
    }
  }

  // From the place `to` of the offsets on.
  void polygon(std::int32_t first, std::int32_t to, std::int32_t m) const {
    const std::int32_t* v = &topology.corner_vertices[first];
    const auto circle = topology.unit_circle.of(m);
    const dvec3 origin = points[v[0]];
    dvec3 mean(0.0), cosine_sum(0.0), sine_sum(0.0);
    for (std::int32_t i = 0; i < m; ++i) {
      const dvec3 p = points[v[i]] - origin;
      mean += p;
      cosine_sum += circle[i].x * p;
      sine_sum += circle[i].y * p;
    }
    mean /= m;
    for (std::int32_t i = 0; i < m; ++i) {
      const dvec3 p = points[v[i]] - origin;
      offsets[to + i] = (origin - given[v[i]]) + 0.25 * p + 0.75 * mean +
                        (circle[i].x * cosine_sum + circle[i].y * sine_sum) / (2.0 * m);
    }
  }
};

}  // namespace

void corner_offsets(const FairTopology& topology, std::span<const dvec3> given,
                    std::span<const dvec3> points, std::span<dvec3> offsets) {
  const FaceStep step{topology, given, points, offsets};
  parallel_for(static_cast<std::size_t>(topology.face_count), kOffsetGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (auto f = static_cast<std::int32_t>(begin); f < static_cast<std::int32_t>(end);
                      ++f) {
                   const std::int32_t first = topology.face_offsets[f];
                   const std::int32_t m = topology.face_size(f);
                   if (m == 3) {
                     step.triangle(first);
                   } else if (m == 4) {
                     step.quad(first);
                   } else {
                     step.polygon(first, first, m);
                   }
                 }
               });
}

GivenStep::GivenStep(const FairTopology& topology, std::span<const dvec3> given)
    : topology_(topology), given_(given) {
  for (const std::int32_t face : topology.large_faces) {
    std::vector<dvec3>& offsets = of_large_.emplace_back();
    offsets.resize(static_cast<std::size_t>(topology.face_size(face)));
    FaceStep{topology, given, given, offsets}.polygon(topology.face_offsets[face], 0,
                                                      topology.face_size(face));
  }
}

dvec3 GivenStep::offset(std::int32_t corner) const {
  const std::int32_t face = topology_.corner_faces[corner];
  const std::int32_t first = topology_.face_offsets[face], m = topology_.face_size(face);
  if (const std::int32_t large = topology_.large_face(face); large >= 0)
    return of_large_[large][corner - first];
  count_work(Work::Points, m);
  const auto circle = topology_.unit_circle.of(m);
  const dvec3& own = given_[topology_.corner_vertices[corner]];
  dvec3 sum(0.0);
  for (std::int32_t i = 0; i < m; ++i) {
    const std::int32_t place = corner - first + i;
    sum += (3 + 2 * circle[i].x) * (given_[topology_.corner_vertices[first + place % m]] - own);
  }
  return sum / (4.0 * m);
}

// Based on: "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", section 3.2: the
// iteration of progressive interpolation, here weighted per vertex.

namespace {

constexpr std::size_t kStepGrain = 8192;
constexpr int kSteps = 3;

}  // namespace

dvec3 limit_error(const FairTopology& topology, std::span<const dvec3> given,
                  std::span<const dvec3> points, std::span<const dvec3> offsets,
                  std::int32_t vertex) {
  if (topology.has_polygon(vertex)) {
    dvec3 sum(0.0);
    for (const std::int32_t corner : topology.ring(vertex).corners) sum += offsets[corner];
    return sum / static_cast<double>(topology.valence(vertex));
  }
  if (topology.kind(vertex) == VertexKind::Corner) return dvec3(0.0);
  const auto [before, after] = topology.crease_neighbours(vertex);
  const dvec3& own = points[vertex];
  return (own - given[vertex]) + ((points[before] - own) + (points[after] - own)) / 8.0;
}

std::vector<dvec3> masked_iteration(const FairTopology& topology, std::span<const dvec3> given,
                                    std::span<const double> shares, std::span<dvec3> offsets,
                                    FairHalo* halo) {
  std::vector<dvec3> points(given.begin(), given.end());
  std::vector<dvec3> next = points;
  for (int step = 0; step < kSteps; ++step) {
    parallel_each(points.size(), kStepGrain, [&](std::int32_t v) {
      if (shares[v] <= 0) return;
      next[v] = points[v] - shares[v] * limit_error(topology, given, points, offsets, v);
    });
    std::swap(points, next);
    if (halo) halo->exchange_vertices(points);
    corner_offsets(topology, given, points, offsets);
  }
  return points;
}

}  // namespace planish
