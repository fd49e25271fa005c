#include "planish/fair/fold_cure.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/core/work.h"
#include "planish/fair/fair_topology.h"
#include "planish/fair/perpendicular_polygon.h"

namespace planish {

using glm::dvec3;

namespace {

// A step of Doo-Sabin on one polygon, about its first point.
template <class Point>
dvec3 stepped(const FairTopology& topology, std::int32_t count, const Point& point) {
  const auto circle = topology.unit_circle.of(count);
  const dvec3 own = point(0);
  dvec3 sum(0.0);
  for (std::int32_t k = 1; k < count; ++k) sum += (3 + 2 * circle[k].x) * (point(k) - own);
  return own + sum / (4.0 * count);
}

// Sums of a large polygon, of which a step takes few.
template <class Point>
NetSamples::PolygonSums sums_of(const FairTopology& topology, std::int32_t count,
                                const Point& point) {
  const auto circle = topology.unit_circle.of(count);
  const dvec3 origin = point(0);
  NetSamples::PolygonSums sums{};
  for (std::int32_t k = 1; k < count; ++k) {
    const dvec3 from_origin = point(k) - origin;
    sums.mean += from_origin;
    sums.even += circle[k].x * from_origin;
    sums.odd += circle[k].y * from_origin;
  }
  sums.mean = origin + sums.mean / double(count);
  sums.even *= 2.0 / count;
  sums.odd *= 2.0 / count;
  return sums;
}

// X_i / 4 + 3/4 M + (cos a_i U + sin a_i W) / 4.
dvec3 stepped(const NetSamples::PolygonSums& sums, const dvec3& own, const glm::dvec2& place) {
  return 0.25 * own + 0.75 * sums.mean + 0.25 * (place.x * sums.even + place.y * sums.odd);
}

// The same on four points.
dvec3 stepped_quad(const dvec3& own, const dvec3& beside, const dvec3& opposite,
                   const dvec3& other_beside) {
  return own + (3.0 * (beside - own) + 3.0 * (other_beside - own) + (opposite - own)) / 16.0;
}

}  // namespace

double cosine_of(const dvec3& normal, const dvec3& reference) {
  const double length = glm::length(normal);
  return length > 0 ? glm::dot(normal, reference) / length : -1;
}

dvec3 NetSamples::at_edge(const FairTopology::Edge& edge) const {
  return glm::cross(point(edge.corners[2]) - point(edge.corners[0]),
                    point(edge.corners[3]) - point(edge.corners[1]));
}

dvec3 NetSamples::at_face(std::int32_t face) const {
  const std::int32_t first = topology.face_offsets[face];
  return limit_normal(topology, topology.face_size(face),
                      [&](std::int32_t i) { return point(first + i); });
}

dvec3 NetSamples::at_vertex(std::int32_t vertex) const {
  const auto corners = topology.ring(vertex).corners;
  return limit_normal(topology, topology.valence(vertex),
                      [&](std::int32_t i) { return offsets[corners[i]]; });
}

namespace {

// The points of level 2 around one control point, and the control points beside it.
struct Surroundings {
  const NetSamples& samples;
  const FairTopology& topology = samples.topology;
  const NetSamples::PolygonSums* of_polygon = nullptr;  // around the vertex, where that is large
  mutable std::int64_t asked = 0;                       // points of polygons

  ~Surroundings() { count_work(Work::Points, asked); }

