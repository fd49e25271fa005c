#include "planish/doosabin/subdivision.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <unordered_map>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/doosabin/vertex_ring.h"
#include "planish/mesh/face_geometry.h"
#include "planish/solve/stencil_builder.h"

namespace planish {

// Based on: Doo & Sabin, "Behaviour of recursive division surfaces near extraordinary points",
// 1978; "Smooth Surface Reconstruction using Doo-Sabin Subdivision Surfaces", equation (1).

std::vector<double> face_weights(Weights weights, std::int32_t m) {
  PLANISH_ASSERT(m >= 2);
  std::vector<double> c(static_cast<std::size_t>(m), 0.0);
  if (weights == Weights::Averaged) {
    // Own vertex 1/4 + 2 * 1/8 (both edge midpoints), each neighbour 1/8, centroid 1/(4m). Adding
    // the parts makes m = 2 right, where both neighbours are the same vertex.
    for (double& weight : c) weight = 0.25 / m;
    c[0] += 0.5;
    c[1] += 0.125;
    c[m - 1] += 0.125;
  } else {
    for (std::int32_t j = 0; j < m; ++j) {
      c[j] = (3.0 + 2.0 * portable::cos(2.0 * std::numbers::pi * j / m)) / (4.0 * m);
    }
    c[0] += 0.25;
  }
  return c;
}

FaceWeights::FaceWeights(Weights weights) : weights_(weights) {
  for (std::int32_t m = 2; m <= kCachedSize; ++m) cached_[m] = face_weights(weights, m);
}

std::span<const double> FaceWeights::of(std::int32_t m, std::vector<double>& scratch) const {
  if (m <= kCachedSize) return cached_[m];
  if (static_cast<std::int32_t>(scratch.size()) != m) scratch = face_weights(weights_, m);
  return scratch;
}

double smallest_face_eigenvalue(Weights weights, std::int32_t m) {
  if (weights == Weights::Averaged) {
    // 1/2 + cos(2 pi k / m) / 4 with the k nearest to m/2.
    return m % 2 == 0 ? 0.25 : 0.5 - portable::cos(std::numbers::pi / m) / 4.0;
  }
  return m <= 3 ? 0.5 : 0.25;
}

namespace {

// Creases, corners and darts for Doo-Sabin surfaces: sharp edges cut the faces around a vertex
// into sectors that are continued each by its own rule; a derivation of our own after Nasri,
// "Polyhedral subdivision methods for free-form surfaces", 1987, for boundaries.

// A T-junction or a tagged vertex on a straight boundary is rarely straight to the last bit; up
// to 30 degrees off, the half-plane rule still gives the better-shaped sector.
constexpr double kStraightAngleTolerance = std::numbers::pi / 6.0;

// Of faces; those of large ones are kept, as many of their corners may ask.
class FaceAreas {
 public:
  FaceAreas(const PolygonMesh& of_mesh, std::span<const glm::dvec3> at_positions)
      : mesh(of_mesh), positions(at_positions) {}

  [[nodiscard]] glm::dvec3 of(std::int32_t face) {
    if (mesh.face_size(face) < kKeptSize) return area_vector(positions, mesh.face(face));
    const auto [place, is_new] = kept_.try_emplace(face);
    if (is_new) place->second = area_vector(positions, mesh.face(face));
    return place->second;
  }

  const PolygonMesh& mesh;
  std::span<const glm::dvec3> positions;

