#include "planish/mesh/detect_creases.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/core/raw_vector.h"
#include "planish/core/work.h"
#include "planish/mesh/angle_between.h"
#include "planish/mesh/coherent_edges.h"
#include "planish/mesh/cone_apexes.h"
#include "planish/mesh/disjoint_sets.h"
#include "planish/mesh/face_areas.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

namespace {

constexpr std::size_t kDetectGrain = 4096;
constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kRightAngle = std::numbers::pi / 2;

// Two edges of a line that enclose less than this fold it back on itself: on needles both long
// edges are sharp, and neither is a feature.
constexpr double kFoldBackDegrees = 15;
// A line goes on straight where it turns by less.
constexpr double kStraightDegrees = 30;
// Where more lines meet, none goes on.
constexpr std::size_t kMostLines = 16;
// Of so many lines that meet the last one goes with the others: it crosses them.
constexpr std::size_t kCrossing = 4;
// What the sharpest edge of a line has to turn by where none is beyond doubt.
constexpr double kLineDegrees = 50;
// What a ring of weaker edges has to have: so many, and of the sharpest one's turn each so much.
constexpr std::size_t kRingEdges = 8;
constexpr double kEvenShare = 0.8;

struct Edge {
  std::int32_t v0, v1;
  std::int32_t number;  // in the topology
  bool given;           // tagged as sharp by the mesh, or a boundary: stays
  double angle;         // between its faces, radians
  bool stands_out;      // from its surroundings
  bool is_clear;        // by far
};

void require_angle(double degrees, const char* name) {
  if (degrees >= 0 && degrees <= 180) return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("{} angle {} is outside 0 to 180 degrees", name, std::to_string(degrees)));
}

// Whether the angle is less than the one of that slope without any doubt by rounding: most are, and
// need no arctangent.
bool is_flatter(const glm::dvec3& a, const glm::dvec3& b, double slope) {
  constexpr double kMargin = 1 - 1e-9;
  const glm::dvec3 turn = glm::cross(a, b);
  const double along = glm::dot(a, b);
  return along > 0 && glm::dot(turn, turn) < kMargin * slope * slope * along * along;
}

using VertexPair = std::pair<std::int32_t, std::int32_t>;

std::set<VertexPair> tagged_edges(const PolygonMesh& mesh) {
  std::set<VertexPair> tagged;
  for (const CreaseEdge& crease : mesh.creases) {
    if (crease.sharpness >= kInfiniteSharpness) tagged.insert(std::minmax(crease.v0, crease.v1));
  }
  return tagged;
}

// By lower vertex, then by higher.
std::vector<Edge> sharp_edges(const PolygonMesh& mesh, const MeshTopology& topology,
                              std::span<const glm::dvec3> normals, double dihedral) {
  const std::set<VertexPair> tagged = tagged_edges(mesh);
  const double slope = dihedral < kRightAngle ? std::tan(dihedral) : 0;
  const auto ends_of = [&](std::int32_t edge) {
    const auto [v0, v1] = topology.edge_vertices(edge);
    return VertexPair(std::minmax(v0, v1));
  };
  enum : std::uint8_t { Smooth, Found, Given };
  RawVector<std::uint8_t> kinds(static_cast<std::size_t>(topology.edge_count()));
  const auto angle_at = [&](std::int32_t edge) {
    if (topology.is_boundary_edge(edge)) return 0.0;
    const std::int32_t corner = topology.corner_of(edge);
    return angle_between(normals[topology.face_of(corner)],
                         normals[topology.face_of(topology.twin(corner))]);
  };
  parallel_each(kinds.size(), kDetectGrain, [&](std::int32_t edge) {
    if (topology.is_boundary_edge(edge) || (!tagged.empty() && tagged.contains(ends_of(edge)))) {
      kinds[edge] = Given;
      return;
    }
    kinds[edge] = Smooth;
    if (dihedral >= std::numbers::pi) return;
    const std::int32_t corner = topology.corner_of(edge);
    const glm::dvec3& a = normals[topology.face_of(corner)];
    const glm::dvec3& b = normals[topology.face_of(topology.twin(corner))];
    if (!is_flatter(a, b, slope) && angle_between(a, b) > dihedral) kinds[edge] = Found;
  });
  const EdgeTurns turns(mesh, topology, normals);
  const auto is_sharp = [&](std::size_t e) { return kinds[e] != Smooth; };
  const SelectedBlocks blocks = count_selected(kinds.size(), is_sharp);
  std::vector<Edge> edges(static_cast<std::size_t>(blocks.total));
  for_selected(kinds.size(), blocks, is_sharp, [&](std::size_t e, std::int32_t number) {
    const auto edge = static_cast<std::int32_t>(e);
    const auto [lower, higher] = ends_of(edge);
    edges[number] = {lower,
                     higher,
                     edge,
                     kinds[e] == Given,
                     angle_at(edge),
                     kinds[e] == Given || turns.stands_out(edge),
                     kinds[e] == Given || turns.is_clear(edge)};
  });
  std::ranges::sort(edges, {}, [](const Edge& edge) { return VertexPair(edge.v0, edge.v1); });
  return edges;
}