  [[nodiscard]] std::int32_t beside(std::int32_t corner, std::int32_t by) const {
    const std::int32_t face = topology.corner_faces[corner], m = topology.face_size(face);
    const std::int32_t first = topology.face_offsets[face];
    return first + (corner - first + by + m) % m;
  }
  // Whether the edge from one corner to the next one of its face is. A dart's ring does not show
  // that it has a sharp one.
  [[nodiscard]] bool is_smooth(std::int32_t corner, std::int32_t next) const {
    return topology.corner_cw[corner] < topology.corner_count &&
           topology.corner_ccw[next] < topology.corner_count;
  }
  [[nodiscard]] dvec3 in_face(std::int32_t corner) const {
    const std::int32_t face = topology.corner_faces[corner], m = topology.face_size(face);
    if (const std::int32_t large = topology.large_face(face); large >= 0)
      return stepped(samples.of_large_faces[large], samples.point(corner),
                     topology.unit_circle.of(m)[corner - topology.face_offsets[face]]);
    asked += m;
    return stepped(topology, m, [&](std::int32_t k) { return samples.point(beside(corner, k)); });
  }
  [[nodiscard]] dvec3 in_polygon(std::int32_t vertex, std::int32_t place) const {
    const FairTopology::Ring ring = topology.ring(vertex);
    if (of_polygon) {
      const std::int32_t at = place % ring.size();
      return stepped(*of_polygon, samples.point(ring.corners[at]),
                     topology.unit_circle.of(ring.size())[at]);
    }
    asked += ring.size();
    return stepped(topology, ring.size(), [&](std::int32_t k) {
      return samples.point(ring.corners[(place + k) % ring.size()]);
    });
  }
  // In the polygon of the edge to the next vertex of the face, and to the one before.
  [[nodiscard]] dvec3 on_next(std::int32_t corner) const {
    const std::int32_t other = topology.corner_cw[corner];
    return stepped_quad(samples.point(corner), samples.point(beside(corner, 1)),
                        samples.point(beside(other, -1)), samples.point(other));
  }
  [[nodiscard]] dvec3 on_previous(std::int32_t corner) const {
    const std::int32_t other = topology.corner_ccw[corner];
    return stepped_quad(samples.point(corner), samples.point(beside(corner, -1)),
                        samples.point(beside(other, 1)), samples.point(other));
  }
};

}  // namespace

void NetSamples::sum_large_faces() {
  of_large_faces.resize(topology.large_faces.size());
  parallel_each(of_large_faces.size(), 1, [&](std::size_t i) {
    const std::int32_t face = topology.large_faces[i];
    const std::int32_t first = topology.face_offsets[face];
    of_large_faces[i] = sums_of(topology, topology.face_size(face),
                                [&](std::int32_t k) { return point(first + k); });
  });
}

double NetSamples::least_cosine_around(std::int32_t vertex,
                                       std::span<const dvec3> face_normals) const {
  PolygonSums sums{};
  Surroundings around{*this};
  if (topology.valence(vertex) >= topology.large_size) {
    const FairTopology::Ring ring = topology.ring(vertex);
    sums = sums_of(topology, ring.size(), [&](std::int32_t k) { return point(ring.corners[k]); });
    around.of_polygon = &sums;
  }
  double least = 1;
  const auto note = [&](const dvec3& normal, std::int32_t corner) {
    least = std::min(least, cosine_of(normal, face_normals[topology.corner_faces[corner]]));
  };
  const auto corners = topology.ring(vertex).corners;
  for (std::int32_t i = 0; i < topology.valence(vertex); ++i) {
    const std::int32_t corner = corners[i], after = topology.corner_ccw[corner];
    const std::int32_t next = around.beside(corner, 1), last = around.beside(corner, -1);
    const bool next_is_smooth = around.is_smooth(corner, next);
    const dvec3 own = around.in_polygon(vertex, i), face = around.in_face(corner);
    if (next_is_smooth) {
      const dvec3 edge = around.on_next(corner);
      note(glm::cross(around.on_previous(next) - face, around.in_face(next) - edge), corner);
    }
    if (!around.is_smooth(last, corner)) continue;
    const dvec3 edge = around.on_previous(corner);
    note(glm::cross(face - around.on_next(last), around.in_face(last) - edge), corner);
    if (next_is_smooth) note(glm::cross(face - own, edge - around.on_next(corner)), corner);
    const dvec3 side =
        glm::cross(around.on_next(after) - own, around.in_polygon(vertex, i + 1) - edge);
    note(side, corner);
    note(side, after);
  }
  return least;
}

namespace {

constexpr std::size_t kRepairGrain = 8192;
constexpr int kRepairRounds = 3;
// Cosine between the limit normal of a face or edge and the mesh's below which it counts as folded.
// At edges it is a part of the cosine of half their own turn: less is asked of sharp ones.
constexpr double kLeastCosine = 0.5;

// Whether `normal`, of any length, is within `cosine` of the unit vector `reference`.
bool agrees(const dvec3& normal, const dvec3& reference, double cosine) {
  return glm::dot(normal, reference) >= cosine * glm::length(normal);
}

struct FoldTest {
  NetSamples samples;
  std::span<const dvec3> face_normals;
  FairHalo* halo = nullptr;

