#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/words.h"
#include "planish/mend/faults.h"
#include "planish/mend/repair.h"
#include "planish/mesh/edge_groups.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/sound_topology.h"

namespace planish {
namespace {

// What edges of no length join.
struct Cluster {
  glm::dvec3 low, high;
  double reach = 0;  // the longest edge that leads away, in diagonals
};

bool faces_are_in_range(const PolygonMesh& mesh) {
  const auto corners = static_cast<std::int32_t>(mesh.face_vertices.size());
  return std::max(mesh.positions.size(), mesh.face_vertices.size()) <=
             static_cast<std::size_t>(kMaxInt32) &&
         !mesh.face_offsets.empty() && mesh.face_offsets.front() == 0 &&
         mesh.face_offsets.back() == corners && std::ranges::is_sorted(mesh.face_offsets) &&
         std::ranges::all_of(mesh.face_vertices,
                             [&](std::int32_t v) { return v >= 0 && v < mesh.vertex_count(); });
}

// Edges in units of the diagonal, whose squares are numbers however small the mesh is.
struct Edges {
  const PolygonMesh& mesh;
  double diagonal;

  // Calls visit(v0, v1, length) for those of these faces, twice where two faces are.
  template <class Visit>
  void visit(std::size_t begin, std::size_t end, const Visit& visit) const {
    for (std::size_t f = begin; f < end; ++f) {
      const auto face = mesh.face(static_cast<std::int32_t>(f));
      for (std::size_t i = 0; i < face.size(); ++i) {
        const std::int32_t v0 = face[i], v1 = face[i + 1 < face.size() ? i + 1 : 0];
        if (v0 == v1) continue;
        visit(v0, v1, glm::length((mesh.positions[v1] - mesh.positions[v0]) / diagonal));
      }
    }
  }
};

}  // namespace

std::vector<std::int32_t> short_edge_targets(const PolygonMesh& mesh) {
  if (!faces_are_in_range(mesh) || !positions_are_finite(mesh)) return {};
  const Edges edges{mesh, placement_of(mesh).diagonal};
  const auto face_count = static_cast<std::size_t>(mesh.face_count());
  const bool is_any = ordered_reduce(
      face_count, 4096, false,
      [&](std::size_t begin, std::size_t end) {
        bool found = false;
        edges.visit(begin, end, [&](auto, auto, double length) { found |= length <= kShortEdge; });
        return found;
      },
      [](bool& total, bool found) { total |= found; });
  if (!is_any) return {};

  DisjointSets joined(mesh.positions.size());
  edges.visit(0, face_count, [&](std::int32_t v0, std::int32_t v1, double length) {
    if (length <= kShortEdge) joined.unite(v0, v1);
  });
  std::unordered_map<std::int32_t, Cluster> clusters;  // by their first vertex
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    const std::int32_t first = joined.find(v);
    if (first == v) continue;
    const glm::dvec3 &start = mesh.positions[first], &own = mesh.positions[v];
    Cluster& cluster = clusters.try_emplace(first, Cluster{start, start}).first->second;
    cluster.low = glm::min(cluster.low, own);
    cluster.high = glm::max(cluster.high, own);
  }
  edges.visit(0, face_count, [&](std::int32_t v0, std::int32_t v1, double length) {
    const std::int32_t first0 = joined.find(v0), first1 = joined.find(v1);
    if (first0 == first1) return;
    for (const std::int32_t first : {first0, first1}) {
      const auto found = clusters.find(first);
      if (found != clusters.end()) found->second.reach = std::max(found->second.reach, length);
    }
  });
  DisjointSets taken(mesh.positions.size());
  bool takes_any = false;
  edges.visit(0, face_count, [&](std::int32_t v0, std::int32_t v1, double length) {
    if (length > kShortEdge) return;
    const Cluster& cluster = clusters.at(joined.find(v0));
    const double extent = glm::length((cluster.high - cluster.low) / edges.diagonal);
    if (length > 0 && extent > kShortShare * cluster.reach) return;
    taken.unite(v0, v1);
    takes_any = true;
  });
  if (!takes_any) return {};
  std::vector<std::int32_t> targets(mesh.positions.size());
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) targets[v] = taken.find(v);
  return targets;
}

