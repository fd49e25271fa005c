#include "planish/fair/fold_cure.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/fair/hub_ellipse.h"
#include "planish/fair/net_samples.h"
#include "planish/fair/perpendicular_curve.h"
#include "planish/fair/perpendicular_polygon.h"
#include "planish/fair/plane_lean.h"
#include "planish/fair/smallest_cap.h"

namespace planish {

using glm::dvec3;

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
  if (times > 0) scale_curve_vertex(site, std::pow(kQuarter, times));
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