  [[nodiscard]] bool edge_is_folded(const FairTopology::Edge& edge) const {
    const dvec3& f = face_normals[edge.faces[0]];
    const dvec3& g = face_normals[edge.faces[1]];
    const double length = glm::length(f + g);
    if (!(length > 0)) return false;  // a knife's edge has no normal to compare with
    // length / 2 is the cosine of half the dihedral turn.
    return !agrees(samples.at_edge(edge), (f + g) / length, kLeastCosine * length / 2);
  }

  [[nodiscard]] bool face_is_folded(std::int32_t face) const {
    return !agrees(samples.at_face(face), face_normals[face], kLeastCosine);
  }
};

// One for each edge and face: 1 where it is folded.
struct FoldedElements {
  explicit FoldedElements(const FairTopology& topology)
      : edges(topology.edge_corners.size(), 0),
        faces(static_cast<std::size_t>(topology.face_count), 0) {}

  std::vector<std::uint8_t> edges, faces;
};

// Counts the folded elements and flags their vertices. `moved`: one for each vertex, 1 where its
// polygon has moved since they were found, so that all others are as they were; empty: all have.
FoldCount find_folds(const FoldTest& test, std::span<const std::uint8_t> moved,
                     FoldedElements& folded, std::span<std::uint8_t> flags) {
  const FairTopology& topology = test.samples.topology;
  const auto has_moved = [&](std::int32_t vertex) { return moved.empty() || moved[vertex] != 0; };
  std::atomic<std::int64_t> edges = 0, faces = 0;
  parallel_each(folded.edges.size(), kRepairGrain, [&](std::size_t e) {
    const FairTopology::Edge edge = topology.edge(e);
    const std::int32_t first = topology.corner_vertices[edge.corners[0]],
                       second = topology.corner_vertices[edge.corners[1]];
    if (has_moved(first) || has_moved(second)) folded.edges[e] = test.edge_is_folded(edge) ? 1 : 0;
    if (folded.edges[e] == 0) return;
    if (owns_face(test.halo, edge.faces[0])) ++edges;
    flag(flags, first);
    flag(flags, second);
  });
  parallel_each(folded.faces.size(), kRepairGrain, [&](std::int32_t face) {
    if (std::ranges::any_of(topology.face(face), has_moved))
      folded.faces[face] = test.face_is_folded(face) ? 1 : 0;
    if (folded.faces[face] == 0) return;
    if (owns_face(test.halo, face)) ++faces;
    for (const std::int32_t v : topology.face(face)) flag(flags, v);
  });
  return sum_of_parts(test.halo, {edges, faces});
}

}  // namespace

void halve_polygons(const FairTopology& topology, std::span<const std::uint8_t> halvings,
                    std::span<dvec3> offsets) {
  parallel_each(halvings.size(), kRepairGrain, [&](std::int32_t v) {
    if (halvings[v] == 0) return;
    const double factor = std::ldexp(1.0, -halvings[v]);
    for (const std::int32_t corner : topology.ring(v).corners) offsets[corner] *= factor;
  });
  for (std::size_t s = 0; s < topology.curve_points.size(); ++s) {
    const std::int32_t vertex = topology.curve_points[s].vertex;
    if (topology.kind(vertex) != VertexKind::Crease) continue;
    offsets[static_cast<std::size_t>(topology.corner_count) + s] *=
        std::ldexp(1.0, -halvings[vertex]);
  }
}

FoldCount count_folds(const FairTopology& topology, std::span<const dvec3> given,
                      std::span<const dvec3> face_normals, std::span<const dvec3> offsets) {
  std::vector<std::uint8_t> flags(given.size(), 0);
  FoldedElements folded(topology);
  return find_folds({{topology, given, offsets}, face_normals}, {}, folded, flags);
}

FoldCount repair_folds(const FairTopology& topology, std::span<const dvec3> given,
                       std::span<const dvec3> face_normals, std::span<dvec3> offsets,
                       std::span<std::uint8_t> halvings, FairHalo* halo) {
  const FoldTest test{{topology, given, offsets}, face_normals, halo};
  FoldedElements folded(topology);
  std::vector<std::uint8_t> round_halvings(halvings.size());
  for (int round = 0;; ++round) {
    std::vector<std::uint8_t> flags(halvings.size(), 0);
    // What other ranks have halved is not known here.
    const bool all_may_have_moved = round == 0 || halo != nullptr;
    FoldCount folds = find_folds(
        test, all_may_have_moved ? std::span<const std::uint8_t>() : round_halvings, folded, flags);
    folds.rounds = round;
    if (round == kRepairRounds || folds.edges + folds.faces == 0) return folds;
    for (std::size_t v = 0; v < halvings.size(); ++v) {
      // Corner points and the curves that end there are where they must be.
      const bool halve =
          flags[v] != 0 && topology.kind(static_cast<std::int32_t>(v)) != VertexKind::Corner;
      round_halvings[v] = halve ? 1 : 0;
      halvings[v] = static_cast<std::uint8_t>(halvings[v] + round_halvings[v]);
    }
    halve_polygons(topology, round_halvings, offsets);
    if (halo) halo->exchange_state(offsets);
  }
}

// Names: A the 2 x 2 matrix of the ellipse, t_i the direction of the unit circle's side across the
// edge e_i, m the direction in a face beside it that is at right angles to e_i, inwards. The limit
// normal at the edge of small polygons is along e_i x A t_i, and on the face's side where
// m . A t_i > 0: linear in A. So A is the direction of R^4 that sees all of m (x) t_i best, which
// fair/perpendicular_polygon.h finds.

using glm::dvec2;
using glm::dvec4;

namespace {

dvec2 times(const dvec4& ellipse, const dvec2& point) {
  return {ellipse.x * point.x + ellipse.y * point.y, ellipse.z * point.x + ellipse.w * point.y};
}

// What each side of the ellipse has to do with the two faces that it leads to, along `axes`.
std::vector<dvec4> side_conditions(const FairTopology& topology, std::span<const dvec3> given,
                                   std::span<const dvec3> face_normals, std::int32_t vertex,
                                   const RingAxes& axes) {
  const FairTopology::Ring ring = topology.ring(vertex);
  const std::int32_t n = ring.size();
  std::vector<dvec4> conditions;
  for (std::int32_t i = 0; i < n; ++i) {
    const dvec3 edge = unit_or_zero(given[ring.next[i]] - given[vertex]);
    const double angle = std::numbers::pi * (2 * i - 1) / n;
    const dvec2 side(-portable::sin(angle), portable::cos(angle));
    for (const std::int32_t place : {i, (i + n - 1) % n}) {
      const std::int32_t face = topology.corner_faces[ring.corners[place]];
      const dvec3 inward = glm::cross(face_normals[face], edge);
      const dvec2 flat(glm::dot(inward, axes.along), glm::dot(inward, axes.left));
      conditions.emplace_back(flat.x * side.x, flat.x * side.y, flat.y * side.x, flat.y * side.y);
    }
  }
  return conditions;
}

}  // namespace

glm::vec4 hub_ellipse(const FairTopology& topology, std::span<const dvec3> given,
                      std::span<const dvec3> face_normals, std::int32_t vertex,
                      const dvec3& plane) {
  const std::vector<dvec4> conditions = side_conditions(topology, given, face_normals, vertex,
                                                        ring_axes(topology, given, vertex, plane));
  const auto worst_of = [&](const dvec4& ellipse) {
    return least_seen<dvec4>(conditions, ellipse, [](const dvec4& condition) { return condition; });
  };
  const auto [best, most] = best_view(dvec4(1.0, 0.0, 0.0, 1.0) / std::numbers::sqrt2, worst_of);
  if (!(most > 0) || !(best.x * best.w > best.y * best.z)) return glm::vec4(0.0F);
  double farthest = 0;
  for (const dvec2& point : topology.unit_circle.of(topology.valence(vertex)))
    farthest = std::max(farthest, glm::length(times(best, point)));
  return glm::vec4(best / farthest);
}

namespace {

// And those of their faces: what folds at an edge, both of its ends' polygons make.
std::vector<std::uint8_t> with_neighbours(const FairTopology& topology,
                                          std::span<const std::uint8_t> flagged) {
  std::vector<std::uint8_t> wanted(flagged.begin(), flagged.end());
  for (std::int32_t face = 0; face < topology.face_count; ++face) {
    const auto vertices = topology.face(face);
    if (std::ranges::none_of(vertices, [&](std::int32_t v) { return flagged[v] != 0; })) continue;
    for (const std::int32_t v : vertices) wanted[v] = 1;
  }
  return wanted;
}

}  // namespace

std::vector<std::uint8_t> choose_ellipses(const FairTopology& topology,
                                          std::span<const dvec3> given,
                                          std::span<const std::uint8_t> flagged,
                                          FairDecisions& decisions) {
  const std::vector<dvec3> face_normals = unit_face_normals(topology, given);
  const std::vector<dvec3> normals =
      vertex_normals(topology, given, face_normals, plane_places(topology, decisions.planes));
  decisions.ellipses.resize(given.size(), glm::vec4(0.0F));
  const std::vector<std::uint8_t> wanted = with_neighbours(topology, flagged);
  std::vector<std::uint8_t> chosen(given.size(), 0);
  for (std::size_t v = 0; v < wanted.size(); ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    if (wanted[v] == 0 || decisions.cures[v] == 0 || !topology.has_polygon(vertex) ||
        is_ellipse(decisions.ellipses[v]) || !is_chosen(decisions.leans[v]))
      continue;
    const dvec3 plane = leaning_normal(topology, given, vertex, normals[v], decisions.leans[v]);
    decisions.ellipses[v] = hub_ellipse(topology, given, face_normals, vertex, plane);
    chosen[v] = is_ellipse(decisions.ellipses[v]);
  }
  return chosen;
}

void build_hub_ellipse(const FairTopology& topology, std::span<const dvec3> given,
                       std::int32_t vertex, const dvec3& plane, const glm::vec4& ellipse,
                       double size, std::span<dvec3> offsets) {
  const RingAxes axes = ring_axes(topology, given, vertex, plane);
  const auto corners = topology.ring(vertex).corners;
  const auto circle = topology.unit_circle.of(topology.valence(vertex));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const dvec2 point = size * times(dvec4(ellipse), circle[i]);
    offsets[corners[i]] = point.x * axes.along + point.y * axes.left;
  }
}

