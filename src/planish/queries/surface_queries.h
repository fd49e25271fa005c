#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/patches/patch_form.h"
#include "planish/queries/limit_surface.h"

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

/// The point of a surface that is nearest to a given one.
struct ClosestPoint {
  SurfaceParameter at;
  glm::dvec3 position{};
  glm::dvec3 normal{};  ///< unit; of the side that `at` is on where the surface has an edge
  double distance = 0;
};

/// A half line from `origin` along `direction`, of any length above 0.
struct SurfaceRay {
  glm::dvec3 origin{}, direction{};
  /// Only hits at origin + t direction with t in this range count.
  double t_min = 0, t_max = 1e300;
};

struct SurfaceHit {
  SurfaceParameter at;
  glm::dvec3 position{};
  glm::dvec3 normal{};  ///< unit
  double t = 0;
  /// The ray touches the surface here, as nearly as can be told, and may have crossed it twice or
  /// not at all.
  bool is_tangent = false;
};

/// Questions to a limit surface from outside, in model coordinates and answered to rounding. All of
/// it may be asked from several threads at once. The surface must outlive it. Throws
/// Error{UnusableMesh} where all faces are holes.
class SurfaceQueries {
 public:
  explicit SurfaceQueries(const LimitSurface& surface);

  [[nodiscard]] const LimitSurface& surface() const { return tree_.surface(); }

  /// After a surface that keeps its own control points (DooSabinSurface::own_state()) has other
  /// patches at some corners, while nobody asks: CornerTree::refit(), whose count it returns.
  std::int64_t refit(std::span<const std::int32_t> corners) { return tree_.refit(corners); }
  /// The same after any of them may have changed, as if it were made anew.
  void rebuild() { tree_.rebuild(); }

  /// Throws Error{InvalidArgument} for a point that is not finite.
  [[nodiscard]] ClosestPoint closest(const glm::dvec3& point) const;
  /// On all threads; the same bits for every thread count. Throws as above with the point's index,
  /// and for spans of different lengths.
  void closest(std::span<const glm::dvec3> points, std::span<ClosestPoint> result) const;
  /// What closest() says of distances, but for rounding (1e-14 of the diagonal), in half the time.
  void distances(std::span<const glm::dvec3> points, std::span<double> result) const;
  /// The distance, negative inside. For closed surfaces; elsewhere the sign says little.
  [[nodiscard]] double signed_distance(const glm::dvec3& point) const;

  /// Throws Error{InvalidArgument} for a ray that is not finite or has no direction.
  [[nodiscard]] std::optional<SurfaceHit> first_hit(const SurfaceRay& ray) const;
  /// All, by ascending t. Where a ray meets the border of several patches there is one hit.
  [[nodiscard]] std::vector<SurfaceHit> all_hits(const SurfaceRay& ray) const;
  [[nodiscard]] bool is_occluded(const SurfaceRay& ray) const;

 private:
  [[nodiscard]] bool is_inside(const glm::dvec3& point) const;

  CornerTree tree_;
};

}  // namespace planish