 private:
  static constexpr std::int32_t kKeptSize = 32;
  std::unordered_map<std::int32_t, glm::dvec3> kept_;
};

// Interior angle of a face at its corner, in [0, 2 pi): more than pi where the face is concave.
double interior_angle(FaceAreas& areas, std::int32_t face, std::int32_t corner) {
  const auto vertices = areas.mesh.face(face);
  const auto positions = areas.positions;
  const std::size_t m = vertices.size();
  const glm::dvec3& apex = positions[vertices[corner]];
  const glm::dvec3 next = positions[vertices[(corner + 1) % m]] - apex;
  const glm::dvec3 previous = positions[vertices[(corner + m - 1) % m]] - apex;
  const glm::dvec3 turn = glm::cross(next, previous);
  const double angle = portable::atan2(glm::length(turn), glm::dot(next, previous));
  return glm::dot(turn, areas.of(face)) < 0 ? 2.0 * std::numbers::pi - angle : angle;
}

CornerSector classify_angle(double angle) {
  if (std::abs(angle - std::numbers::pi) <= kStraightAngleTolerance) return CornerSector::HalfPlane;
  return angle > std::numbers::pi ? CornerSector::Reflex : CornerSector::Convex;
}

// Where an edge is tagged twice, the later tag holds, as in OpenSubdiv.
std::vector<std::uint8_t> tagged_edges(const PolygonMesh& mesh, const MeshTopology& topology) {
  if (mesh.creases.empty()) return {};
  std::vector<std::uint8_t> tagged(static_cast<std::size_t>(topology.edge_count()), 0);
  for (const CreaseEdge& crease : mesh.creases) {
    const std::int32_t edge = topology.find_edge(crease.v0, crease.v1);
    if (edge >= 0) tagged[edge] = crease.sharpness >= kInfiniteSharpness ? 1 : 0;
  }
  return tagged;
}

void number_sharp_edges(const PolygonMesh& mesh, const MeshTopology& topology, bool use_tags,
                        SharpFeatures& features) {
  const std::vector<std::uint8_t> tagged =
      use_tags ? tagged_edges(mesh, topology) : std::vector<std::uint8_t>();
  const auto count = static_cast<std::size_t>(topology.edge_count());
  const auto is_boundary = [&](std::int32_t e) { return topology.is_boundary_edge(e); };
  const auto is_sharp = [&](std::size_t e) {
    return (!tagged.empty() && tagged[e] != 0) || is_boundary(e);
  };
  const SelectedBlocks blocks = count_selected(count, is_sharp);
  features.sharp_edge_count = blocks.total;
  if (blocks.total == 0) return;
  features.interior_sharp_edge_count = blocks.total - count_selected(count, is_boundary).total;
  features.sharp_of_edge.assign(count, -1);
  for_selected(count, blocks, is_sharp,
               [&](std::size_t e, std::int32_t number) { features.sharp_of_edge[e] = number; });
}

VertexKind kind_by_edges(const MeshTopology& topology, const SharpFeatures& features,
                         std::int32_t vertex) {
  int sharp = 0;
  const auto corners = topology.corners_at(vertex);
  for (const std::int32_t corner : corners)
    sharp += features.sharp_of_edge[topology.edge_of(corner)] >= 0 ? 1 : 0;
  if (topology.is_boundary_vertex(vertex)) ++sharp;  // the last corner's trailing edge
  return static_cast<VertexKind>(std::min(sharp, 3));
}

void classify_vertices(const PolygonMesh& mesh, const MeshTopology& topology,
                       const SharpFeatureOptions& options, SharpFeatures& features) {
  features.vertex_kinds.assign(static_cast<std::size_t>(mesh.vertex_count()), VertexKind::Smooth);
  if (features.sharp_edge_count > 0) {
    parallel_each(features.vertex_kinds.size(), [&](std::int32_t vertex) {
      features.vertex_kinds[vertex] = kind_by_edges(topology, features, vertex);
      if (options.boundary == BoundaryRule::EdgeAndCorner && topology.is_boundary_vertex(vertex) &&
          topology.corners_at(vertex).size() == 1) {
        features.vertex_kinds[vertex] = VertexKind::Corner;
      }
    });
  }
  if (options.use_tags) {
    for (const CornerVertex& corner : mesh.corners) {
      if (corner.sharpness >= kInfiniteSharpness) {
        features.vertex_kinds[corner.vertex] = VertexKind::Corner;
      }
    }
  }
}

// Walks the faces around a corner and sums the angles from one sharp edge to the next.
void classify_sectors(const MeshTopology& topology, std::int32_t vertex, FaceAreas& areas,
                      SharpFeatures& features) {
  const auto corners = topology.corners_at(vertex);
  const std::size_t n = corners.size();
  const auto leading_sharp_edge = [&](std::size_t i) {
    return features.sharp_of_edge[topology.edge_of(corners[i])];
  };
  std::size_t first = 0;
  while (first < n && leading_sharp_edge(first) < 0) ++first;
  if (first == n) return;  // a tagged vertex without sharp edges has no sectors
  std::int32_t sector = -1;
  double angle = 0;
  const auto close_sector = [&] {
    if (sector >= 0) {
      features.corner_sectors[SharpFeatures::sector_key(vertex, sector)] = classify_angle(angle);
    }
  };
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = (first + k) % n;
    if (leading_sharp_edge(i) >= 0) {
      close_sector();
      sector = leading_sharp_edge(i);
      angle = 0;
    }
    angle += interior_angle(areas, topology.face_of(corners[i]), topology.place_of(corners[i]));
  }
  close_sector();
}

}  // namespace

