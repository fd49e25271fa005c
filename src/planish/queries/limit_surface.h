#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_form.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

/// A point of the limit surface in model coordinates, with derivatives by the parameters that were
/// asked for.
struct SurfacePoint {
  glm::dvec3 position{}, du{}, dv{}, duu{}, duv{}, dvv{};
  /// Unit. Where tangents are parallel (vertices of valence 2) the mean of those around.
  glm::dvec3 normal{};
  /// False at vertices and face centres of other valence or size than 4 (where second derivatives
  /// have no limit, and du and dv depend on the direction: they are those along the edges of the
  /// corner that was asked for).
  bool has_second = true;

  /// In one over the model's unit.
  [[nodiscard]] PointCurvature curvature() const;
};

/// How a point follows from the surface's control points, for those who move them.
struct SurfaceStencil {
  /// Control points of level 1, the first of DooSabinSurface::state(); around large rings one may
  /// stand there several times, its weights to be added.
  std::vector<std::int32_t> points;
  /// One weight a point. Those of `position` sum to 1, of `du` and `dv` to 0.
  std::vector<double> position, du, dv;
};

/// A Doo-Sabin limit surface as a function, exact to rounding: any place, derivatives, curvature.
/// It does not change, and all of it may be asked from several threads at once. See ClosestPoints
/// and SurfaceRays for questions the other way round.
class LimitSurface {
 public:
  /// The mesh of the surface must outlive it. See fitted_surface() for that of a fit.
  explicit LimitSurface(std::shared_ptr<const DooSabinSurface> surface);

  [[nodiscard]] const DooSabinSurface& surface() const { return *surface_; }
  [[nodiscard]] const MeshTopology& topology() const { return surface_->topology(); }
  /// The forms of all its corners.
  [[nodiscard]] std::span<const PatchForm* const> forms() const { return form_list_; }
  [[nodiscard]] const PatchForm& form(std::int32_t corner) const {
    return *form_list_[form_of_corner_[corner]];
  }

  /// Throws Error{InvalidArgument} for places outside, see corner_parameter(). At borders of faces
  /// and corners second derivatives are those of the side that is asked for.
  [[nodiscard]] SurfacePoint evaluate(const SurfaceParameter& at) const;
  /// Many at once, on all threads; the same bits for every thread count. Cheapest where neighbours
  /// in the list lie in one corner. Throws as above, and Error{InvalidArgument} for spans of
  /// different lengths.
  void evaluate(std::span<const SurfaceParameter> places, std::span<SurfacePoint> points) const;

  /// Throws as evaluate().
  [[nodiscard]] SurfaceStencil stencil(const SurfaceParameter& at) const;

  /// Control points of a corner's patch, which can be asked as often as wanted.
  class Corner {
   public:
    explicit Corner(const LimitSurface& whole) : whole_(whole) {}
    void move_to(std::int32_t corner);
    [[nodiscard]] const PatchForm& form() const { return *form_; }
    [[nodiscard]] std::span<const glm::dvec3> points() const { return points_; }
    [[nodiscard]] glm::dvec3 own() const { return own_; }
    /// In unit coordinates (see Placement).
    [[nodiscard]] PatchPoint at(PatchParameter parameter) {
      PatchPoint point = patch_point(*form_, points_, parameter, scratch_);
      point.position += own_;
      return point;
    }

   private:
    const LimitSurface& whole_;
    std::int32_t corner_ = -1;
    const PatchForm* form_ = nullptr;
    glm::dvec3 own_{};
    std::vector<glm::dvec3> points_;
    std::vector<std::int32_t> indices_;
    PatchScratch scratch_;
  };

 private:
  [[nodiscard]] glm::dvec3 normal_beside(const CornerParameter& at) const;
  [[nodiscard]] SurfacePoint point_of(Corner& corner, const CornerParameter& at) const;

  std::shared_ptr<const DooSabinSurface> surface_;
  PatchForms forms_;
  std::vector<const PatchForm*> form_list_;
  std::vector<std::uint16_t> form_of_corner_;  ///< index into form_list_
};

}  // namespace planish
