#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/mesh/mesh_topology.h"

namespace planish {

/// Everything that one Doo-Sabin step of a mesh depends on besides positions: connectivity, the
/// sharp features and the weights of the face rule. `topology` and `features` must outlive it.
///
/// The state of level 1 is one array of points: a Doo-Sabin control point per corner of the mesh's
/// faces, in their order, then two curve control points per sharp edge, then the position of each
/// corner vertex. The curve point at end 0 or 1 of sharp edge s (the end's place in the edge) has
/// number 2 s + end among them.
class Subdivision {
 public:
  Subdivision(const MeshTopology& topology, const SharpFeatures& features, Weights weights);

  [[nodiscard]] const MeshTopology& topology() const { return topology_; }
  [[nodiscard]] const SharpFeatures& features() const { return features_; }
  [[nodiscard]] const FaceWeights& face_weights() const { return face_weights_; }

  /// Number of an edge of the mesh among the sharp, or -1.
  [[nodiscard]] std::int32_t sharp_of_edge(std::int32_t edge) const {
    return has_sharp_edges() ? features_.sharp_of_edge[edge] : -1;
  }
  /// The edge with that number.
  [[nodiscard]] std::int32_t edge_of_sharp(std::int32_t sharp) const {
    return edge_of_sharp_[sharp];
  }
  [[nodiscard]] bool has_sharp_edges() const { return features_.sharp_edge_count > 0; }

  // Where the parts of the state of level 1 begin, and its size.
  [[nodiscard]] std::int32_t first_sharp() const { return topology_.corner_count(); }
  [[nodiscard]] std::int32_t first_corner() const {
    return first_sharp() + 2 * features_.sharp_edge_count;
  }
  [[nodiscard]] std::int32_t state_size() const { return first_corner() + features_.corner_count; }

 private:
  const MeshTopology& topology_;
  const SharpFeatures& features_;
  FaceWeights face_weights_;
  std::vector<std::int32_t> edge_of_sharp_;
};

}  // namespace planish