namespace {

using CellKey = std::array<std::uint64_t, 3>;

std::uint64_t cell_hash(const CellKey& key) {
  std::uint64_t hash = 0;
  for (const std::uint64_t part : key) {
    // The constants are those of the splitmix64 generator.
    hash ^= part;
    hash *= 0xbf58476d1ce4e5b9u;
    hash ^= hash >> 31;
    hash *= 0x94d049bb133111ebu;
    hash ^= hash >> 29;
  }
  return hash;
}

// The vertices that stay, by the cell of a grid. Cells are twice as long as the reach: whatever is
// within reach of a point lies in eight of them, and as those that stay are farther apart than the
// reach, a cell holds a few dozen at most. With a reach of 0 each position is a cell of its own.
// Places in the grid are rounded by up to 1e-4 of the smallest reach, hence the margin.
class StayingVertices {
 public:
  StayingVertices(std::span<const glm::dvec3> positions, const glm::dvec3& lowest, double reach)
      : positions_(positions),
        lowest_(lowest),
        reach_(reach),
        half_cell_(1.001 * reach),
        first_(std::bit_ceil(2 * positions.size() + 1), -1),
        next_(positions.size(), -1) {}

  // The nearest that stays within reach of the vertex, the first of equally near ones; -1: none.
  [[nodiscard]] std::int32_t nearest(std::int32_t vertex) const {
    std::int32_t best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int side = 0; side < (reach_ > 0 ? 8 : 1); ++side) {
      const CellKey key = key_of(positions_[vertex], side);
      for (std::int32_t other = first_[slot_of(key)]; other >= 0; other = next_[other]) {
        // Chains hold other cells too, of the same slot.
        const double distance = glm::distance(positions_[other], positions_[vertex]);
        if (distance > reach_ || distance > least || (distance == least && other > best)) continue;
        least = distance;
        best = other;
      }
    }
    return best;
  }

  void add(std::int32_t vertex) {
    std::int32_t& first = first_[slot_of(key_of(positions_[vertex], -1))];
    next_[vertex] = std::exchange(first, vertex);
  }

 private:
  // Of the cell that holds the position (side -1), or one of the eight that reach it.
  [[nodiscard]] CellKey key_of(const glm::dvec3& position, int side) const {
    CellKey key;
    for (int axis = 0; axis < 3; ++axis) {
      if (reach_ == 0) {
        key[axis] = std::bit_cast<std::uint64_t>(position[axis] + 0.0);  // -0.0 is 0.0
        continue;
      }
      const double half_cells = (position[axis] - lowest_[axis]) / half_cell_;
      const auto half = static_cast<std::int64_t>(std::floor(half_cells));
      std::int64_t cell = half / 2;
      if (side >= 0 && ((side >> axis) & 1) != 0) cell += half % 2 != 0 ? 1 : -1;
      key[axis] = static_cast<std::uint64_t>(cell);
    }
    return key;
  }
  [[nodiscard]] std::size_t slot_of(const CellKey& key) const {
    return cell_hash(key) & (first_.size() - 1);
  }

  std::span<const glm::dvec3> positions_;
  glm::dvec3 lowest_;
  double reach_, half_cell_;
  std::vector<std::int32_t> first_, next_;
};

bool can_be_welded(const PolygonMesh& mesh) {
  return mesh.positions.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
         positions_are_finite(mesh) &&
         (mesh.colors.empty() || mesh.colors.size() == mesh.positions.size()) &&
         std::ranges::all_of(mesh.attributes,
                             [&](const VertexAttribute& attribute) {
                               return attribute.count() == mesh.positions.size();
                             }) &&
         std::ranges::all_of(
             mesh.face_vertices,
             [&](std::int32_t vertex) { return vertex >= 0 && vertex < mesh.vertex_count(); }) &&
         has_extent(mesh);
}