SharpFeatures find_sharp_features(const PolygonMesh& mesh, const MeshTopology& topology,
                                  std::span<const glm::dvec3> rest_positions,
                                  const SharpFeatureOptions& options) {
  PLANISH_ASSERT(rest_positions.size() == mesh.positions.size());
  SharpFeatures features;
  number_sharp_edges(mesh, topology, options.use_tags, features);
  classify_vertices(mesh, topology, options, features);
  FaceAreas areas(mesh, rest_positions);
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (features.vertex_kinds[v] != VertexKind::Corner) continue;
    if (features.corner_of_vertex.empty()) {
      features.corner_of_vertex.assign(static_cast<std::size_t>(mesh.vertex_count()), -1);
    }
    features.corner_of_vertex[v] = features.corner_count++;
    features.corner_vertices.push_back(v);
    if (features.sharp_edge_count > 0) classify_sectors(topology, v, areas, features);
  }
  return features;
}

Subdivision::Subdivision(const MeshTopology& topology, const SharpFeatures& features,
                         Weights weights)
    : topology_(topology),
      features_(features),
      face_weights_(weights),
      edge_of_sharp_(static_cast<std::size_t>(features.sharp_edge_count)) {
  for (std::size_t e = 0; e < features.sharp_of_edge.size(); ++e) {
    if (features.sharp_of_edge[e] >= 0)
      edge_of_sharp_[features.sharp_of_edge[e]] = static_cast<std::int32_t>(e);
  }
}

namespace {

// Based on: Doo & Sabin 1978. Curve points: the uniform quadratic B-spline of a sharp polyline.

struct FirstStepEmitter {
  const Subdivision& subdivision;
  std::vector<double> scratch{};

  void corner_point(std::int32_t corner, double scale, StencilRow& row) {
    const MeshTopology& topology = subdivision.topology();
    const auto vertices = topology.face(topology.face_of(corner));
    const auto m = static_cast<std::int32_t>(vertices.size());
    const auto c = subdivision.face_weights().of(m, scratch);
    const std::int32_t place = topology.place_of(corner);
    for (std::int32_t j = 0; j < m; ++j) row.add(vertices[(place + j) % m], scale * c[j]);
  }

  void curve_point(std::int32_t sharp_child, StencilRow& row) {
    const MeshTopology& topology = subdivision.topology();
    const std::int32_t edge = subdivision.edge_of_sharp(sharp_child / 2);
    const auto [v0, v1] = topology.edge_vertices(edge);
    const bool is_first_end = sharp_child % 2 == 0;
    const std::int32_t own = is_first_end ? v0 : v1, other = is_first_end ? v1 : v0;
    if (subdivision.features().vertex_kinds[own] != VertexKind::Dart) {
      row.add(own, 0.75);
      row.add(other, 0.25);
      return;
    }
    // Between the two faces beside the edge.
    for (const std::int32_t tail :
         {topology.corner_of(edge), topology.twin(topology.corner_of(edge))})
      corner_point(topology.vertex_of(tail) == own ? tail : topology.next(tail), 0.5, row);
  }

  void operator()(std::int32_t index, StencilRow& row) {
    if (index >= subdivision.first_corner()) {
      row.add(subdivision.features().corner_vertices[index - subdivision.first_corner()], 1.0);
    } else if (index >= subdivision.first_sharp()) {
      curve_point(index - subdivision.first_sharp(), row);
    } else {
      corner_point(index, 1.0, row);
    }
  }
};

}  // namespace

StencilTable first_step_table(const Subdivision& subdivision, RowRange rows) {
  return build_rows(subdivision.topology().vertex_count(), rows, Derivatives::No,
                    [&] { return FirstStepEmitter{subdivision}; });
}

