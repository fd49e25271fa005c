#pragma once

#include <cstdint>

#include "planish/primal/star_masks.h"
#include "planish/primal/vertex_star.h"

namespace planish {

/// The weights of a star's points in its limit point, and in two tangents of a sector whose cross
/// product is the outward normal's direction.
struct StarLimit {
  StarWeights position, du, dv;
};

/// Computes limits; keeps scratch memory and the masks of the last star.
class StarLimits {
 public:
  explicit StarLimits(PrimalScheme scheme) : scheme_(scheme) {}

  /// The exact limit of subdivision, semi-sharp edges and darts included, of a star whose faces are
  /// quads (Catmull-Clark) or triangles (Loop). Derivatives are exact wherever the surface has a
  /// tangent plane; at corners of two and more faces and at tagged vertices without sharp edges,
  /// where it has none, they span a mean of the planes around.
  [[nodiscard]] const StarLimit& limit(const VertexStar& star, std::int32_t sector);

 private:
  void pull_back(const VertexStar& star, StarWeights& weights);
  void stationary_position();
  void stationary_tangents(std::int32_t sector);
  void ring_tangents(std::int32_t first_edge);
  void fan_tangents(const Sector& faces, bool corner);
  void settle_position();
  void settle_tangent(const VertexStar& star, const StarWeights& position, StarWeights& tangent);
  void take_odd_part(std::int32_t edge, StarWeights& tangent);
  void make_fan(std::int32_t face_count);
  [[nodiscard]] bool has_one_sharp_edge() const;

  PrimalScheme scheme_;
  VertexStar star_;  // with the sharpness of the step at hand
  VertexStar part_;  // the same as Sdc is shown it: turned, or one sector
  LimitMasks masks_;
  SubdivisionMask mask_;
  StarWeights pulled_;
  StarLimit limit_, fan_;
};

}  // namespace planish
