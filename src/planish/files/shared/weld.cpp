#include "planish/files/shared/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/portable_math.h"
#include "planish/core/raw_vector.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

std::uint64_t hash_of(const glm::dvec3& position) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // Adding zero turns -0.0 into 0.0. The constants are those of the splitmix64 generator.
    hash ^= std::bit_cast<std::uint64_t>(position[axis] + 0.0);
    hash *= 0xbf58476d1ce4e5b9u;
    hash ^= hash >> 31;
    hash *= 0x94d049bb133111ebu;
    hash ^= hash >> 29;
  }
  return hash;
}

}  // namespace

glm::dvec3 without_remainders(const glm::dvec3& position) {
  const glm::dvec3 size = glm::abs(position);
  const double least = kRemainder * std::max({size.x, size.y, size.z});
  return {size.x < least ? 0.0 : position.x, size.y < least ? 0.0 : position.y,
          size.z < least ? 0.0 : position.z};
}

Welder::Welder() : slots_(64, -1) {}

std::int32_t Welder::insert(const glm::dvec3& given) {
  const glm::dvec3 position = without_remainders(given);
  if (2 * positions_.size() >= slots_.size()) grow();
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash_of(position) & mask;
  while (slots_[slot] >= 0) {
    if (positions_[slots_[slot]] == position) {
      ++merged_count_;
      return slots_[slot];
    }
    slot = (slot + 1) & mask;
  }
  return slots_[slot] = insert_apart(position);
}

std::int32_t Welder::insert_apart(const glm::dvec3& position) {
  if (positions_.size() == std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorCode::UnreadableInput, "more distinct positions than 32 bits can count");
  positions_.push_back(without_remainders(position));
  return count() - 1;
}

void Welder::grow() {
  slots_.assign(2 * slots_.size(), -1);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    std::size_t slot = hash_of(positions_[i]) & mask;
    while (slots_[slot] >= 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<std::int32_t>(i);
  }
}

namespace {

// Equal positions have equal hashes and come into one group, where a thread finds them.
constexpr std::size_t kGroups = 256;
constexpr std::size_t kBlock = 1 << 15;  // positions whose groups are counted together

std::size_t group_of(const glm::dvec3& position) {
  return hash_of(without_remainders(position)) >> 56;
}

// The positions' numbers, one group after another, in their order within each.
struct Groups {
  RawVector<std::int32_t> members;
  std::vector<std::int32_t> starts;  // one more than groups
};

Groups group(std::span<const glm::dvec3> positions) {
  const std::size_t block_count = (positions.size() + kBlock - 1) / kBlock;
  std::vector<std::int32_t> places(kGroups * block_count + 1, 0);  // by group, then block
  const auto for_each = [&](const auto& visit) {
    parallel_each(block_count, 1, [&](std::size_t b) {
      for (std::size_t i = b * kBlock; i < std::min(positions.size(), (b + 1) * kBlock); ++i)
        visit(i, places[group_of(positions[i]) * block_count + b]);
    });
  };
  for_each([](std::size_t, std::int32_t& place) { ++place; });
  exclusive_sum(places);
  Groups groups;
  for (std::size_t g = 0; g <= kGroups; ++g) groups.starts.push_back(places[g * block_count]);
  groups.members.resize(positions.size());
  for_each([&](std::size_t i, std::int32_t& place) {
    groups.members[place++] = static_cast<std::int32_t>(i);
  });
  return groups;
}

// For each member of a group the first that has its position.
void find_firsts(std::span<const std::int32_t> members, std::span<const glm::dvec3> positions,
                 RawVector<std::int32_t>& firsts) {
  std::vector<std::int32_t> slots(std::bit_ceil(2 * members.size() + 1), -1);
  const std::size_t mask = slots.size() - 1;
  for (const std::int32_t member : members) {
    const glm::dvec3 position = without_remainders(positions[member]);
    std::size_t slot = hash_of(position) & mask;
    while (slots[slot] >= 0 && without_remainders(positions[slots[slot]]) != position)
      slot = (slot + 1) & mask;
    if (slots[slot] < 0) slots[slot] = member;
    firsts[member] = slots[slot];
  }
}

}  // namespace

WeldedPositions weld(std::span<const glm::dvec3> positions, const FileBytes& file) {
  const std::size_t count = positions.size();
  if (count == 0) return {};
  const Groups groups = group(positions);
  RawVector<std::int32_t> firsts(count), numbers(count);
  parallel_each(kGroups, 1, [&](std::size_t g) {
    find_firsts(std::span(groups.members)
                    .subspan(groups.starts[g], groups.starts[g + 1] - groups.starts[g]),
                positions, firsts);
    count_read(file.progress, file.bytes.size() / kGroups);
  });
  const auto is_first = [&](std::int32_t i) { return firsts[i] == i; };
  const SelectedBlocks blocks = count_selected(count, is_first);
  WeldedPositions welded;
  welded.positions.resize(blocks.total);
  for_selected(count, blocks, is_first, [&](std::size_t i, std::int32_t number) {
    welded.positions[number] = without_remainders(positions[i]);
    numbers[i] = number;
  });
  welded.indices.resize(count);
  parallel_each(count, kBlock, [&](std::size_t i) { welded.indices[i] = numbers[firsts[i]]; });
  return welded;
}

