#include "planish/mesh/weld_vertices.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/mesh/placement.h"
#include "planish/mesh/short_edges.h"
#include "planish/mesh/sound_topology.h"

namespace planish {

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

}  // namespace planish