namespace {

constexpr std::size_t kCureGrain = 1024;
// Further rounds left no fold less (details.md); looks at the finished surface go on.
constexpr int kCureRounds = 3;
// A limit normal is bad where its least cosine with its faces is below this part of the best that
// any normal there can have.
constexpr double kPartOfBest = 0.5;
constexpr double kPartOfBestAtVertices = 0.1;
constexpr double kPartOfBestAround = 0.5;
// Where the best is worse than this, about 80 degrees at edges, the mesh itself is folded: curing
// that costs more normals than it mends.
constexpr double kLeastBestAtEdges = 0.17;
constexpr double kLeastBestAtVertices = 0.02;
// Cosine of a sector's limit normal at a crease or boundary vertex with its faces below which it is
// bad. No size changes it.
constexpr double kLeastSectorCosine = 0.05;
// Of the way to a face's opposite side: a fan point beyond it meets what comes from there. No size
// changes that either.
constexpr double kFarthestFan = 0.5;
// Cosine between a vertex's normal and those of all its faces from which its surroundings are even
// enough for the places of level 1 to speak for all others.
constexpr double kFlatCosine = 0.9;
// What a polygon that is bad again is scaled by.
constexpr double kQuarter = 0.25;

using Flags = std::vector<std::uint8_t>;

struct Cure {
  const CureInput& input;
  std::span<glm::vec2> leans;
  const FairTopology& topology = input.topology;
  Flags bad, changed, touched;  // per vertex; touched: in a face with a changed one

