#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/doosabin/sharp_features.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/patches/patch_class.h"
#include "planish/patches/ring_sums.h"

namespace planish {

/// Control points of a patch: its class and where they are gathered from.
struct PatchPlace {
  enum class Around { Vertex, Edge, Face };

  PatchClass patch;
  /// Whose points come first.
  Around around;
  /// A corner patch's corner; of a limit point the corner of the own face.
  std::int32_t corner;
  /// Where V's sector begins, if it has one.
  std::int32_t sector_start;
};

/// The corner patches of a mesh: their classes, and their points in the state of level 1 (see
/// Subdivision), behind which stand the sums of large rings. Topology and features must outlive it.
class PatchMesh {
 public:
  PatchMesh(const MeshTopology& topology, const SharpFeatures& features,
            RingColumns columns = RingColumns::Points);

  [[nodiscard]] const MeshTopology& topology() const { return topology_; }
  [[nodiscard]] const SharpFeatures& features() const { return features_; }
  [[nodiscard]] std::int32_t first_sharp() const { return topology_.corner_count(); }
  [[nodiscard]] std::int32_t first_corner_vertex() const {
    return first_sharp() + 2 * features_.sharp_edge_count;
  }
  [[nodiscard]] std::int32_t state_size() const {
    return first_corner_vertex() + features_.corner_count;
  }
  /// The state's and the sums'.
  [[nodiscard]] std::int32_t point_count() const { return state_size() + sum_count_; }
  [[nodiscard]] bool has_sums() const { return sum_count_ > 0; }
  /// The points that are gathered from: a state of level 1 and its sums.
  [[nodiscard]] RawVector<glm::dvec3> with_sums(std::span<const glm::dvec3> state) const;
  /// Sets the sums of points (point_count()) whose state is there.
  void update_sums(std::span<glm::dvec3> points) const;
  /// The same of the rings around some corners' vertices and of their faces.
  void update_sums_at(std::span<const std::int32_t> corners, std::span<glm::dvec3> points) const;
  [[nodiscard]] std::span<const LargeRing> large_rings() const { return rings_; }
  /// A large ring's points in the order of ring_weights().
  void ring_points(const LargeRing& ring, std::vector<std::int32_t>& points) const;
  /// The ring that a sum is of.
  [[nodiscard]] const LargeRing& ring_of_sum(std::int32_t point) const;
  /// Whether one of large_rings() is of a face's corners, not around a vertex.
  [[nodiscard]] bool is_face_ring(const LargeRing& ring) const {
    return &ring >= rings_.data() + vertex_ring_count_;
  }

  [[nodiscard]] bool is_sharp_edge(std::int32_t edge) const {
    return !features_.sharp_of_edge.empty() && features_.sharp_of_edge[edge] >= 0;
  }
  /// Of a corner's leading edge.
  [[nodiscard]] bool is_sharp(std::int32_t corner) const {
    return !features_.sharp_of_edge.empty() && is_sharp_edge(topology_.edge_of(corner));
  }
  /// The first corner of the sector that a corner of a crease or corner vertex lies in: that with a
  /// sharp leading edge. A tagged vertex without sharp edges has no sectors: -1.
  [[nodiscard]] std::int32_t sector_start(std::int32_t corner) const;
  /// The first corners of a vertex's sectors in their order; the first corner at the vertex where
  /// there are none.
  void sector_starts(std::int32_t vertex, std::vector<std::int32_t>& starts) const;

  /// The one of them in whose sector a corner lies.
  [[nodiscard]] std::int32_t sector_corner(std::int32_t corner) const;

  [[nodiscard]] PatchPlace corner_patch(std::int32_t corner) const;
  /// The limit point of a vertex in the sector that begins with `start`, see sector_starts().
  [[nodiscard]] PatchPlace vertex_point(std::int32_t start) const;
  /// The limit point of an edge's midpoint, seen from the corner's face whose leading edge it is.
  [[nodiscard]] PatchPlace edge_point(std::int32_t corner) const;
  [[nodiscard]] PatchPlace face_point(std::int32_t face) const;

  /// Indices of the points of a place in the order of its class's columns, `stride` apart.
  void gather(const PatchPlace& place, std::int32_t* indices, std::ptrdiff_t stride) const;

 private:
  // Of a corner's vertex, sector or face where that is large, with the corner's place there.
  struct PlaceInRing {
    const LargeRing* ring = nullptr;
    std::int32_t place = 0;
    [[nodiscard]] std::int32_t first_sum() const { return ring->first_sum + 3 * place; }
  };
  [[nodiscard]] PlaceInRing ring_around_vertex(std::int32_t corner) const {
    if (ring_of_corner_.empty() || ring_of_corner_[corner] < 0) return {};
    return {&rings_[ring_of_corner_[corner]], place_of_corner_[corner]};
  }
  [[nodiscard]] PlaceInRing ring_of_face(std::int32_t corner) const;
  void update_ring(const LargeRing& ring, std::span<glm::dvec3> points) const;
  void find_large_rings();
  void add_ring(PatchKind kind, std::int32_t start, std::int32_t size, bool is_face);
  [[nodiscard]] static PatchClass by_sums(const PlaceInRing& at);
  [[nodiscard]] PatchPlace around_vertex(std::int32_t corner) const;
  [[nodiscard]] PatchKind sector_kind(std::int32_t start) const;
  [[nodiscard]] std::int32_t sector_size(std::int32_t start) const;
  // The curve point of a corner's sharp leading edge at the corner's end of it, and at the other.
  [[nodiscard]] std::int32_t curve_at_tail(std::int32_t corner) const;
  [[nodiscard]] std::int32_t curve_at_head(std::int32_t corner) const;

  const MeshTopology& topology_;
  const SharpFeatures& features_;
  // Around vertices, then of faces, each in the order of their sums.
  std::vector<LargeRing> rings_;
  std::size_t vertex_ring_count_ = 0;
  std::int32_t sum_count_ = 0;
  std::vector<std::int32_t> ring_of_corner_, place_of_corner_;  // around vertices; or empty
};

}  // namespace planish
