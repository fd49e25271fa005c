#pragma once

#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/chart_field.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_surface.h"
#include "planish/solve/stencil_table.h"
#include "planish/vulkan/embed.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/host/file_rows.h"
#include "planish/vulkan/levels/gpu_levels.h"

namespace planish::vulkan {

/// What a System knows of its surface, for the tables of devices. Stays where it was made.
struct SurfaceRecords {
  SurfaceRecords(const PolygonMesh& mesh, const SystemOptions& options);
  SurfaceRecords(const SurfaceRecords&) = delete;
  SurfaceRecords& operator=(const SurfaceRecords&) = delete;

  /// Of the progressive method: how the first step makes the points beside sharp edges and at
  /// corner vertices.
  void take_sharp_rows(const Subdivision& subdivision);

  /// Where it is textured, by the control points of level 1 of the rest pose, with their sums: the
  /// field, and the frames of the System's own level.
  void take_uv_field(std::span<const glm::dvec3> rest);

  [[nodiscard]] PatchSurfaceOptions patch_options(int level) const {
    return {.level = level, .weights = weights, .corner_uvs = corner_uvs()};
  }
  [[nodiscard]] std::span<const std::int32_t> corner_uvs() const {
    return uvs ? std::span<const std::int32_t>(uvs->indices) : std::span<const std::int32_t>();
  }
  /// At the System's own level or one of `levels`. Throws Error{InvalidArgument} for another one.
  [[nodiscard]] const PatchSurface& at_level(int level) const;

  std::shared_ptr<const MeshTopology> topology;
  SharpFeatures features;
  PatchMesh patch_mesh;
  Weights weights;
  std::optional<CornerUvs> uvs;  // where it is textured
  std::vector<glm::dvec2> uv_values;
  std::optional<ChartField<glm::dvec2>> uv_field;
  FileFaces file_faces;
  PatchSurface patches;
  std::vector<RowFrame> frames;  // of textured rows
  std::optional<StencilTable> sharp_rows;
  LevelSet levels;  // none: not asked for
};

}  // namespace planish::vulkan
