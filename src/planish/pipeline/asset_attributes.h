#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <list>
#include <string>
#include <vector>

#include "planish/backend/backend.h"
#include "planish/core/callbacks.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/gltf_tangents.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

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
