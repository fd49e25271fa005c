#pragma once

#include <array>
#include <cstdint>

#include "planish/reconstruct/simplify_state.h"

namespace planish {

/// Flips the edges at vertices that are due where the triangles then follow the samples' normals
/// better or have less sharp angles, until nothing more is gained.
class FlipPass {
 public:
  /// Keeps the state.
  explicit FlipPass(SimplifyState& state) : state_(state) {}

  void run();

 private:
  // An edge a b with the opposite corners c and d of its two triangles.
  using Diamond = std::array<std::int32_t, 4>;

  bool try_flip(std::int32_t half_edge);
  [[nodiscard]] bool keeps_valences(const Diamond& diamond) const;
  [[nodiscard]] bool gains(const Diamond& diamond) const;

  SimplifyState& state_;
  Fan fan_;
  TriangleChange change_;
};

}  // namespace planish
