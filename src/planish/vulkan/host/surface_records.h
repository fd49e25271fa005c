#pragma once

#include <memory>
#include <optional>

#include "planish/doosabin/sharp_features.h"
#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/stencil/stencil_table.h"
#include "planish/vulkan/embed.h"

namespace planish::vulkan {

/// What a System knows of its surface, for the tables of devices. Stays where it was made.
struct SurfaceRecords {
  SurfaceRecords(const PolygonMesh& mesh, const SystemOptions& options);
  SurfaceRecords(const SurfaceRecords&) = delete;
  SurfaceRecords& operator=(const SurfaceRecords&) = delete;

  /// Of the progressive method: how the first step makes the points beside sharp edges and at
  /// corner vertices.
  void take_sharp_rows(const Subdivision& subdivision);

  std::shared_ptr<const MeshTopology> topology;
  SharpFeatures features;
  PatchMesh patch_mesh;
  Weights weights;
  PatchSurface patches;
  std::optional<StencilTable> sharp_rows;
};

}  // namespace planish::vulkan
