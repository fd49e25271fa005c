#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/queries/limit_surface.h"
#include "planish/surface/mesh_blocks.h"

namespace planish {

/// The attribute of that index of the surface's mesh at places: its `width` numbers of each, one
/// place after another. Linear between vertices as on levels, whose rows have the same values.
/// Throws as LimitSurface::evaluate().
[[nodiscard]] std::vector<float> attribute_at(const LimitSurface& surface, std::size_t index,
                                              std::span<const SurfaceParameter> places);

/// Leaves out rows and texture coordinates that no triangle names, but for the first so many.
void drop_unnamed(AdaptiveSurface& surface, std::int64_t first_rows, std::int64_t first_uvs);

/// An adaptive tessellation for writers, which know the surface that it lies on: what is given to
/// the vertices of the mesh, and other surfaces of that mesh, can be had at its rows.
class AdaptiveBlocks final : public MeshBlocks {
 public:
  /// Both must outlive it.
  AdaptiveBlocks(const AdaptiveSurface& surface, const LimitSurface& lies_on)
      : MeshBlocks(surface.mesh, surface.ancestors), adaptive_(surface), lies_on_(lies_on) {}

  bool uvs_of(std::span<const glm::dvec2> given, std::span<glm::dvec2> values) const override;
  bool corners_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const override;
  bool rows_of(std::span<const glm::vec4> given, std::span<glm::vec4> values) const override;
  /// Positions and normals that another surface of the mesh has at the places of these rows,
  /// without faces. Throws Error{Cancelled}.
  [[nodiscard]] SurfaceMesh rows_on(const LimitSurface& other) const;

 private:
  const AdaptiveSurface& adaptive_;
  const LimitSurface& lies_on_;
};

}  // namespace planish
