#pragma once

#include "planish/c/planish.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_mesh.h"

// What the handles of planish.h hold. Names are C's, so they stand in no namespace.

struct planish_mesh {
  planish::PolygonMesh mesh;
  std::vector<std::int32_t> face_sizes;  ///< for views
};

struct planish_fit {
  planish::FittedMesh fitted;
  int thread_count = 0;
};

struct planish_surface {
  planish::SurfaceMesh surface;
};

namespace planish::c {

/// A handle around a mesh.
[[nodiscard]] planish_mesh* new_mesh(PolygonMesh&& mesh);

/// Checked, with its callbacks. Throws Error{InvalidArgument}.
[[nodiscard]] MeshFitOptions mesh_options(const planish_fit_options& options);

}  // namespace planish::c
