#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "overlay.h"
#include "planish/job/page/camera.h"
#include "planish/mesh/polygon_mesh.h"
#include "render_mesh.h"

namespace planish::render {

enum class Look {
  Clay,     ///< a matt light material
  Stripes,  ///< reflection lines: they are smooth where the surface's normals are
  Heat,     ///< colours by curvature
  Values,   ///< colours by the mesh's values, see signed_colour()
};

struct PictureOptions {
  int width = 1200, height = 900;
  ViewOptions view;
  Look look = Look::Clay;
  glm::vec3 colour{0.81f, 0.82f, 0.84f};  ///< sRGB
  float scale = 1;                     ///< of Look::Values: what the ends of the colours stand for
  bool wire = false;                   ///< the edges of the surface's quads
  std::optional<PolygonMesh> overlay;  ///< drawn as edges and vertices
  OverlayOptions overlay_options;
};

/// 8-bit sRGB, three bytes a pixel, top row first.
[[nodiscard]] std::vector<std::uint8_t> draw_picture(const RenderMesh& mesh,
                                                     const PictureOptions& options);

}  // namespace planish::render
