#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "planish/backend/backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/limit_system.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Surfaces through any numbers given to the vertices of a fitted mesh, by the linear map of the
/// progressive method: B is made once for all of them. Of any scheme, at the rows of a level or of
/// triangles as fine as the surface bends.
class LinearSurface {
 public:
  /// `rows` is the fitted surface whose rows the others have: a level, or AdaptiveBlocks. The mesh,
  /// with its fit, must outlive it. Throws as fit().
  LinearSurface(const FittedMesh& fitted, const SurfaceBlocks& rows, Backend& backend);

  /// A surface at those rows: its blocks know positions and normals.
  class Rows {
   public:
    [[nodiscard]] const SurfaceBlocks& blocks() const { return *blocks_; }

   private:
    friend class LinearSurface;
    // What the blocks read, as far as they read it.
    std::unique_ptr<const PolygonMesh> cage_;
    std::unique_ptr<const LevelOne> level_one_;
    std::shared_ptr<const DooSabinSurface> surface_;
    std::unique_ptr<const SurfaceMesh> whole_;
    std::unique_ptr<const SurfaceBlocks> blocks_;
  };

  /// Through `given`, one per vertex of the mesh. Throws Error{InvalidArgument} where B has no
  /// inverse, as Catmull-Clark's and Loop's can lack one; Error{Cancelled}.
  [[nodiscard]] Rows through(std::span<const glm::dvec3> given,
                             const Callbacks& callbacks = {}) const;
  /// The fitted surface, whatever its method, moved by that.
  [[nodiscard]] Rows moved(std::span<const glm::dvec3> moves,
                           const Callbacks& callbacks = {}) const;

 private:
  [[nodiscard]] bool is_doo_sabin() const { return fitted_.options.scheme == Scheme::DooSabin; }
  [[nodiscard]] EvaluateOptions options() const;
  [[nodiscard]] std::unique_ptr<PolygonMesh> cage_through(std::span<const glm::dvec3> given,
                                                          const Callbacks& callbacks) const;
  // Of what stands in `made`: of Doo-Sabin a surface, else a cage.
  [[nodiscard]] Rows at_rows(Rows made) const;

  const FittedMesh& fitted_;
  const SurfaceBlocks& rows_;
  Backend& backend_;
  std::unique_ptr<const DooSabinSurface> fitted_surface_;  // of Doo-Sabin
  LimitSystem system_;
};

}  // namespace planish