  NetSamples samples{topology, input.given, input.offsets};
  FaceHeights heights{topology, input.given};

  [[nodiscard]] double edge_cosine(const FairTopology::Edge& edge) const;
  [[nodiscard]] double face_cosine(std::int32_t face) const;
  [[nodiscard]] bool vertex_is_bad(std::int32_t vertex) const;
  std::int64_t test_edges(bool count);
  std::int64_t test_faces(bool count);
  void test_sharp_edges();
  void test_vertices(std::span<const std::uint8_t> cures);
  void build_smooth(std::int32_t vertex, PerpendicularScratch& scratch);
  // What is near others' vertices, from them; whether any vertex changed.
  bool exchange(bool any);
  void change(std::int32_t vertex, std::int32_t times, bool is_new, PerpendicularScratch& scratch);
  FoldCount count();
};

double Cure::edge_cosine(const FairTopology::Edge& edge) const {
  const dvec3 normal = samples.at_edge(edge);
  return std::min(cosine_of(normal, input.face_normals[edge.faces[0]]),
                  cosine_of(normal, input.face_normals[edge.faces[1]]));
}

double Cure::face_cosine(std::int32_t face) const {
  return cosine_of(samples.at_face(face), input.face_normals[face]);
}

bool Cure::vertex_is_bad(std::int32_t vertex) const {
  const auto least_cosine = [&](const dvec3& direction) {
    return least_face_cosine(topology, input.face_normals, vertex, direction);
  };
  const dvec3 normal = samples.at_vertex(vertex);
  const double length = glm::length(normal);
  const double own = length > 0 ? least_cosine(normal / length) : -1;
  if (own >= kPartOfBestAtVertices && least_cosine(input.normals[vertex]) >= kFlatCosine) {
    return false;
  }
  const double best =
      smallest_cap(topology, input.face_normals, vertex, input.normals[vertex]).cosine;
  if (best < kLeastBestAtVertices) return false;
  return own < kPartOfBestAtVertices * best ||
         samples.least_cosine_around(vertex, input.face_normals) < kPartOfBestAround * best;
}

std::int64_t Cure::test_edges(bool count) {
  std::atomic<std::int64_t> folded = 0;
  parallel_each(topology.edge_corners.size(), kCureGrain, [&](std::size_t e) {
    const FairTopology::Edge edge = topology.edge(e);
    const std::int32_t v = topology.corner_vertices[edge.corners[0]];
    const std::int32_t w = topology.corner_vertices[edge.corners[1]];
    if (!count && !changed[v] && !changed[w]) return;
    const double cosine = edge_cosine(edge);
    if (count) {
      folded += cosine < 0 && owns_face(input.halo, edge.faces[0]);
      return;
    }
    const double turn =
        glm::dot(input.face_normals[edge.faces[0]], input.face_normals[edge.faces[1]]);
    const double best = std::sqrt(std::max(0.0, (1 + turn) / 2));
    if (best < kLeastBestAtEdges || cosine >= kPartOfBest * best) return;
    flag(bad, v);
    flag(bad, w);
  });
  return folded;
}

std::int64_t Cure::test_faces(bool count) {
  std::atomic<std::int64_t> folded = 0;
  parallel_for(static_cast<std::size_t>(topology.face_count), kCureGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (auto f = static_cast<std::int32_t>(begin); f < static_cast<std::int32_t>(end);
                      ++f) {
                   const auto corners = topology.face(f);
                   if (!count && std::ranges::none_of(corners, [&](auto v) { return changed[v]; }))
                     continue;
                   if (!count) {
                     for (const std::int32_t v : corners) flag(touched, v);
                   }
                   const double cosine = face_cosine(f);
                   if (count) {
                     folded += cosine < 0 && owns_face(input.halo, f);
                   } else if (cosine < kPartOfBest) {
                     for (const std::int32_t v : corners) flag(bad, v);
                   }
                 }
               });
  return folded;
}

