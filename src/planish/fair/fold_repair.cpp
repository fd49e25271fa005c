#include "planish/fair/fold_repair.h"

#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>

#include "planish/core/parallel.h"
#include "planish/fair/limit_normal.h"

namespace planish {

using glm::dvec3;

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
  const FairTopology& topology;
  std::span<const dvec3> given, face_normals, offsets;
  FairHalo* halo = nullptr;

  [[nodiscard]] dvec3 point(std::int32_t corner) const {
    return given[topology.corner_vertices[corner]] + offsets[corner];
  }

  [[nodiscard]] bool edge_is_folded(const FairTopology::Edge& edge) const {
    const dvec3 normal = glm::cross(point(edge.corners[2]) - point(edge.corners[0]),
                                    point(edge.corners[3]) - point(edge.corners[1]));
    const dvec3& f = face_normals[edge.faces[0]];
    const dvec3& g = face_normals[edge.faces[1]];
    const double length = glm::length(f + g);
    if (!(length > 0)) return false;  // a knife's edge has no normal to compare with
    // length / 2 is the cosine of half the dihedral turn.
    return !agrees(normal, (f + g) / length, kLeastCosine * length / 2);
  }

  [[nodiscard]] bool face_is_folded(std::int32_t face) const {
    const std::int32_t first = topology.face_offsets[face];
    const dvec3 normal = limit_normal(topology, topology.face_size(face),
                                      [&](std::int32_t i) { return point(first + i); });
    return !agrees(normal, face_normals[face], kLeastCosine);
  }
};

// Flags of vertices, set from several threads: whoever sets, sets the same.
class VertexFlags {
 public:
  explicit VertexFlags(std::int32_t count) : flags_(static_cast<std::size_t>(count), 0) {}
  void set(std::int32_t vertex) {
    std::atomic_ref(flags_[vertex]).store(1, std::memory_order_relaxed);
  }
  [[nodiscard]] bool operator[](std::size_t vertex) const { return flags_[vertex] != 0; }

 private:
  std::vector<std::uint8_t> flags_;
};

// Counts the folded elements and flags their vertices.
FoldCount find_folds(const FoldTest& test, VertexFlags& flags) {
  const FairTopology& topology = test.topology;
  std::atomic<std::int64_t> edges = 0, faces = 0;
  parallel_for(topology.edges.size(), kRepairGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const FairTopology::Edge& edge = topology.edges[e];
      if (!test.edge_is_folded(edge)) continue;
      if (owns_face(test.halo, edge.faces[0])) ++edges;
      flags.set(topology.corner_vertices[edge.corners[0]]);
      flags.set(topology.corner_vertices[edge.corners[1]]);
    }
  });
  parallel_for(static_cast<std::size_t>(topology.face_count), kRepairGrain,
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t f = begin; f < end; ++f) {
                   const auto face = static_cast<std::int32_t>(f);
                   if (!test.face_is_folded(face)) continue;
                   if (owns_face(test.halo, face)) ++faces;
                   for (std::int32_t c = topology.face_offsets[f]; c < topology.face_offsets[f + 1];
                        ++c) {
                     flags.set(topology.corner_vertices[c]);
                   }
                 }
               });
  return sum_of_parts(test.halo, {edges, faces});
}

}  // namespace

void halve_polygons(const FairTopology& topology, std::span<const std::uint8_t> halvings,
                    std::span<dvec3> offsets) {
  parallel_for(halvings.size(), kRepairGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (halvings[v] == 0) continue;
      const double factor = std::ldexp(1.0, -halvings[v]);
      for (std::int32_t i = topology.ring_offsets[v]; i < topology.ring_offsets[v + 1]; ++i) {
        offsets[topology.ring_corners[i]] *= factor;
      }
    }
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
  VertexFlags flags(topology.vertex_count);
  return find_folds({topology, given, face_normals, offsets}, flags);
}

FoldCount repair_folds(const FairTopology& topology, std::span<const dvec3> given,
                       std::span<const dvec3> face_normals, std::span<dvec3> offsets,
                       std::span<std::uint8_t> halvings, FairHalo* halo) {
  const FoldTest test{topology, given, face_normals, offsets, halo};
  std::vector<std::uint8_t> round_halvings(halvings.size());
  for (int round = 0;; ++round) {
    VertexFlags flags(topology.vertex_count);
    const FoldCount folds = find_folds(test, flags);
    if (round == kRepairRounds || folds.edges + folds.faces == 0) return folds;
    for (std::size_t v = 0; v < halvings.size(); ++v) {
      // Corner points and the curves that end there are where they must be.
      const bool halve =
          flags[v] && topology.kind(static_cast<std::int32_t>(v)) != VertexKind::Corner;
      round_halvings[v] = halve ? 1 : 0;
      halvings[v] = static_cast<std::uint8_t>(halvings[v] + round_halvings[v]);
    }
    halve_polygons(topology, round_halvings, offsets);
    if (halo) halo->exchange_state(offsets);
  }
}

}  // namespace planish