bool TriangleCollector::has_area(std::int32_t v0, std::int32_t v1, std::int32_t v2) {
  const bool is_flat = v0 == v1 || v1 == v2 || v2 == v0;
  if (is_flat) ++degenerate_count_;
  return !is_flat;
}

bool TriangleCollector::add(std::int32_t v0, std::int32_t v1, std::int32_t v2) {
  if (!has_area(v0, v1, v2)) return false;
  mesh_.add_face(std::array{v0, v1, v2});
  return true;
}

void TriangleCollector::finish(std::vector<glm::dvec3> positions, std::int64_t merged_count,
                               MeshFile& file) {
  file.mesh = std::move(mesh_);
  file.mesh.positions = std::move(positions);
  file.welded_vertex_count += merged_count;
  file.dropped_element_count += degenerate_count_;
  if (degenerate_count_ == 0) return;
  file.warnings.push_back({.code = "degenerate-triangles",
                           .message = counted(degenerate_count_, "triangle") + " without area " +
                                      (degenerate_count_ == 1 ? "was" : "were") + " left out",
                           .count = degenerate_count_});
}

namespace {

constexpr std::int32_t kNoNormal = -1;

// An edge as a face has it: its vertices in order, and the normals there.
struct Side {
  std::array<std::int32_t, 2> edge, normals;
};

std::array<std::int32_t, 2> edge_of(std::int32_t a, std::int32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

std::vector<Side> sides_of(const PolygonMesh& mesh, const CornerNormals& normals) {
  std::vector<Side> sides;
  sides.reserve(mesh.face_vertices.size());
  for (std::int32_t face = 0; face < mesh.face_count(); ++face) {
    const std::int32_t begin = mesh.face_offsets[face], size = mesh.face_size(face);
    for (std::int32_t k = 0; k < size; ++k) {
      std::int32_t from = begin + k, to = begin + (k + 1) % size;
      if (mesh.face_vertices[from] > mesh.face_vertices[to]) std::swap(from, to);
      if (mesh.face_vertices[from] == mesh.face_vertices[to]) continue;
      sides.push_back({{mesh.face_vertices[from], mesh.face_vertices[to]},
                       {normals.of_corners[from], normals.of_corners[to]}});
    }
  }
  std::ranges::sort(sides, std::less<>(),
                    [](const Side& side) { return std::tie(side.edge, side.normals); });
  return sides;
}

class NormalsDiffer {
 public:
  explicit NormalsDiffer(const CornerNormals& normals) : values_(normals.values) {}

  bool operator()(std::int32_t a, std::int32_t b) const {
    if (a == b || a == kNoNormal || b == kNoNormal) return false;
    const glm::dvec3 u = values_[a], v = values_[b];
    const double lengths = glm::length(u) * glm::length(v);
    if (!(lengths > 0) || !std::isfinite(lengths)) return false;
    return glm::dot(u, v) < least_cosine_ * lengths;
  }

 private:
  const std::vector<glm::vec3>& values_;
  double least_cosine_ = portable::cos(glm::radians(kSplitDegrees));
};

}  // namespace

void mark_split_normals(PolygonMesh& mesh, const CornerNormals& normals) {
  std::vector<std::array<std::int32_t, 2>> tagged;
  for (const CreaseEdge& crease : mesh.creases) tagged.push_back(edge_of(crease.v0, crease.v1));
  std::ranges::sort(tagged);
  const std::vector<Side> sides = sides_of(mesh, normals);
  const NormalsDiffer differ(normals);
  for (auto first = sides.begin(); first != sides.end();) {
    const auto next =
        std::find_if(first, sides.end(), [&](const Side& s) { return s.edge != first->edge; });
    const bool is_split = std::any_of(first, next, [&](const Side& side) {
      return differ(first->normals[0], side.normals[0]) ||
             differ(first->normals[1], side.normals[1]);
    });
    if (is_split && !std::ranges::binary_search(tagged, first->edge))
      mesh.creases.push_back({first->edge[0], first->edge[1]});
    first = next;
  }
}

void weld_repeated_vertices(MeshFile& file) {
  PolygonMesh& mesh = file.mesh;
  const std::size_t count = mesh.positions.size();
  WeldedPositions welded = weld(mesh.positions);
  if (welded.positions.size() == count) return;
  file.welded_vertex_count += static_cast<std::int64_t>(count - welded.positions.size());
  const auto rename = [&](std::int32_t& vertex) { vertex = welded.indices[vertex]; };
  for (std::int32_t& vertex : mesh.face_vertices) rename(vertex);
  for (CreaseEdge& crease : mesh.creases) {
    rename(crease.v0);
    rename(crease.v1);
  }
  std::erase_if(mesh.creases, [](const CreaseEdge& crease) { return crease.v0 == crease.v1; });
  for (CornerVertex& corner : mesh.corners) rename(corner.vertex);
  // The first vertex's stays.
  const auto gather = [&](auto& values) {
    if (values.empty()) return;
    std::remove_reference_t<decltype(values)> kept(welded.positions.size());
    for (std::size_t i = count; i-- > 0;) kept[welded.indices[i]] = values[i];
    values = std::move(kept);
  };
  gather(mesh.colors);
  for (VertexAttribute& attribute : mesh.attributes) gather(attribute.values);
  mesh.positions = std::move(welded.positions);
}

}  // namespace planish