// For each vertex the one that it becomes, itself where it stays. Those of no face are left alone:
// they may be anywhere.
std::vector<std::int32_t> targets_of(const PolygonMesh& mesh, double fraction) {
  std::vector<std::uint8_t> is_used(mesh.positions.size(), 0);
  glm::dvec3 lowest(std::numeric_limits<double>::max());
  for (const std::int32_t vertex : mesh.face_vertices) {
    is_used[vertex] = 1;
    lowest = glm::min(lowest, mesh.positions[vertex]);
  }
  StayingVertices staying(mesh.positions, lowest, fraction * placement_of(mesh).diagonal);
  std::vector<std::int32_t> targets(mesh.positions.size());
  for (std::size_t v = 0; v < targets.size(); ++v) {
    const auto vertex = static_cast<std::int32_t>(v);
    const std::int32_t near = is_used[v] ? staying.nearest(vertex) : -1;
    targets[v] = near < 0 ? vertex : near;
    if (is_used[v] && near < 0) staying.add(vertex);
  }
  return targets;
}

// Tags that name no vertex keep their number, which no vertex has then either.
void renumber(PolygonMesh& mesh, std::span<const std::int32_t> numbers) {
  const auto number_of = [&](std::int32_t vertex) {
    const bool is_vertex = vertex >= 0 && vertex < std::ssize(numbers);
    return is_vertex ? numbers[vertex] : vertex;
  };
  for (std::int32_t& vertex : mesh.face_vertices) vertex = numbers[vertex];
  std::erase_if(mesh.creases, [&](CreaseEdge& crease) {
    const bool was_edge = crease.v0 != crease.v1;
    crease.v0 = number_of(crease.v0);
    crease.v1 = number_of(crease.v1);
    return was_edge && crease.v0 == crease.v1;
  });
  for (CornerVertex& corner : mesh.corners) corner.vertex = number_of(corner.vertex);
}

// Whether a face has three different targets.
bool leave_a_face(const PolygonMesh& mesh, std::span<const std::int32_t> targets) {
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    std::array<std::int32_t, 2> others{-1, -1};
    for (const std::int32_t vertex : mesh.face(f)) {
      const std::int32_t target = targets[vertex];
      if (target == others[0] || target == others[1]) continue;
      if (others[1] >= 0) return true;
      others[others[0] < 0 ? 0 : 1] = target;
    }
  }
  return false;
}

// Each vertex becomes its target, which is no later one and stays.
WeldedMesh with_targets(PolygonMesh&& mesh, std::vector<std::int32_t> numbers) {
  WeldedMesh result{.mesh = std::move(mesh), .source_vertices = {}};
  PolygonMesh& welded = result.mesh;
  for (std::int32_t v = 0; v < std::ssize(numbers); ++v) {
    const bool stays = numbers[v] == v;
    if (!stays && result.first_welded < 0) result.first_welded = v;
    // Those that stay come first, so that the numbers of earlier ones are final.
    numbers[v] =
        stays ? static_cast<std::int32_t>(result.source_vertices.size()) : numbers[numbers[v]];
    if (stays) result.source_vertices.push_back(v);
  }
  if (result.first_welded < 0) {
    result.source_vertices.clear();
    return result;
  }
  result.welded_count = welded.vertex_count() - std::ssize(result.source_vertices);
  renumber(welded, numbers);
  for (std::size_t v = 0; v < result.source_vertices.size(); ++v) {
    const std::int32_t source = result.source_vertices[v];
    welded.positions[v] = welded.positions[source];
    if (!welded.colors.empty()) welded.colors[v] = welded.colors[source];
  }
  welded.attributes = attributes_of(welded.attributes, result.source_vertices);
  welded.positions.resize(result.source_vertices.size());
  if (!welded.colors.empty()) welded.colors.resize(result.source_vertices.size());
  return result;
}

}  // namespace

