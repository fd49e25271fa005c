#include "planish/doosabin/subdivision.h"

namespace planish {

Subdivision::Subdivision(const MeshTopology& topology, const SharpFeatures& features,
                         Weights weights)
    : topology_(topology),
      features_(features),
      face_weights_(weights),
      edge_of_sharp_(static_cast<std::size_t>(features.sharp_edge_count)) {
  for (std::size_t e = 0; e < features.sharp_of_edge.size(); ++e) {
    if (features.sharp_of_edge[e] >= 0)
      edge_of_sharp_[features.sharp_of_edge[e]] = static_cast<std::int32_t>(e);
  }
}

}  // namespace planish
