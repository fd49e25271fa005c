#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/stencil/quad_split.h"

namespace planish {

/// Everything that stencils depend on besides positions: the quad splits, the sharp features and
/// the weights of the face rule. `split` and `features` must outlive it.
///
/// The state of level l >= 1 is one array of points: a Doo-Sabin control point per face of Q_l,
/// then a curve control point per sharp edge of Q_l, then the position of each corner vertex.
/// Child `end` (0 or 1, the end's place in the edge) of sharp edge s has number 2 s + end.
class Subdivision {
 public:
  Subdivision(const QuadSplit& split, const SharpFeatures& features, Weights weights);

  [[nodiscard]] const QuadSplit& split() const { return split_; }
  [[nodiscard]] const SharpFeatures& features() const { return features_; }

  /// c_m of the face rule. Large ones are computed into `scratch`, which keeps the last of them
  /// and must be used for nothing else.
  [[nodiscard]] std::span<const double> face_weights(std::int32_t m,
                                                     std::vector<double>& scratch) const {
    return face_weights_.of(m, scratch);
  }
  [[nodiscard]] const FaceWeights& all_face_weights() const { return face_weights_; }

  /// Number of an edge of Q_level among the sharp edges of that level, or -1; level < level_count
  /// of the split, or 0.
  [[nodiscard]] std::int32_t sharp_of_edge(int level, std::int32_t edge) const {
    return sharp_of_edge_[level].empty() ? -1 : sharp_of_edge_[level][edge];
  }
  /// The edge of Q_level with that number among the sharp.
  [[nodiscard]] std::int32_t edge_of_sharp(int level, std::int32_t sharp) const {
    return edge_of_sharp_[level][sharp];
  }
  [[nodiscard]] bool has_sharp_edges() const { return features_.sharp_edge_count > 0; }

  /// Where the parts of a level's state begin.
  struct StateLayout {
    std::int64_t first_sharp, first_corner, size;
  };
  /// Level 1 to one more than the split has.
  [[nodiscard]] const StateLayout& state_layout(int level) const { return layouts_[level]; }

 private:
  const QuadSplit& split_;
  const SharpFeatures& features_;
  FaceWeights face_weights_;
  std::vector<StateLayout> layouts_;
  std::vector<std::vector<std::int32_t>> sharp_of_edge_, edge_of_sharp_;  // per level
};

}  // namespace planish
