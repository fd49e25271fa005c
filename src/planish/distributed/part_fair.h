#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "planish/distributed/mesh_part.h"
#include "planish/distributed/ranks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"

namespace planish {

/// The control point on a curve at the end `vertex` of a sharp edge.
struct CurveKey {
  std::int64_t vertex, other;  ///< numbers along the curve of the vertices
  std::int32_t index;          ///< in the state of level 1
};

/// Those of a sub mesh in the order of its state of level 1.
[[nodiscard]] std::vector<CurveKey> curve_keys(const MeshPart& part, const SubMesh& sub,
                                               const MeshTopology& topology,
                                               const SharpFeatures& features);
/// The index of a key among sorted ones (sort_keys()).
void sort_keys(std::vector<CurveKey>& keys);
[[nodiscard]] std::optional<std::int32_t> index_of(std::span<const CurveKey> sorted_keys,
                                                   const CurveKey& key);

/// The halo of a rank's part, which a sub mesh with all of its faces is: what vertices' owners
/// found goes where else those vertices are. Sums are those of blocks, added in their order.
class PartHalo final : public FairHalo {
 public:
  /// `keys`: of the sub mesh, sorted. `after_exchange`: a sign of life. All must outlive it but the
  /// keys. The same blocks on all ranks, which are cut between them.
  PartHalo(const Ranks& ranks, const MeshPart& part, const SubMesh& sub,
           std::span<const CurveKey> keys, std::int64_t block_vertices,
           std::function<void()> after_exchange);

  void exchange_vertices(std::span<double> values) override;
  void exchange_vertices(std::span<glm::dvec3> values) override;
  void exchange_vertices(std::span<std::uint8_t> values) override;
  void exchange_corners(std::span<float> values) override;
  void exchange_state(std::span<glm::dvec3> values) override;
  [[nodiscard]] double sum_of_vertices(std::span<const double> values) override;
  [[nodiscard]] double sum_of_faces(std::span<const double> values) override;
  [[nodiscard]] std::int64_t sum(std::int64_t value) override;
  [[nodiscard]] double largest(double value) override;
  [[nodiscard]] std::span<const std::uint8_t> owned_vertices() const override {
    return owned_vertices_;
  }
  [[nodiscard]] std::span<const std::uint8_t> owned_faces() const override { return owned_faces_; }

 private:
  // Which local values go to others, and where theirs go.
  struct Link {
    std::vector<std::int64_t> sent, received;  // a rank
    std::vector<std::int32_t> sources, targets;
  };
  // The elements of each of this rank's blocks, one block after another.
  struct Blocks {
    std::vector<std::int64_t> offsets{0};
    std::vector<std::int32_t> elements;
  };
  template <class Request, class OwnerOf, class Find>
  [[nodiscard]] Link link(const std::vector<Request>& requests, const OwnerOf& owner,
                          const Find& find) const;
  template <class T>
  void exchange(const Link& link, std::span<T> values);
  [[nodiscard]] double sum_of(const Blocks& blocks, std::span<const double> values);

  void link_vertices(const SubMesh& sub);
  void link_corners(const SubMesh& sub);
  void link_curves(std::span<const CurveKey> keys);
  void list_blocks(const SubMesh& sub, std::int64_t block_vertices);

  const Ranks& ranks_;
  const MeshPart& part_;
  std::function<void()> after_exchange_;
  std::vector<std::int32_t> sub_vertices_;  // of the part's vertices, the first copy; -1: unused
  std::vector<std::uint8_t> owned_vertices_, owned_faces_;
  Link vertices_, corners_, curves_;
  Blocks vertex_blocks_, face_blocks_;
  std::vector<int> block_counts_, block_places_;  // a rank
};

struct PartFairOptions {
  FitOptions fit;  ///< weights, sharp, polish_steps, cures_folds, within and tolerance count
  Placement placement;
  std::span<const glm::dvec3> points;  ///< to pass through, by local vertex; none: the part's
  std::int64_t block_vertices = kBlockVertices;
  std::function<void()> after_exchange;  ///< a sign of life
};

/// The fair surface of a rank's part: control points of level 1 at all corners of its faces, and on
/// curves. Figures are of the whole mesh.
struct PartFair : FairFigures {
  std::vector<glm::dvec3> state;  ///< per corner of the part, then by `keys`
  std::vector<CurveKey> keys;     ///< sorted; those at the part's rim say nothing
  Placement placement;            ///< in whose coordinates the state is
  ErrorNorms error;
  bool converged = false;
  std::int64_t concave_faces = 0;
};

/// bend_least() with exchanges, of the part's positions: the points that options.fit.within leaves
/// the surface to pass through, by local vertex, none where it leaves none. The part needs its
/// ghosts' tags. Throws AgreedError as make_part_fair().
struct PartWithin {
  std::optional<WithinFit> figures;
  std::vector<glm::dvec3> points;
};
[[nodiscard]] PartWithin bend_part_least(const Ranks& ranks, const MeshPart& part,
                                         const PartFairOptions& options);

/// fair_net() and the looks at the finished surface, with exchanges: the bits of one machine but
/// for sums over blocks, which single precision follows; the same for every count of ranks. The
/// part needs its ghosts' tags. Throws AgreedError where a rank cannot make its part's topology.
[[nodiscard]] PartFair make_part_fair(const Ranks& ranks, const MeshPart& part,
                                      const PartFairOptions& options);

/// The control points of a sub mesh of the part, as LevelOne has them. Those on curves that the
/// part does not know, at the sub mesh's rim, stand at their vertices.
[[nodiscard]] LevelOne level_one_of(const MeshPart& part, const PartFair& fair, const SubMesh& sub,
                                    const MeshTopology& topology, const SharpFeatures& features);

}  // namespace planish