WeldedMesh weld_vertices(PolygonMesh&& mesh, double fraction) {
  if (!can_weld_within(fraction))
    throw Error(ErrorCode::InvalidArgument,
                "vertices cannot be welded within " + shortest(fraction) +
                    " of the diagonal; 0, or 1e-12 to less than 0.1, is wanted");
  if (!can_be_welded(mesh)) return {.mesh = std::move(mesh), .source_vertices = {}};
  std::vector<std::int32_t> targets = targets_of(mesh, fraction);
  return with_targets(std::move(mesh), std::move(targets));
}

WeldedMesh weld_short_edges(PolygonMesh&& mesh) {
  std::vector<std::int32_t> targets = short_edge_targets(mesh);
  if (targets.empty() || !can_be_welded(mesh) || !leave_a_face(mesh, targets))
    return {.mesh = std::move(mesh), .source_vertices = {}};
  return with_targets(std::move(mesh), std::move(targets));
}

namespace {

// Of the diagonal: what is left of one position where a file's numbers have six digits.
constexpr double kNearly = 1e-5;

// Of these vertices within `reach` of each other, and of the open edges between them.
TornVertices torn_within(const PolygonMesh& mesh, const MeshTopology& topology,
                         const std::vector<std::int32_t>& vertices, double reach) {
  PolygonMesh ends;  // one face has them all: its corners say what becomes of each
  for (const std::int32_t v : vertices) ends.positions.push_back(mesh.positions[v]);
  std::vector<std::int32_t> all(vertices.size());
  std::iota(all.begin(), all.end(), 0);
  ends.add_face(all);
  const WeldedMesh welded = weld_vertices(std::move(ends), reach);
  if (welded.welded_count == 0) return {};
  const auto places = welded.mesh.face(0);
  const auto place_of = [&](std::int32_t vertex) {
    return places[std::ranges::lower_bound(vertices, vertex) - vertices.begin()];
  };
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  for (std::int32_t edge = 0; edge < topology.edge_count(); ++edge) {
    if (!topology.is_boundary_edge(edge)) continue;
    const auto [a, b] = topology.edge_vertices(edge);
    if (place_of(a) != place_of(b)) edges.emplace_back(std::minmax(place_of(a), place_of(b)));
  }
  std::ranges::sort(edges);
  if (std::ranges::adjacent_find(edges) == edges.end()) return {};
  std::vector<bool> is_taken(welded.mesh.positions.size(), false);
  TornVertices torn{welded.welded_count, -1, reach};
  for (std::size_t i = 0; i < vertices.size() && torn.first < 0; ++i) {
    if (is_taken[places[i]]) torn.first = vertices[i];
    is_taken[places[i]] = true;
  }
  return torn;
}

}  // namespace

TornVertices torn_vertices(const PolygonMesh& mesh, const MeshTopology& topology) {
  std::vector<std::int32_t> vertices;  // at open edges, ascending
  for (std::int32_t v = 0; v < topology.vertex_count(); ++v)
    if (topology.is_boundary_vertex(v)) vertices.push_back(v);
  if (vertices.empty()) return {};
  const TornVertices exactly = torn_within(mesh, topology, vertices, 0);
  return exactly.count > 0 ? exactly : torn_within(mesh, topology, vertices, kNearly);
}

std::string torn_text(const TornVertices& torn) {
  const std::string lie =
      with_separators(torn.count) +
      (torn.count == 1 ? " vertex at open edges lies" : " vertices at open edges lie");
  if (torn.reach == 0) return lie + " exactly where another one does; --weld 0 makes them one";
  char reach[32];
  std::snprintf(reach, sizeof reach, "%g", torn.reach);
  return lie + " within " + reach + " of the diagonal of another one; --weld " + reach +
         " makes them one";
}

}  // namespace planish
