#pragma once

#include <opensubdiv/far/topologyLevel.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/sharpness.h"
#include "planish/primal/scheme.h"
#include "planish/stencil/level_counts.h"

namespace planish {

struct PrimalSplitOptions {
  PrimalScheme scheme = PrimalScheme::CatmullClark;
  SharpFeatureOptions sharp;
  const MeshTopology* topology = nullptr;  ///< the mesh's, where it is at hand
};

/// The uniformly refined meshes M_0 (the mesh), M_1, M_2, ... of Catmull-Clark (quad split) or Loop
/// (triangle split), with their sharpness, by OpenSubdiv's topology refiner. Every level has full
/// topology. What our tables rely on, checked when refined:
///   - vertices of M_(l+1): one per vertex of M_l, then (Catmull-Clark) one per face, then one per
///     edge;
///   - the child faces of a face follow one another, in the order of the faces; child i < corners
///     holds corner i.
class PrimalSplit {
 public:
  /// The mesh must pass check() and have no unused vertices. Throws Error{UnusableMesh} for Loop on
  /// a mesh with other faces than triangles, naming the first; for Catmull-Clark on one with faces
  /// so large (one of 4,096 corners is not) that their stencils would take more than 1 GiB.
  PrimalSplit(const PolygonMesh& mesh, const PrimalSplitOptions& options);
  ~PrimalSplit();

  /// Refines `levels` times, discarding earlier refinement.
  void refine(int levels);

  [[nodiscard]] PrimalScheme scheme() const { return scheme_; }
  [[nodiscard]] int level_count() const { return refiner_->GetMaxLevel(); }
  [[nodiscard]] const OpenSubdiv::Far::TopologyLevel& level(int index) const {
    return refiner_->GetLevel(index);
  }
  [[nodiscard]] const OpenSubdiv::Far::TopologyRefiner& refiner() const { return *refiner_; }

  // Of the mesh: edges of any sharpness, boundaries among them, and vertices that stay where they
  // are at first.
  [[nodiscard]] int sharp_edge_count() const;
  [[nodiscard]] int boundary_edge_count() const;
  [[nodiscard]] int corner_count() const;

  /// Counts of the levels 0 to `last`, without making them.
  [[nodiscard]] std::vector<LevelCounts> counts_to(int last) const;

 private:
  PrimalScheme scheme_;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
};

}  // namespace planish
