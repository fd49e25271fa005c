#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Where a surface is folded: a face of the input, and a point of the surface over it.
struct FoldedPlace {
  std::int32_t face = -1;
  glm::dvec3 position{0.0};
};

/// As many as SurfaceQuality names.
inline constexpr std::size_t kNamedFolds = 3;

/// A report's `bending` is of this level, whatever its other figures are of: it grows with the
/// level where a surface bends tightly. The choice of the method measures this one anyway.
inline constexpr int kBendingLevel = 1;

/// How well the normals of a surface follow a reference. Angles in degrees, weighted by area, each
/// face's area shared among its corners.
struct SurfaceQuality {
  double folded_area = 0;  ///< share of the area turned by more than 90 degrees from the reference
  /// The part of it that the input is not to blame for: without what descends from faces at folded
  /// edges (see mesh/mesh_parts.h). Also a share of the whole area.
  double folded_area_elsewhere = 0;
  /// The first places, one a face of the input: of folded_area_elsewhere where there are such, else
  /// of folded_area. None where the reference is not the input.
  std::vector<FoldedPlace> folded_places;
  double rms_normal_deviation = 0;
  double max_normal_deviation = 0;
  /// The integral of |dn|^2, the sum of both squared principal curvatures, whatever the size: 8 pi
  /// for a sphere. One tight fold dominates it.
  double bending = 0;
};

/// The normal that the surface should have at a corner of one of its faces; any length, zero where
/// there is none.
using ReferenceNormal = std::function<glm::dvec3(std::int64_t face, std::int32_t corner)>;

/// Called from one thread, face by face in order. `is_beside_folds`: one per face of the surface,
/// not 0 where it does not count in folded_area_elsewhere; empty: all count.
[[nodiscard]] SurfaceQuality surface_quality(const SurfaceMesh& surface,
                                             const ReferenceNormal& reference,
                                             std::span<const std::uint8_t> is_beside_folds = {});

/// One per face of the surface: 1 where the face of the fitted mesh that it descends from has an
/// edge that is folded.
[[nodiscard]] std::vector<std::uint8_t> beside_folds(const SurfaceMesh& surface,
                                                     const PolygonMesh& input);

/// Against the faces of the mesh that was fitted, each for its own descendants; any level. At the
/// apex of a cone, where there is no normal, the one beside it in each face counts.
[[nodiscard]] SurfaceQuality surface_quality(const SurfaceMesh& surface, const PolygonMesh& input);

/// The figures of a surface whose faces come one by one; the order decides the last bits.
class QualitySum {
 public:
  /// A face by its corners: positions, unit normals, and the normals that these should be, of any
  /// length, zero where there is none. `is_elsewhere`: it counts in folded_area_elsewhere.
  void add(std::span<const glm::dvec3> positions, std::span<const glm::vec3> normals,
           std::span<const glm::dvec3> wanted, bool is_elsewhere = true);
  /// Of the faces so far; names no places.
  [[nodiscard]] SurfaceQuality result() const;

 private:
  double whole_ = 0, squares_ = 0;
  SurfaceQuality sums_;
};

}  // namespace planish
