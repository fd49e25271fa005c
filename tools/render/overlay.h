#pragma once

#include "planish/job/page/camera.h"
#include "planish/job/page/rasterise.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::render {

/// What stands in VisibilityBuffer::what for overlays.
inline constexpr std::uint32_t kEdgeSample = VisibilityBuffer::kNothing - 1;
inline constexpr std::uint32_t kVertexSample = VisibilityBuffer::kNothing - 2;

struct OverlayOptions {
  float edge_width = 5, vertex_width = 20;  ///< in samples; 0 for none
  float lift =
      2e-3f;  ///< towards the eye, as a fraction of the distance: lines on the surface show
};

/// Draws the edges and vertices of `mesh` where the surface does not hide them.
void draw_overlay(const PolygonMesh& mesh, const Camera& camera, const OverlayOptions& options,
                  VisibilityBuffer& buffer);

}  // namespace planish::render
