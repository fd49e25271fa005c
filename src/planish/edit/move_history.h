#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

namespace planish {

/// Vertices, none twice, and where they were before a move.
struct PastMove {
  std::vector<std::int32_t> vertices;
  std::vector<glm::dvec3> positions;
};

/// Moves that can be taken back, the last one at the end: so many, and no more positions than a few
/// meshes have; older ones are forgotten.
class MoveHistory {
 public:
  MoveHistory(int most_moves, std::size_t vertex_count)
      : most_moves_(static_cast<std::size_t>(std::max(most_moves, 0))),
        most_positions_(kMostMeshes * vertex_count) {}

  [[nodiscard]] bool empty() const { return moves_.empty(); }
  [[nodiscard]] const PastMove& last() const { return moves_.back(); }
  void drop_last() {
    positions_ -= moves_.back().vertices.size();
    moves_.pop_back();
  }
  void clear() {
    moves_.clear();
    positions_ = 0;
  }
  void add(PastMove&& move) {
    positions_ += move.vertices.size();
    moves_.push_back(std::move(move));
    while (moves_.size() > most_moves_ || (moves_.size() > 1 && positions_ > most_positions_)) {
      positions_ -= moves_.front().vertices.size();
      moves_.pop_front();
    }
  }

 private:
  static constexpr std::size_t kMostMeshes = 4;

  std::size_t most_moves_, most_positions_, positions_ = 0;
  std::deque<PastMove> moves_;
};

}  // namespace planish
