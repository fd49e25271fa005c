#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "planish/fair/fair_halo.h"
#include "planish/fair/fair_net.h"
#include "planish/pipeline/fit.h"

namespace planish {

/// Where a surface of control points of level 1 is folded at level 3, beyond the places that the
/// fair construction looks at.
struct DeepFolds {
  std::vector<std::uint8_t> at_vertex;  ///< one per vertex: 1 where its part of a face has folds
  double area = 0;                      ///< of these, a share of the mesh's
};

/// Shares of the area below this are none. Of a single place: at coarser levels it counts for more.
inline constexpr double kNoDeepFolds = 1e-8;

/// Looks at the vertices where there may be any: those with sharp edges, those whose faces turn by
/// more than about 25 degrees from their normal and, where there are folds, those around. Faces at
/// folded edges (mesh/folded_edges.h) do not count. One look is for all control points of a mesh;
/// what it needs of the mesh is made when there is something to look at.
class DeepLook {
 public:
  /// `mesh`: without unused vertices; topology and features are its; all outlive this. The weights
  /// are those of the fit. `halo`: where the mesh is a part; the area is a share of the whole then.
  DeepLook(const PolygonMesh& mesh, const MeshTopology& topology, const SharpFeatures& features,
           Weights weights, FairHalo* halo = nullptr);
  ~DeepLook();

  /// `level_one` in any coordinates. Empty where no vertex is to be looked at.
  [[nodiscard]] DeepFolds at(const LevelOne& level_one, const Callbacks& callbacks = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

struct DeepCure {
  /// Takes decisions or makes its own.
  std::function<FairNet(const FairDecisions* decisions)> make_net;
  std::function<DeepFolds(FairNet& net)> folds_of;
  /// choose_ellipses() of fair/hub_ellipse.h.
  std::function<std::vector<std::uint8_t>(std::span<const std::uint8_t> flagged,
                                          FairDecisions& decisions)>
      choose_ellipses;
  FairHalo* halo = nullptr;  ///< where the mesh is a part: all parts take the same way
};

/// Folds between the places that the construction looks at shrink with the polygons around: those
/// of the vertices beside them are cured once more, in a net of the same decisions otherwise; where
/// that leaves folds all over again, with ellipses that cross the edges. Not every round helps: the
/// best net counts.
[[nodiscard]] FairNet deeply_cured_net(const DeepCure& cure);

}  // namespace planish
