#include "planish/fair/fold_repair.h"

#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "planish/core/parallel.h"
#include "planish/fair/net_samples.h"

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

// Counts the folded elements and flags their vertices.
FoldCount find_folds(const FoldTest& test, std::span<std::uint8_t> flags) {
  const FairTopology& topology = test.samples.topology;
  std::atomic<std::int64_t> edges = 0, faces = 0;
  parallel_each(topology.edge_corners.size(), kRepairGrain, [&](std::size_t e) {
    const FairTopology::Edge edge = topology.edge(e);
    if (!test.edge_is_folded(edge)) return;
    if (owns_face(test.halo, edge.faces[0])) ++edges;
    flag(flags, topology.corner_vertices[edge.corners[0]]);
    flag(flags, topology.corner_vertices[edge.corners[1]]);
  });
  parallel_each(static_cast<std::size_t>(topology.face_count), kRepairGrain,
                [&](std::int32_t face) {
                  if (!test.face_is_folded(face)) return;
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
  return find_folds({{topology, given, offsets}, face_normals}, flags);
}

FoldCount repair_folds(const FairTopology& topology, std::span<const dvec3> given,
                       std::span<const dvec3> face_normals, std::span<dvec3> offsets,
                       std::span<std::uint8_t> halvings, FairHalo* halo) {
  const FoldTest test{{topology, given, offsets}, face_normals, halo};
  std::vector<std::uint8_t> round_halvings(halvings.size());
  for (int round = 0;; ++round) {
    std::vector<std::uint8_t> flags(halvings.size(), 0);
    FoldCount folds = find_folds(test, flags);
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

}  // namespace planish
