#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>

#include "planish/backend/backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/limit_system.h"
#include "planish/surface/doo_sabin_surface.h"

namespace planish {

/// Surfaces through any numbers given to the vertices of a fitted mesh, by the linear map of the
/// progressive method: B is made once for all of them. Rows are those of the fitted surface. Of
/// Doo-Sabin.
class LinearSurface {
 public:
  /// The mesh, with its fit, must outlive it. Throws as fit().
  LinearSurface(const FittedMesh& fitted, Backend& backend);

  /// A surface with its cage, which it needs.
  struct Through {
    std::unique_ptr<const PolygonMesh> cage;
    std::unique_ptr<const LevelOne> level_one;
    std::unique_ptr<const DooSabinSurface> surface;
  };

  /// Through `given`, one per vertex of the mesh. Throws Error{Cancelled}.
  [[nodiscard]] Through through(std::span<const glm::dvec3> given,
                                const Callbacks& callbacks = {}) const;
  /// The fitted surface, whatever its method, moved by that. `base` is the fitted one.
  [[nodiscard]] Through moved(const DooSabinSurface& base, std::span<const glm::dvec3> moves,
                              const Callbacks& callbacks = {}) const;

 private:
  [[nodiscard]] EvaluateOptions options() const;

  const FittedMesh& fitted_;
  Backend& backend_;
  LimitSystem system_;
};

}  // namespace planish