namespace {

// The curve control point of the half of sharp edge `sharp` at `vertex`.
std::int32_t curve_point(const Subdivision& subdivision, std::int32_t edge, std::int32_t sharp,
                         std::int32_t vertex) {
  const bool is_first_end = subdivision.topology().edge_vertices(edge).first == vertex;
  return subdivision.first_sharp() + 2 * sharp + (is_first_end ? 0 : 1);
}

void gather_around_face(const MeshTopology& topology, std::int32_t face, VertexRing& ring) {
  for (std::int32_t i = 0; i < topology.face_size(face); ++i)
    ring.faces.push_back(topology.first_corner(face) + i);
}

void gather_around_edge(const Subdivision& subdivision, std::int32_t edge, VertexRing& ring) {
  const MeshTopology& topology = subdivision.topology();
  const std::int32_t sharp = subdivision.sharp_of_edge(edge);
  if (sharp >= 0) ring.kind = VertexKind::Crease;
  const std::int32_t own = topology.corner_of(edge);
  const int side_count = topology.is_boundary_edge(edge) ? 1 : 2;
  for (int side = 0; side < side_count; ++side) {
    // A face runs along the edge from its corner to the next: seen from the edge's midpoint, the
    // corner at the far end comes first.
    const std::int32_t tail = side == 0 ? own : topology.twin(own), head = topology.next(tail);
    ring.faces.push_back(head);
    ring.faces.push_back(tail);
    if (sharp < 0) continue;
    ring.sectors.push_back({2 * side, 2,
                            curve_point(subdivision, edge, sharp, topology.vertex_of(head)),
                            curve_point(subdivision, edge, sharp, topology.vertex_of(tail))});
  }
}

// Sectors of a vertex whose faces are gathered; turns the ring so that a sector begins at its
// first face.
void gather_sectors(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring) {
  const MeshTopology& topology = subdivision.topology();
  const auto sharp_of = [&](std::int32_t edge) { return subdivision.sharp_of_edge(edge); };
  const auto first = std::ranges::find_if(
      ring.faces, [&](std::int32_t corner) { return sharp_of(topology.edge_of(corner)) >= 0; });
  if (first == ring.faces.end()) return;  // a tagged vertex in a smooth neighbourhood
  std::ranges::rotate(ring.faces, first);
  if (ring.kind == VertexKind::Dart) {
    ring.dart_face = 0;
    return;
  }
  for (std::size_t k = 0; k < ring.faces.size(); ++k) {
    const std::int32_t leading = topology.edge_of(ring.faces[k]);
    const std::int32_t trailing = topology.edge_of(topology.prev(ring.faces[k]));
    const std::int32_t sharp = sharp_of(leading), trailing_sharp = sharp_of(trailing);
    if (sharp >= 0) {
      ring.sectors.push_back(
          {static_cast<std::int32_t>(k), 0, curve_point(subdivision, leading, sharp, vertex), -1});
      if (ring.kind == VertexKind::Corner) {
        ring.sectors.back().corner =
            subdivision.features().corner_sectors.at(SharpFeatures::sector_key(vertex, sharp));
      }
    }
    VertexRing::Sector& sector = ring.sectors.back();
    ++sector.count;
    if (trailing_sharp >= 0)
      sector.curve1 = curve_point(subdivision, trailing, trailing_sharp, vertex);
  }
  for (const VertexRing::Sector& sector : ring.sectors) PLANISH_ASSERT(sector.curve1 >= 0);
}

void gather_around_vertex(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring) {
  const auto corners = subdivision.topology().corners_at(vertex);
  ring.faces.assign(corners.begin(), corners.end());
  const SharpFeatures& features = subdivision.features();
  ring.kind = features.vertex_kinds[vertex];
  if (ring.kind == VertexKind::Smooth) return;
  if (ring.kind == VertexKind::Corner)
    ring.corner_point = subdivision.first_corner() + features.corner_of_vertex[vertex];
  if (subdivision.has_sharp_edges()) gather_sectors(subdivision, vertex, ring);
}

}  // namespace

void gather_ring(const Subdivision& subdivision, std::int32_t vertex, VertexRing& ring) {
  const MeshTopology& topology = subdivision.topology();
  ring.kind = VertexKind::Smooth;
  ring.faces.clear();
  ring.sectors.clear();
  ring.corner_point = ring.dart_face = -1;
  const std::int32_t first_face = topology.vertex_count();
  const std::int32_t first_edge = first_face + topology.face_count();
  if (vertex < first_face) {
    gather_around_vertex(subdivision, vertex, ring);
  } else if (vertex < first_edge) {
    gather_around_face(topology, vertex - first_face, ring);
  } else {
    gather_around_edge(subdivision, vertex - first_edge, ring);
  }
}

