#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "planish/reconstruct/simplify_state.h"

namespace planish {

/// Puts other samples in the place of inner vertices that are due, where these lie nearer to the
/// middle of their neighbours: the interpolating surface wiggles and folds where they do not. Frees
/// vertices, too: the next collapses find more room.
class MovePass {
 public:
  /// Keeps the state.
  explicit MovePass(SimplifyState& state) : state_(state) {}

  /// Looks once at every vertex that is due.
  void run();

 private:
  bool try_move(std::int32_t vertex);
  bool try_place(std::int32_t vertex, std::int32_t sample);
  void list_samples(std::int32_t vertex);

  SimplifyState& state_;
  // Used again from vertex to vertex.
  Fan fan_;
  TriangleChange change_;
  std::vector<std::int32_t> inside_;                      // points of the fan
  std::vector<std::pair<double, std::int32_t>> samples_;  // with their distance to the middle
};

}  // namespace planish
