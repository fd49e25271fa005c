#pragma once

#include <opensubdiv/far/topologyLevel.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/refiner.h"
#include "planish/solve/stencil_table.h"

namespace planish::test {

/// The refiner that OpenSubdiv makes of the faces' vertices alone, finding edges and the order
/// around vertices itself; attributes and options as make_refiner(). Null where it refuses the
/// mesh.
[[nodiscard]] std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> descriptor_refiner(
    const PolygonMesh& mesh, const RefinerOptions& options);

/// The quad splits Q_0 (the mesh), Q_1, Q_2, ... of a polygon mesh: the dual of Doo-Sabin
/// subdivision. Q_0 is a MeshTopology; finer ones are made by OpenSubdiv's topology refiner with
/// the bilinear scheme. What users rely on, checked when refined:
///   - vertices of Q_(l+1): first one per vertex of Q_l, then one per face, then one per edge;
///   - faces of Q_(l+1): one per corner of Q_l's faces, in the order of the faces' corners;
///   - the faces around a vertex come counter-clockwise, at a boundary from the first to the last.
class QuadSplit {
 public:
  /// The mesh must pass check() and have no unused vertices. Its tags become OpenSubdiv's
  /// sharpness.
  explicit QuadSplit(const PolygonMesh& mesh);

  /// Splits `levels` times, discarding earlier splits. Levels below `levels` have full topology;
  /// the last knows its faces' vertices only.
  void refine(int levels);

  [[nodiscard]] int level_count() const { return refiner_->GetMaxLevel(); }
  /// Q_0.
  [[nodiscard]] const MeshTopology& topology() const { return topology_; }
  /// A level as OpenSubdiv has it, with sharpness.
  [[nodiscard]] const OpenSubdiv::Far::TopologyLevel& level(int index) const {
    return refiner_->GetLevel(index);
  }
  [[nodiscard]] const OpenSubdiv::Far::TopologyRefiner& refiner() const { return *refiner_; }

  /// Counts of any level, without making it.
  [[nodiscard]] LevelCounts counts(int level) const { return counts_to(level).back(); }
  /// Counts of the levels 0 to `last`.
  [[nodiscard]] std::vector<LevelCounts> counts_to(int last) const;

  /// Index of the first corner of a face of `level` among all its corners, which is also the
  /// index of the first child of that face.
  [[nodiscard]] std::int32_t first_corner(int level, std::int32_t face) const {
    return level == 0 ? topology_.first_corner(face) : 4 * face;
  }

 private:
  MeshTopology topology_;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
};

}  // namespace planish::test