// Those beside which the curves' own points and the faces' first ones are turned over.
void Cure::test_sharp_edges() {
  const std::int32_t count = topology.corner_count;
  if (topology.curve_points.empty()) return;
  parallel_for(
      static_cast<std::size_t>(topology.face_count), kCureGrain,
      [&](std::size_t begin, std::size_t end) {
        for (auto f = static_cast<std::int32_t>(begin); f < static_cast<std::int32_t>(end); ++f) {
          for (std::int32_t c = topology.face_offsets[f]; c < topology.face_offsets[f + 1]; ++c) {
            const std::int32_t next =
                c + 1 == topology.face_offsets[f + 1] ? topology.face_offsets[f] : c + 1;
            std::int32_t curve0 = topology.corner_cw[c], curve1 = topology.corner_ccw[next];
            if (curve0 < count && curve1 < count) continue;
            // A dart's ring does not show its curve point: the edge's other one does.
            if (curve0 < count) curve0 = count + ((curve1 - count) ^ 1);
            if (curve1 < count) curve1 = count + ((curve0 - count) ^ 1);
            const std::int32_t v = topology.corner_vertices[c];
            const std::int32_t w = topology.corner_vertices[next];
            if (!changed[v] && !changed[w]) continue;
            const dvec3 on0 = input.given[v] + input.offsets[curve0];
            const dvec3 on1 = input.given[w] + input.offsets[curve1];
            const dvec3 normal =
                glm::cross(on1 - on0, samples.point(c) + samples.point(next) - on0 - on1);
            if (cosine_of(normal, input.face_normals[f]) >= kPartOfBest) continue;
            flag(bad, v);
            flag(bad, w);
          }
        }
      });
}

