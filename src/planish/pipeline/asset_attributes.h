#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_tangents.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/measure/vertex_fields.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// Rows of a surface for which attributes are made at once.
inline constexpr std::int64_t kAttributeRows = std::int64_t{1} << 14;

/// Numbers that vertices of the given mesh have, `width` of 1 to 4 each, at all rows of the surface
/// of its fit, as colours have them. The surface has to know its mesh (see
/// SurfaceBlocks::rows_of()).
[[nodiscard]] std::vector<float> rows_of_vertices(std::span<const float> given, int width,
                                                  const FittedMesh& fitted,
                                                  const SurfaceBlocks& surface);

/// The attributes of a surface as further fields of its files, those of more than four numbers as
/// one field a number, `name_0` and so on; what is returned holds their values and must outlive
/// them. A field of the same name, whatever its case, stays in the place of theirs; that is the
/// warning "left-out-properties". Throws Error{OutOfMemory} before values are made that the machine
/// has no memory for.
[[nodiscard]] std::vector<VertexAttribute> add_attributes(const SurfaceBlocks& surface,
                                                          std::vector<NamedField>& fields,
                                                          const Callbacks& callbacks);

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

/// What a mesh of an asset has besides its shape, at the rows of its surface. Further colours and
/// attributes go over the surface as COLOR_0 does, texture coordinates as TEXCOORD_0. Weights
/// of joints and moves of morph targets are interpolated as positions are, by the progressive
/// method's linear map: through what each vertex has, and smooth between; weights on fair surfaces
/// go as colours do. Of the weights of a row
/// the largest stay, four for each JOINTS_n that the mesh has, and are made to sum to 1.
class AssetAttributes {
 public:
  /// `surface` is a level of the fitted mesh, which is the asset's, or AdaptiveBlocks of it.
  /// Throws as fit(), Error{Cancelled};
  /// Error{InvalidArgument} for joints and morph targets where Catmull-Clark or Loop have no
  /// surface through them.
  AssetAttributes(const AssetMesh& mesh, const FittedMesh& fitted, const SurfaceBlocks& surface,
                  Backend& backend, const Callbacks& callbacks);

  /// Of a surface that is written with them, under the mesh's name and about 0, since nodes place
  /// it; this must outlive the options.
  void add_to(GltfOptions& options) const;
  /// Of the groups with a set of them (AssetGroup::tangent_set).
  [[nodiscard]] const SurfaceTangents& tangents() const { return tangents_.front(); }
  /// The largest sum of a row's weights that found no place, and of those below 0; 0 to 1.
  [[nodiscard]] double largest_lost_weight() const { return lost_weight_; }

 private:
  class Maker;

  std::string name_;
  std::list<std::vector<float>> values_;
  std::list<SurfaceTangents> tangents_{1};  // of groups, and of layers by depth
  std::list<std::vector<glm::dvec2>> uvs_;
  std::vector<GltfAttribute> attributes_;
  std::vector<int> uv_sets_;
  double lost_weight_ = 0;
};

}  // namespace planish