namespace {

// The continuation rules of polygons of control points around a vertex, a derivation of our own.
// Names: x_i face control points, w0 and w1 curve control points before and after a sector of k
// faces, V a corner's position, theta_i = pi (2i - 1) / (2k) the angle of face i in a half plane,
// b_i the affine image of a regular half ring, a_i = x_i - b_i, A = (a_1..a_k, -a_k..-a_1) its odd
// extension across the sharp curve.

constexpr double kPi = std::numbers::pi;

// The unit vectors at angles 2 pi i / n.
struct RegularPolygon {
  explicit RegularPolygon(std::int32_t n) {
    for (std::int32_t i = 0; i < n; ++i) {
      const double angle = 2 * kPi * i / n;
      cosines.push_back(portable::cos(angle));
      sines.push_back(portable::sin(angle));
    }
    // Two opposite points span no plane: rounding must not make one up.
    if (n == 2) sines = {0, 0};
  }
  std::vector<double> cosines, sines;
};

// Nearly all rings of a surface are quads: computing sines anew would be the dearest part of
// their rows.
const RegularPolygon& regular_quad() {
  static const RegularPolygon quad(4);
  return quad;
}

double half_plane_angle(std::int32_t i, std::int32_t k) { return kPi * (2 * i + 1) / (2.0 * k); }

// b_i = (1/2 + q_i) w0 + (1/2 - q_i) w1 with this q_i.
double half_plane_offset(std::int32_t i, std::int32_t k) {
  return portable::cos(half_plane_angle(i, k)) / std::numbers::sqrt2;
}

struct HalfPlaneRule {
  const FaceWeights& face_weights;
  const VertexRing& ring;
  const VertexRing::Sector& sector;

  // base_share: how much of the even part's b_i and of the point it contracts to is taken; the
  // rest of the unit comes from w0, w1 (creases) or V (corners).
  void add(std::int32_t i, double scale, std::vector<double>& scratch, StencilRow& row) const {
    const std::int32_t k = sector.count;
    // A single face has a ring of two, for which the general weights would not halve the odd part
    // as the curve halves the even one: a flat grid would fold.
    static constexpr double kSingleFace[] = {0.75, 0.25};
    const auto c = k == 1 ? std::span<const double>(kSingleFace) : face_weights.of(2 * k, scratch);
    const double q_i = half_plane_offset(i, k);
    double w0 = 0, w1 = 0;
    if (ring.kind == VertexKind::Corner) {  // (b_i + V) / 2
      row.add(ring.corner_point, scale / 2);
      w0 = (0.5 + q_i) / 2;
      w1 = (0.5 - q_i) / 2;
    } else {  // Lc + (b_i - Lc) / 2 with Lc = (w0 + w1) / 2
      w0 = 0.5 + q_i / 2;
      w1 = 0.5 - q_i / 2;
    }
    for (std::int32_t j = 0; j < k; ++j) {
      const std::int32_t mirrored = 2 * k - 1 - j;
      const double g = c[std::abs(j - i)] - c[mirrored - i];
      row.add(ring.faces[sector.first + j], scale * g);
      const double q_j = half_plane_offset(j, k);
      w0 -= g * (0.5 + q_j);
      w1 -= g * (0.5 - q_j);
    }
    row.add(sector.curve0, scale * w0);
    row.add(sector.curve1, scale * w1);
  }
};

// b_i = V + alpha (w0 - V) + beta (w1 - V), a circular fan over the sector's opening;
// x'_i = (b_i + V) / 2 + (x_i - b_i) / 4.
void add_refined_fan_face(const VertexRing& ring, const VertexRing::Sector& sector, std::int32_t i,
                          double scale, StencilRow& row) {
  const double opening = sector.corner == CornerSector::Reflex ? 1.5 * kPi : 0.5 * kPi;
  const double t = (i + 0.5) / sector.count;
  const double alpha =
      std::numbers::sqrt2 * portable::sin((1 - t) * opening) / portable::sin(opening);
  const double beta = std::numbers::sqrt2 * portable::sin(t * opening) / portable::sin(opening);
  row.add(ring.faces[sector.first + i], scale / 4);
  row.add(sector.curve0, scale * alpha / 4);
  row.add(sector.curve1, scale * beta / 4);
  row.add(ring.corner_point, scale * (0.5 + (1 - alpha - beta) / 4));
}

void add_refined_ring_face(const FaceWeights& face_weights, const VertexRing& ring, std::int32_t i,
                           double scale, std::vector<double>& scratch, StencilRow& row) {
  const auto n = static_cast<std::int32_t>(ring.faces.size());
  const auto c = face_weights.of(n, scratch);
  // A tagged vertex without sharp edges is the tip of a cone: its ring shrinks towards V at the
  // rate of its shape, 1/2, instead of keeping its mean.
  const bool cone = ring.kind == VertexKind::Corner;
  const double towards_mean = cone ? -0.5 / n : 0.0;
  for (std::int32_t j = 0; j < n; ++j) {
    row.add(ring.faces[j], scale * (c[(j - i + n) % n] + towards_mean));
  }
  if (cone) row.add(ring.corner_point, scale / 2);
}

void add_sector_limit(const VertexRing& ring, const VertexRing::Sector& sector, StencilRow& row) {
  const bool corner = ring.kind == VertexKind::Corner;
  if (corner && sector.corner != CornerSector::HalfPlane) {
    // du x dv is outward while the opening is below pi; reversed beyond.
    const double sign = sector.corner == CornerSector::Reflex ? -1.0 : 1.0;
    row.add(ring.corner_point, 1.0, -1.0, -sign);
    row.add(sector.curve0, 0.0, 1.0, 0.0);
    row.add(sector.curve1, 0.0, 0.0, sign);
    return;
  }
  const std::int32_t k = sector.count;
  double w0 = 0, w1 = 0;
  for (std::int32_t j = 0; j < k; ++j) {
    const double s = portable::sin(half_plane_angle(j, k));
    const double q = half_plane_offset(j, k);
    row.add(ring.faces[sector.first + j], 0.0, 0.0, s);
    w0 -= s * (0.5 + q);
    w1 -= s * (0.5 - q);
  }
  const double curve_share = corner ? 0.0 : 0.5;
  row.add(sector.curve0, curve_share, 1.0, w0);
  row.add(sector.curve1, curve_share, -1.0, w1);
  if (corner) row.add(ring.corner_point, 1.0);
}

}  // namespace

