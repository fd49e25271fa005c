#include "planish/fair/semi_sharp.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"

namespace planish {

// A derivation of our own. Beside a crease two control points of each side make a quadratic
// B-spline across it: with the inner ones at a distance e from it and the outer ones at L most of
// its turn is within about e^2 / L. So a share f of the smooth net's e turns within f^2 of its
// distance, where one more of sharpness halves that of a Catmull-Clark surface.

namespace {

bool is_semi_sharp(float sharpness) { return sharpness > 0 && sharpness < kInfiniteSharpness; }

// Of the share's logarithm to the base 2, for one more of sharpness. With 1/2 half of the turn is
// within the distance that Catmull-Clark has, with 0.6 three quarters of it are.
constexpr double kFallOfShare = 0.6;

// Rounds in which what a tag is worth spreads over vertices without one.
constexpr int kSpreadRounds = 4;

// How much of the smooth net is left at each vertex: at tags what they leave, f; elsewhere f^2 of
// those around, so that the faces beside an edge are flat as soon as it turns within them, even
// over a mesh of one sharpness.
std::vector<double> shares_of_vertices(const MeshTopology& topology, const SemiSharpTags& tags) {
  const auto count = static_cast<std::size_t>(topology.vertex_count());
  std::vector<double> shares(count, -1);
  std::vector<std::uint8_t> is_tagged(count, 0);
  std::vector<std::int32_t> reached;
  const auto each_edge_at = [&](std::int32_t v, const auto& visit) {
    for (const std::int32_t c : topology.corners_at(v)) {
      visit(topology.edge_of(c), topology.vertex_of(topology.next(c)));
      const std::int32_t before = topology.prev(c);
      if (topology.twin(before) < 0) visit(topology.edge_of(before), topology.vertex_of(before));
    }
  };
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v) {
    double sum = 0;
    int tagged = 0;
    each_edge_at(v, [&](std::int32_t edge, std::int32_t) {
      if (tags.of_edge[edge] >= 1) return;
      sum += tags.of_edge[edge];
      ++tagged;
    });
    const double share = tagged > 0 ? std::min(sum / tagged, tags.of_vertex[v]) : tags.of_vertex[v];
    if (share >= 1) continue;
    shares[v] = share;
    is_tagged[v] = 1;
    reached.push_back(v);
  }
  // The nearest first.
  for (std::size_t i = 0; i < reached.size(); ++i)
    each_edge_at(reached[i], [&](std::int32_t, std::int32_t other) {
      if (shares[other] >= 0) return;
      const double share = shares[reached[i]];
      shares[other] = is_tagged[reached[i]] != 0 ? share * share : share;
      reached.push_back(other);
    });
  for (int round = 0; round < kSpreadRounds; ++round) {
    const std::vector<double> before = shares;
    for (const std::int32_t v : reached) {
      if (is_tagged[v] != 0) continue;
      double sum = 0;
      int around = 0;
      each_edge_at(v, [&](std::int32_t, std::int32_t other) {
        sum += is_tagged[other] != 0 ? before[other] * before[other] : before[other];
        ++around;
      });
      shares[v] = sum / around;
    }
  }
  // Parts of the mesh without any.
  std::ranges::replace(shares, -1.0, 1.0);
  return shares;
}

class Blend {
 public:
  Blend(const Subdivision& smooth, const Subdivision& sharp, const SemiSharpTags& tags,
        std::span<const glm::dvec3> given, std::span<const glm::dvec3> sharp_state)
      : smooth_(smooth),
        sharp_(sharp),
        topology_(smooth.topology()),
        tags_(tags),
        given_(given),
        sharp_state_(sharp_state) {}

  // The control points of a vertex in the sharp net, or where its rules would not let the surface
  // pass through the vertex what comes next to them.
  [[nodiscard]] glm::dvec3 target(std::int32_t corner) const {
    const std::int32_t vertex = topology_.vertex_of(corner);
    const bool must_centre = is_ring(smooth_, vertex);
    if (!has_tag(vertex) || (must_centre && is_ring(sharp_, vertex))) return sharp_state_[corner];
    const VertexKind kind = sharp_.features().vertex_kinds[vertex];
    if (must_centre && kind == VertexKind::Corner) return given_[vertex];
    // Beside an edge its curve point; the mean of a sector is the vertex, as the curve has it
    // there.
    glm::dvec3 sum(0.0);
    int beside = 0;
    const std::int32_t before = topology_.prev(corner);
    for (const auto& [edge, end] : {std::pair{topology_.edge_of(corner), corner},
                                    std::pair{topology_.edge_of(before), before}}) {
      if (!(must_centre ? sharp_.sharp_of_edge(edge) >= 0 : tags_.of_edge[edge] < 1)) continue;
      sum += sharp_state_[curve_point(sharp_, edge, vertex)];
      ++beside;
    }
    if (beside > 0) return sum / static_cast<double>(beside);
    return must_centre ? given_[vertex] : sharp_state_[corner];
  }

