#include "planish/mesh/placement.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <vector>

#include "planish/core/parallel.h"

namespace planish {

namespace {

struct Box {
  glm::dvec3 low{std::numeric_limits<double>::max()};
  glm::dvec3 high{std::numeric_limits<double>::lowest()};

  void add(const Box& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
};

// Pieces in their order: which of two equal zeros is kept does not depend on threads.
template <class PositionOf>
Box box_of(std::size_t count, const PositionOf& position_of) {
  constexpr std::size_t kPiece = 1 << 14;
  std::vector<Box> pieces((count + kPiece - 1) / kPiece);
  parallel_each(pieces.size(), 1, [&](std::size_t p) {
    Box box;
    for (std::size_t i = p * kPiece; i < std::min(count, (p + 1) * kPiece); ++i) {
      const glm::dvec3& position = position_of(i);
      box.add({position, position});
    }
    pieces[p] = box;
  });
  Box whole;
  for (const Box& box : pieces) whole.add(box);
  return whole;
}

Placement placement_of(const Box& box) {
  const glm::dvec3 extent = box.high - box.low;
  // hypot neither overflows nor underflows on the way, as the root of a sum of squares would.
  const double diagonal = std::hypot(extent.x, extent.y, extent.z);
  return {.centre = 0.5 * box.low + 0.5 * box.high, .diagonal = diagonal > 0 ? diagonal : 1.0};
}

}  // namespace

Placement placement_of(const PolygonMesh& mesh) {
  if (mesh.face_vertices.empty()) return {};
  return placement_of(box_of(mesh.face_vertices.size(), [&](std::size_t c) -> const glm::dvec3& {
    return mesh.positions[mesh.face_vertices[c]];
  }));
}

bool has_extent(const PolygonMesh& mesh) {
  if (mesh.face_vertices.empty()) return false;
  const glm::dvec3& first = mesh.positions[mesh.face_vertices.front()];
  return std::ranges::any_of(mesh.face_vertices,
                             [&](std::int32_t v) { return mesh.positions[v] != first; });
}

Placement placement_of(std::span<const glm::dvec3> positions) {
  if (positions.empty()) return {};
  return placement_of(
      box_of(positions.size(), [&](std::size_t v) -> const glm::dvec3& { return positions[v]; }));
}

}  // namespace planish