void Cure::test_vertices(std::span<const std::uint8_t> cures) {
  samples.sum_large_faces();
  parallel_each(bad.size(), kCureGrain, [&](std::int32_t vertex) {
    if (!touched[vertex] || bad[vertex]) return;
    if (topology.has_polygon(vertex)) {
      bad[vertex] = vertex_is_bad(vertex);
    } else if (topology.kind(vertex) == VertexKind::Crease && cures[vertex] == 0) {
      bad[vertex] = least_sector_cosine(topology, input.face_normals, input.offsets, vertex) <
                    kLeastSectorCosine;
    } else if (topology.kind(vertex) == VertexKind::Corner && cures[vertex] == 0) {
      bad[vertex] = farthest_fan_point(topology, input.given, input.offsets, vertex) > kFarthestFan;
    }
  });
}

void Cure::build_smooth(std::int32_t vertex, PerpendicularScratch& scratch) {
  const dvec3& normal = input.normals[vertex];
  glm::vec2& lean = leans[vertex];
  if (!is_chosen(lean)) {
    lean = lean_towards(topology, input.given, vertex, normal,
                        tilted_normal(topology, input.face_normals, vertex, normal));
  }
  const dvec3 plane = leaning_normal(topology, input.given, vertex, normal, lean);
  if (!input.ellipses.empty() && is_ellipse(input.ellipses[vertex])) {
    build_hub_ellipse(topology, input.given, vertex, plane, input.ellipses[vertex],
                      heights.size_at(vertex), input.offsets);
  } else {
    build_perpendicular_polygon(topology, input.given, vertex, plane, heights.size_at(vertex),
                                scratch, input.offsets);
  }
}

