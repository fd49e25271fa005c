#pragma once

#include <opensubdiv/far/topologyLevel.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Element counts of one quad-split level.
struct LevelCounts {
  std::int64_t vertices, edges, faces;
};

/// Those of the levels 0 to `last` of a mesh with so many elements and corners.
[[nodiscard]] std::vector<LevelCounts> split_counts(const LevelCounts& base,
                                                    std::int64_t corner_count, int last);

/// The quad splits Q_0 (the mesh), Q_1, Q_2, ... of a polygon mesh: the dual of Doo-Sabin
/// subdivision. Q_0 is a MeshTopology; finer ones are made by OpenSubdiv's topology refiner with
/// the bilinear scheme, and only when asked for. What our tables rely on, checked when built:
///   - vertices of Q_(l+1): first one per vertex of Q_l, then one per face, then one per edge;
///   - faces of Q_(l+1): one per corner of Q_l's faces, in the order of the faces' corners;
///   - the faces around a vertex come counter-clockwise, at a boundary from the first to the last.
class QuadSplit {
 public:
  /// The mesh must pass check(), have no unused vertices, and outlive what is refined. Its tags
  /// become OpenSubdiv's sharpness. Throws Error{UnusableMesh} where faces do not meet as a
  /// manifold.
  explicit QuadSplit(const PolygonMesh& mesh);
  /// The same with the mesh's connectivity, which is at hand.
  QuadSplit(const PolygonMesh& mesh, std::shared_ptr<const MeshTopology> topology);
  QuadSplit(QuadSplit&&) noexcept;
  ~QuadSplit();

  /// Splits `levels` times, discarding earlier splits. Levels below `levels` have full topology;
  /// the last knows its faces' vertices only.
  void refine(int levels);

  [[nodiscard]] int level_count() const { return level_count_; }  ///< finest level made so far
  /// Q_0.
  [[nodiscard]] const MeshTopology& topology() const { return *topology_; }
  /// A level as OpenSubdiv has it, with sharpness.
  [[nodiscard]] const OpenSubdiv::Far::TopologyLevel& level(int index) const;

  /// For OpenSubdiv's own interpolation of primvars, see make_refiner(); made at the first call.
  [[nodiscard]] const OpenSubdiv::Far::TopologyRefiner& refiner() const;

  /// Counts of any level, without making it.
  [[nodiscard]] LevelCounts counts(int level) const { return counts_to(level).back(); }
  /// Counts of the levels 0 to `last`.
  [[nodiscard]] std::vector<LevelCounts> counts_to(int last) const;

  /// Index of the first corner of a face of `level` among all its corners, which is also the
  /// index of the first child of that face.
  [[nodiscard]] std::int32_t first_corner(int level, std::int32_t face) const {
    return level == 0 ? topology_->first_corner(face) : 4 * face;
  }

 private:
  struct Lazy {
    std::once_flag once;
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner;
  };
  [[nodiscard]] OpenSubdiv::Far::TopologyRefiner& made_refiner() const;

  const PolygonMesh* mesh_;
  std::shared_ptr<const MeshTopology> topology_;
  int level_count_ = 0;
  std::unique_ptr<Lazy> lazy_;
};

}  // namespace planish