  // Points of curves that are sharp in both nets. Those of a dart are the mean of the two beside
  // them; those that more curves meet in the sharp net stay, for the surface passes through their
  // middle.
  void blend_curve(std::int32_t edge, std::int32_t vertex, double share,
                   std::span<glm::dvec3> state) const {
    const VertexKind kind = smooth_.features().vertex_kinds[vertex];
    glm::dvec3& point = state[curve_point(smooth_, edge, vertex)];
    if (kind == VertexKind::Dart) {
      glm::dvec3 sum(0.0);
      for (const std::int32_t tail :
           {topology_.corner_of(edge), topology_.twin(topology_.corner_of(edge))})
        sum += state[topology_.vertex_of(tail) == vertex ? tail : topology_.next(tail)];
      point = 0.5 * sum;
    } else if (kind == sharp_.features().vertex_kinds[vertex]) {
      point = mixed(sharp_state_[curve_point(sharp_, edge, vertex)], point, share);
    }
  }

  [[nodiscard]] static glm::dvec3 mixed(const glm::dvec3& sharp, const glm::dvec3& smooth,
                                        double share) {
    return sharp + share * (smooth - sharp);
  }

 private:
  // Whether the surface passes through the centroid of the polygon around a vertex.
  [[nodiscard]] static bool is_ring(const Subdivision& subdivision, std::int32_t vertex) {
    const VertexKind kind = subdivision.features().vertex_kinds[vertex];
    return kind == VertexKind::Smooth || kind == VertexKind::Dart;
  }
  [[nodiscard]] bool has_tag(std::int32_t vertex) const {
    if (tags_.of_vertex[vertex] < 1) return true;
    for (const std::int32_t c : topology_.corners_at(vertex))
      if (tags_.of_edge[topology_.edge_of(c)] < 1 ||
          tags_.of_edge[topology_.edge_of(topology_.prev(c))] < 1)
        return true;
    return false;
  }
  [[nodiscard]] std::int32_t curve_point(const Subdivision& subdivision, std::int32_t edge,
                                         std::int32_t vertex) const {
    const bool is_first = topology_.edge_vertices(edge).first == vertex;
    return subdivision.first_sharp() + 2 * subdivision.sharp_of_edge(edge) + (is_first ? 0 : 1);
  }

  const Subdivision &smooth_, &sharp_;
  const MeshTopology& topology_;
  const SemiSharpTags& tags_;
  std::span<const glm::dvec3> given_, sharp_state_;
};

}  // namespace

bool has_semi_sharp(const PolygonMesh& mesh) {
  return std::ranges::any_of(mesh.creases, is_semi_sharp, &CreaseEdge::sharpness) ||
         std::ranges::any_of(mesh.corners, is_semi_sharp, &CornerVertex::sharpness);
}

PolygonMesh with_semi_sharp_as_sharp(PolygonMesh mesh) {
  for (CreaseEdge& crease : mesh.creases)
    if (is_semi_sharp(crease.sharpness)) crease.sharpness = kInfiniteSharpness;
  for (CornerVertex& corner : mesh.corners)
    if (is_semi_sharp(corner.sharpness)) corner.sharpness = kInfiniteSharpness;
  return mesh;
}

double smooth_share(float sharpness) { return portable::pow(2.0, -kFallOfShare * sharpness); }

SemiSharpTags semi_sharp_tags(const PolygonMesh& mesh, const MeshTopology& topology) {
  SemiSharpTags tags{std::vector<double>(static_cast<std::size_t>(topology.edge_count()), 1.0),
                     std::vector<double>(mesh.positions.size(), 1.0)};
  const auto share_of_tag = [](float sharpness) {
    return is_semi_sharp(sharpness) ? smooth_share(sharpness) : 1.0;
  };
  for (const CreaseEdge& crease : mesh.creases) {
    const std::int32_t edge = topology.find_edge(crease.v0, crease.v1);
    if (edge >= 0 && !topology.is_boundary_edge(edge))
      tags.of_edge[edge] = share_of_tag(crease.sharpness);
  }
  for (const CornerVertex& corner : mesh.corners)
    tags.of_vertex[corner.vertex] = share_of_tag(corner.sharpness);
  return tags;
}

void blend_semi_sharp(const Subdivision& smooth, const Subdivision& sharp,
                      const SemiSharpTags& tags, std::span<const glm::dvec3> given,
                      std::span<const glm::dvec3> sharp_state, std::span<glm::dvec3> state) {
  const MeshTopology& topology = smooth.topology();
  PLANISH_ASSERT(std::ssize(state) == smooth.state_size());
  PLANISH_ASSERT(std::ssize(sharp_state) == sharp.state_size());
  const std::vector<double> shares = shares_of_vertices(topology, tags);
  const Blend blend(smooth, sharp, tags, given, sharp_state);
  parallel_each(static_cast<std::size_t>(topology.corner_count()), [&](std::int32_t corner) {
    const double share = shares[topology.vertex_of(corner)];
    if (share < 1) state[corner] = Blend::mixed(blend.target(corner), state[corner], share);
  });
  for (std::int32_t s = 0; s < smooth.features().sharp_edge_count; ++s) {
    const std::int32_t edge = smooth.edge_of_sharp(s);
    const auto [v0, v1] = topology.edge_vertices(edge);
    for (const std::int32_t vertex : {v0, v1})
      if (shares[vertex] < 1) blend.blend_curve(edge, vertex, shares[vertex], state);
  }
}

}  // namespace planish