// `times` more rounds at the vertex, which had some before unless it is new.
void Cure::change(std::int32_t vertex, std::int32_t times, bool is_new,
                  PerpendicularScratch& scratch) {
  const CurveSite site{topology, input.given, input.face_normals, input.offsets, heights, vertex};
  if (is_new && times > 0) {
    if (topology.kind(vertex) == VertexKind::Crease) {
      build_perpendicular_crease(site, leans[vertex], scratch);
    } else if (topology.kind(vertex) == VertexKind::Corner) {
      build_perpendicular_corner(site, leans[vertex]);
    } else {
      build_smooth(vertex, scratch);
    }
    --times;
  }
  if (times > 0) scale_curve_vertex(site, portable::pow(kQuarter, times));
}

bool Cure::exchange(bool any) {
  FairHalo* const halo = input.halo;
  if (!halo) return any;
  halo->exchange_vertices(changed);
  if (!is_in_any_part(halo, std::ranges::find(changed, 1) != changed.end())) return false;
  halo->exchange_state(input.offsets);
  return true;
}

FoldCount Cure::count() {
  const std::int64_t edges = test_edges(true), faces = test_faces(true);
  return sum_of_parts(input.halo, {edges, faces});
}

}  // namespace

FoldCount cure_folds(const CureInput& input, std::span<std::uint8_t> cures,
                     std::span<glm::vec2> leans) {
  Cure cure{input, leans};
  cure.changed.assign(cures.size(), 1);
  std::int32_t round = 0;
  for (; round < kCureRounds; ++round) {
    cure.bad.assign(cures.size(), 0);
    cure.touched.assign(cures.size(), 0);
    cure.test_edges(false);
    cure.test_faces(false);
    cure.test_sharp_edges();
    cure.test_vertices(cures);
    std::atomic<bool> any = false;
    parallel_for(cures.size(), kCureGrain, [&](std::size_t begin, std::size_t end) {
      PerpendicularScratch scratch;
      for (std::size_t v = begin; v < end; ++v) {
        const auto vertex = static_cast<std::int32_t>(v);
        cure.changed[v] = cure.bad[v];
        if (!cure.changed[v]) continue;
        any = true;
        cure.change(vertex, 1, cures[v] == 0, scratch);
        ++cures[v];
      }
    });
    if (!cure.exchange(any)) break;
  }
  FoldCount left = cure.count();
  left.rounds = round;
  return left;
}

FoldCount repeat_cure(const CureInput& input, std::span<const std::uint8_t> cures,
                      std::span<glm::vec2> leans) {
  Cure cure{input, leans};
  parallel_for(cures.size(), kCureGrain, [&](std::size_t begin, std::size_t end) {
    PerpendicularScratch scratch;
    for (std::size_t v = begin; v < end; ++v) {
      if (cures[v] > 0) cure.change(static_cast<std::int32_t>(v), cures[v], true, scratch);
    }
  });
  if (input.halo) input.halo->exchange_state(input.offsets);
  return cure.count();
}

}  // namespace planish
