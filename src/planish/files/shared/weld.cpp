#include "planish/files/shared/weld.h"

#include <array>
#include <bit>
#include <limits>
#include <string>

#include "planish/core/error.h"

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

Welder::Welder() : slots_(64, -1) {}

std::int32_t Welder::insert(const glm::dvec3& position) {
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
  if (positions_.size() == std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorCode::UnreadableInput, "more distinct positions than 32 bits can count");
  slots_[slot] = static_cast<std::int32_t>(positions_.size());
  positions_.push_back(position);
  return slots_[slot];
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

bool TriangleCollector::add(std::int32_t v0, std::int32_t v1, std::int32_t v2) {
  if (v0 == v1 || v1 == v2 || v2 == v0) {
    ++degenerate_count_;
    return false;
  }
  mesh_.add_face(std::array{v0, v1, v2});
  return true;
}

void TriangleCollector::finish(Welder& welder, MeshFile& file) {
  file.mesh = std::move(mesh_);
  file.mesh.positions = welder.take_positions();
  file.welded_vertex_count += welder.merged_count();
  file.dropped_element_count += degenerate_count_;
  if (degenerate_count_ == 0) return;
  file.warnings.push_back(
      {.code = "degenerate-triangles",
       .message = std::to_string(degenerate_count_) + " triangles without area were left out",
       .count = degenerate_count_});
}

}  // namespace planish
