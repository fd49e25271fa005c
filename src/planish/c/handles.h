#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "planish/backend/cpu_backend.h"
#include "planish/c/planish.h"
#include "planish/limit/limit_surface.h"
#include "planish/limit/surface_queries.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_mesh.h"

// What the handles of planish.h hold. Names are C's, so they stand in no namespace.

struct planish_mesh {
  planish::PolygonMesh mesh;
  std::vector<std::int32_t> face_sizes;    ///< for views
  std::vector<planish::Warning> warnings;  ///< of the reader
};

struct planish_fit {
  std::shared_ptr<planish::FittedMesh> whole;  ///< with the queries that are made of it
  planish::FittedMesh& fitted;
  int thread_count = 0;
  planish::Precision precision = planish::Precision::Float;

  planish_fit() : whole(std::make_shared<planish::FittedMesh>()), fitted(*whole) {}
};

struct planish_surface {
  planish::SurfaceMesh surface;
};

struct planish_queries {
  std::shared_ptr<const planish::FittedMesh> fitted;
  planish::LimitSurface limit;
  planish::SurfaceQueries queries;
  int thread_count = 0;

  explicit planish_queries(const planish_fit& fit);
};

namespace planish::c {

/// A handle around a mesh.
[[nodiscard]] planish_mesh* new_mesh(PolygonMesh&& mesh);

}  // namespace planish::c