void add_refined_face(const FaceWeights& face_weights, const VertexRing& ring, std::int32_t i,
                      double scale, std::vector<double>& weights_scratch, StencilRow& row) {
  for (const VertexRing::Sector& sector : ring.sectors) {
    const std::int32_t place = i - sector.first;
    if (place < 0 || place >= sector.count) continue;
    if (ring.kind == VertexKind::Corner && sector.corner != CornerSector::HalfPlane) {
      add_refined_fan_face(ring, sector, place, scale, row);
    } else {
      HalfPlaneRule{face_weights, ring, sector}.add(place, scale, weights_scratch, row);
    }
    return;
  }
  add_refined_ring_face(face_weights, ring, i, scale, weights_scratch, row);
}

void add_refined_curve_point(const FaceWeights& face_weights, const VertexRing& ring,
                             std::int32_t own, std::vector<double>& weights_scratch,
                             StencilRow& row) {
  const auto n = static_cast<std::int32_t>(ring.faces.size());
  switch (ring.kind) {
    case VertexKind::Dart:
      add_refined_face(face_weights, ring, ring.dart_face, 0.5, weights_scratch, row);
      add_refined_face(face_weights, ring, (ring.dart_face + n - 1) % n, 0.5, weights_scratch, row);
      return;
    case VertexKind::Corner:
      row.add(own, 0.5);
      row.add(ring.corner_point, 0.5);
      return;
    case VertexKind::Crease: {
      const auto& sector = ring.sectors.front();
      row.add(own, 0.75);
      row.add(sector.curve0 == own ? sector.curve1 : sector.curve0, 0.25);
      return;
    }
    case VertexKind::Smooth:
      break;
  }
  PLANISH_ASSERT(!"a sharp edge ends at a smooth vertex");
}

void add_limit(const VertexRing& ring, std::int32_t sector, StencilRow& row) {
  if (!ring.sectors.empty()) {
    add_sector_limit(ring, ring.sectors[sector], row);
    return;
  }
  const auto n = static_cast<std::int32_t>(ring.faces.size());
  const bool cone = ring.kind == VertexKind::Corner;
  const double share = cone ? 0.0 : 1.0 / n;
  const auto add = [&](const RegularPolygon& polygon) {
    for (std::int32_t i = 0; i < n; ++i) {
      row.add(ring.faces[i], share, polygon.cosines[i], polygon.sines[i]);
    }
  };
  if (n == 4) {
    add(regular_quad());
  } else {
    add(RegularPolygon(n));
  }
  if (cone) row.add(ring.corner_point, 1.0);
}

}  // namespace planish