// The numbers of the sharp edges at every vertex, in ascending order.
Groups<std::int32_t> edges_of_vertices(const PolygonMesh& mesh, const std::vector<Edge>& edges) {
  return group_by<std::int32_t>(mesh.positions.size(), [&](const auto& take) {
    for (std::size_t e = 0; e < edges.size(); ++e)
      for (const std::int32_t v : {edges[e].v0, edges[e].v1}) take(v, static_cast<std::int32_t>(e));
  });
}

glm::dvec3 along(const PolygonMesh& mesh, const Edge& edge, std::int32_t from) {
  return mesh.positions[edge.v0 == from ? edge.v1 : edge.v0] - mesh.positions[from];
}

// Edges that do not stand out stay only where they carry a line on that does, or are all that is
// left where four meet.
void drop_incoherent(const PolygonMesh& mesh, std::vector<Edge>& edges) {
  const Groups<std::int32_t> sharp = edges_of_vertices(mesh, edges);
  std::vector<std::int32_t> reached;
  std::vector<std::uint8_t> stays(edges.size(), 0);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (!edges[e].stands_out) continue;
    stays[e] = 1;
    reached.push_back(static_cast<std::int32_t>(e));
  }
  while (!reached.empty()) {
    const std::int32_t e = reached.back();
    reached.pop_back();
    for (const std::int32_t vertex : {edges[e].v0, edges[e].v1}) {
      const auto at = sharp.of(vertex);
      if (at.size() > kMostLines) continue;
      count_work(Work::Pairs, static_cast<std::int64_t>(at.size()));
      const auto left = std::ranges::count_if(at, [&](std::int32_t i) { return stays[i] == 0; });
      const bool is_crossing = left == 1 && at.size() == kCrossing;
      for (const std::int32_t other : at) {
        if (stays[other]) continue;
        const double turn =
            angle_between(-along(mesh, edges[e], vertex), along(mesh, edges[other], vertex));
        if (turn > kStraightDegrees * kRadians && !is_crossing) continue;
        stays[other] = 1;
        reached.push_back(other);
      }
    }
  }
  std::size_t next = 0;
  std::erase_if(edges, [&](const Edge&) { return stays[next++] == 0; });
}

// Lines of found edges of which none is sharp beyond doubt are noise, but for rings that turn alike
// all around, as rims between round faces do.
void drop_weak_lines(const PolygonMesh& mesh, std::vector<Edge>& edges) {
  struct Line {
    double flattest = std::numbers::pi, sharpest = 0;
    std::size_t edge_count = 0;
    bool is_ring = true;
    [[nodiscard]] bool is_even_ring() const {
      return is_ring && edge_count >= kRingEdges && flattest >= kEvenShare * sharpest;
    }
  };
  DisjointSets lines(static_cast<std::int32_t>(mesh.positions.size()));
  std::vector<std::uint8_t> ends_at(mesh.positions.size(), 0);
  for (const Edge& edge : edges) {
    if (edge.given) continue;
    lines.unite(edge.v0, edge.v1);
    for (const std::int32_t v : {edge.v0, edge.v1})
      ends_at[v] = static_cast<std::uint8_t>(std::min(ends_at[v] + 1, 3));
  }
  std::vector<Line> at(mesh.positions.size());
  for (const Edge& edge : edges) {
    if (edge.given) continue;
    Line& line = at[lines.find(edge.v0)];
    line.flattest = std::min(line.flattest, edge.angle);
    line.sharpest = std::max(line.sharpest, edge.is_clear ? std::numbers::pi : edge.angle);
    line.is_ring &= ends_at[edge.v0] == 2 && ends_at[edge.v1] == 2;
    ++line.edge_count;
  }
  std::erase_if(edges, [&](const Edge& edge) {
    if (edge.given) return false;
    const Line& line = at[lines.find(edge.v0)];
    return line.sharpest < kLineDegrees * kRadians && !line.is_even_ring();
  });
}

