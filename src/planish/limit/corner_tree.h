#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "planish/core/raw_vector.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/patch_box.h"

namespace planish {

/// An axis-aligned box in unit coordinates, rounded outwards to float.
struct CornerBox {
  glm::vec3 low, high;
};

/// Boxes around the pieces of a limit surface, one a corner, in a binary tree: what closest points
/// and rays share. Made on all threads, the same for every thread count. Corners of hole faces are
/// left out.
class CornerTree {
 public:
  /// The surface must outlive it.
  explicit CornerTree(const LimitSurface& surface);

  struct Node {
    CornerBox box;
    std::int32_t first = 0;  ///< of a leaf: its first entry in corners()
    std::int32_t count = 0;  ///< of a leaf; 0: inside, the children are the next node and `right`
    std::int32_t right = 0;
  };

  [[nodiscard]] const LimitSurface& surface() const { return surface_; }
  [[nodiscard]] const PatchReaches& reaches() const { return reaches_; }
  /// Empty where the surface has no visible face; else the root comes first.
  [[nodiscard]] const RawVector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] const RawVector<std::int32_t>& corners() const { return corners_; }
  /// Boxes of corners(), in its order.
  [[nodiscard]] const RawVector<CornerBox>& boxes() const { return boxes_; }

 private:
  void build(std::int32_t node, std::int32_t first, std::int32_t last);

  const LimitSurface& surface_;
  PatchReaches reaches_;
  RawVector<Node> nodes_;
  RawVector<std::int32_t> corners_;
  RawVector<CornerBox> boxes_;
};

}  // namespace planish
