#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/limit/bezier_net.h"
#include "planish/limit/corner_tree.h"
#include "planish/limit/patch_frame.h"

namespace planish {

/// Where a ray meets a surface, in unit coordinates.
struct RayPlace {
  std::int32_t corner = -1;
  double u = 0, v = 0;
  double t = 0;
  glm::dvec3 normal{};  ///< not of unit length
  bool is_tangent = false;
  bool is_singular = false;  ///< at a vertex or face centre without a polynomial
};

enum class RayAnswer {
  All,    ///< by ascending t; what several patches share once
  First,  ///< the smallest t
  Any,    ///< one, whichever is found first
};

/// Searches a tree for the places where a ray meets the surface. Patches are split until the ray
/// can meet a piece once at most (seen along the ray, no two of its directions are parallel) or
/// not at all; then Newton's method. Used again from ray to ray; one a thread.
class RaySearch {
 public:
  explicit RaySearch(const CornerTree& tree) : tree_(tree), corner_(tree.surface()) {}

  /// In unit coordinates, the direction of unit length.
  [[nodiscard]] const std::vector<RayPlace>& run(const glm::dvec3& origin,
                                                 const glm::dvec3& direction, double t_min,
                                                 double t_max, RayAnswer wanted);

 private:
  [[nodiscard]] bool meets(const CornerBox& box) const;
  [[nodiscard]] bool can_meet(std::span<const glm::dvec3> points, double reach) const;
  void search_corner(std::int32_t corner);
  void search_form(const PatchForm& form, std::span<const glm::dvec3> points,
                   const PatchFrame& frame);
  // Nets are as the ray sees them: two directions across it, and t.
  void search_net(const BezierNet& net, const PatchFrame& frame);
  bool solve(const BezierNet& net, const PatchFrame& frame);
  void add(const PatchFrame& frame, const glm::dvec2& local, bool is_tangent, bool is_singular);
  [[nodiscard]] bool is_done() const { return wanted_ == RayAnswer::Any && !places_.empty(); }

  const CornerTree& tree_;
  LimitSurface::Corner corner_;
  glm::dvec3 origin_{}, direction_{}, right_{}, up_{};
  glm::dvec3 turned_origin_{}, turned_direction_{};  // by the tree's axes
  double t_min_ = 0, t_max_ = 0;
  RayAnswer wanted_ = RayAnswer::All;
  std::int32_t corner_number_ = -1;
  int pieces_ = 0;  // of the corner, so far
  std::vector<RayPlace> places_;
};

}  // namespace planish
