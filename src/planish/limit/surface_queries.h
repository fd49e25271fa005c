#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/limit/corner_tree.h"
#include "planish/limit/limit_surface.h"

namespace planish {

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
