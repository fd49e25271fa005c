#include "planish/files/shared/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <glm/common.hpp>
#include <limits>
#include <string>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/core/prefix_sum.h"
#include "planish/files/shared/read_progress.h"

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

}  // namespace planish