// Of every two edges that fold a line back, the flatter one that was found goes; flattest first, so
// that the order of the edges does not matter.
void drop_fold_backs(const PolygonMesh& mesh, std::vector<Edge>& edges) {
  std::vector<std::int32_t> order(edges.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return edges[a].angle < edges[b].angle; });
  const Groups<std::int32_t> sharp = edges_of_vertices(mesh, edges);
  std::vector<std::uint8_t> dropped(edges.size(), 0);
  const auto folds_back = [&](std::int32_t e, std::int32_t vertex) {
    if (sharp.of(vertex).size() != 2) return false;  // the tip of a spike
    const glm::dvec3 own = along(mesh, edges[e], vertex);
    return std::ranges::any_of(sharp.of(vertex), [&](std::int32_t other) {
      return other != e && !dropped[other] &&
             angle_between(own, along(mesh, edges[other], vertex)) < kFoldBackDegrees * kRadians;
    });
  };
  for (const std::int32_t e : order) {
    if (edges[e].given) continue;
    dropped[e] = folds_back(e, edges[e].v0) || folds_back(e, edges[e].v1);
  }
  std::size_t next = 0;
  std::erase_if(edges, [&](const Edge&) { return dropped[next++] != 0; });
}

// Where a line of two edges turns too far, and cones end.
void tag_corners(PolygonMesh& mesh, const std::vector<Edge>& edges,
                 std::span<const std::int32_t> apexes, const CreaseDetectionOptions& options) {
  std::set<std::int32_t> tagged;
  for (const CornerVertex& corner : mesh.corners) tagged.insert(corner.vertex);
  const Groups<std::int32_t> sharp = edges_of_vertices(mesh, edges);
  const auto turns_far = [&](std::int32_t v) {
    const auto at = sharp.of(v);
    if (at.size() != 2) return false;
    const glm::dvec3 in = -along(mesh, edges[at[0]], v), out = along(mesh, edges[at[1]], v);
    return angle_between(in, out) > options.corner_degrees * kRadians;
  };
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (tagged.contains(v)) continue;
    if (!options.smooth_vertices.empty() && options.smooth_vertices[v]) continue;
    if (turns_far(v) || std::ranges::binary_search(apexes, v))
      mesh.corners.push_back({v, kInfiniteSharpness});
  }
}

}  // namespace

void detect_creases(PolygonMesh& mesh, const MeshTopology& topology,
                    const CreaseDetectionOptions& options) {
  require_angle(options.dihedral_degrees, "crease");
  require_angle(options.corner_degrees, "corner");
  const std::size_t flags = options.smooth_vertices.size();
  if (flags != 0 && flags != mesh.positions.size())
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("smooth_vertices has {} flags for {} vertices; give one a vertex, or none", flags,
                  mesh.positions.size()));
  const std::vector<glm::dvec3> normals = face_areas(mesh);
  std::vector<Edge> edges =
      sharp_edges(mesh, topology, normals, options.dihedral_degrees * kRadians);
  drop_incoherent(mesh, edges);
  drop_fold_backs(mesh, edges);
  drop_weak_lines(mesh, edges);
  if (!options.smooth_vertices.empty()) {
    std::erase_if(edges, [&](const Edge& edge) {
      return !edge.given && (options.smooth_vertices[edge.v0] || options.smooth_vertices[edge.v1]);
    });
  }

  std::vector<std::int32_t> degree(mesh.positions.size(), 0);
  const auto count = [&](const Edge& edge, int by) {
    degree[edge.v0] += by;
    degree[edge.v1] += by;
  };
  for (const Edge& edge : edges) count(edge, 1);
  // A single edge between smooth surroundings is noise, not a feature.
  std::erase_if(edges, [&](const Edge& edge) {
    const bool lonely = !edge.given && degree[edge.v0] == 1 && degree[edge.v1] == 1;
    if (lonely) count(edge, -1);
    return lonely;
  });

  // Where an edge is found sharp, a lower sharpness of its own would speak against it.
  const auto is_found = [&](const VertexPair& ends) {
    const auto place = std::ranges::lower_bound(
        edges, ends, {}, [](const Edge& edge) { return VertexPair(edge.v0, edge.v1); });
    return place != edges.end() && VertexPair(place->v0, place->v1) == ends;
  };
  std::erase_if(mesh.creases, [&](const CreaseEdge& crease) {
    return crease.sharpness < kInfiniteSharpness && is_found(std::minmax(crease.v0, crease.v1));
  });
  for (const Edge& edge : edges) {
    if (!edge.given) mesh.creases.push_back({edge.v0, edge.v1, kInfiniteSharpness});
  }
  std::vector<std::uint8_t> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  for (const Edge& edge : edges) is_sharp[edge.number] = 1;
  tag_corners(mesh, edges, cone_apexes(topology, normals, is_sharp), options);
}

PolygonMesh with_detected_creases(const PolygonMesh& mesh, const CreaseDetectionOptions& options) {
  PolygonMesh result = mesh;
  detect_creases(result, usable_topology(mesh, "mesh"), options);
  return result;
}

}  // namespace planish
