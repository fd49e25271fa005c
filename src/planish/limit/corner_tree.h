#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/patch_box.h"

namespace planish {

/// A box along a tree's axes in unit coordinates, rounded outwards to float.
struct CornerBox {
  glm::vec3 low, high;
};

/// Boxes around the pieces of a limit surface, one a corner, in a binary tree: what closest points
/// and rays share. They lie along the axes of coordinates, or, where that makes much smaller boxes
/// of a surface that is long and thin or flat, along its own. Made on all threads, the same for
/// every thread count. Corners of hole faces are left out.
class CornerTree {
 public:
  /// The surface must outlive it.
  explicit CornerTree(const LimitSurface& surface);

  /// After the patches of some corners have changed, each named once: their boxes are made anew,
  /// and the nodes above them. The tree keeps its shape, so that its questions take longer once
  /// corners have moved far; see rebuild(). Returns how many nodes it has looked at: for each
  /// corner at most the tree's height. Hole faces' corners are passed by.
  std::int64_t refit(std::span<const std::int32_t> corners);
  /// After any have: what the constructor makes.
  void rebuild();

  struct Node {
    CornerBox box;
    std::int32_t first = 0;  ///< of a leaf: its first entry in corners()
    std::int32_t count = 0;  ///< of a leaf; 0: inside, the children are the next node and `right`
    std::int32_t right = 0;
  };

  [[nodiscard]] const LimitSurface& surface() const { return surface_; }
  /// A vector of unit coordinates by the axes of the boxes.
  [[nodiscard]] glm::dvec3 turned(const glm::dvec3& vector) const {
    return is_turned_ ? vector * axes_ : vector;
  }
  [[nodiscard]] const PatchReaches& reaches() const { return reaches_; }
  /// Empty where the surface has no visible face; else the root comes first.
  [[nodiscard]] const RawVector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] const RawVector<std::int32_t>& corners() const { return corners_; }
  /// Boxes of corners(), in its order.
  [[nodiscard]] const RawVector<CornerBox>& boxes() const { return boxes_; }

 private:
  void build(std::int32_t node, std::int32_t first, std::int32_t last);
  void choose_axes(RawVector<CornerBox>& boxes);
  void number_places();
  void make_boxes(std::span<const std::int32_t> corners, std::span<CornerBox> boxes) const;
  std::int64_t refit_node(std::int32_t node, std::int32_t first, std::int32_t last,
                          std::span<const std::int32_t> places);

  const LimitSurface& surface_;
  PatchReaches reaches_;
  bool is_turned_ = false;
  glm::dmat3 axes_{1.0};  // its columns: those of the boxes
  RawVector<Node> nodes_;
  RawVector<std::int32_t> corners_;
  RawVector<CornerBox> boxes_;
  // Of refit(): where each corner stands in corners_, -1: nowhere. Made by the first.
  std::vector<std::int32_t> place_of_corner_;
  std::vector<std::int32_t> places_, of_places_;
  RawVector<CornerBox> new_boxes_;
};

}  // namespace planish
