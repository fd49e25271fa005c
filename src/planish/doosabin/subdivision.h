#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The circulant that makes an m-gon's corner points X_i = sum_j c_m(j-i) P_j.
enum class Weights {
  /// Doo & Sabin 1978. Curvature is bounded around vertices of valence 3 and 4 and in faces of as
  /// many
  /// corners; with five and more it grows as log(1/r) towards the point, since the step's
  /// eigenvalue 1/4 has Jordan blocks of two there.
  DooSabin,
  Averaged,  ///< the paper, equation (1): average of vertex, centroid and two edge midpoints
};

/// c_m(0..m-1), for m >= 2; sums to 1. m = 2 arises at interior vertices of valence 2.
/// Source: Doo & Sabin 1978; the paper, equation (1).
[[nodiscard]] std::vector<double> face_weights(Weights weights, std::int32_t m);

/// The same for large faces, in time of their corners: with M the mean of the corners and C, S
/// their first Fourier pair, 2/m sum_j cos(2 pi j / m) P_j and likewise with sines,
///
///   X_i = own P_i + beside (P_(i-1) + P_(i+1)) + mean M + turn (cos(2 pi i / m) C + sin(...) S)
///
/// for any m >= 3. A derivation of our own.
struct FaceSumRule {
  double own, beside, mean, turn;

  /// M alone, or all three.
  [[nodiscard]] constexpr std::int32_t sum_count() const { return turn == 0 ? 1 : 3; }
};
[[nodiscard]] constexpr FaceSumRule face_sum_rule(Weights weights) {
  return weights == Weights::Averaged ? FaceSumRule{0.5, 0.125, 0.25, 0}
                                      : FaceSumRule{0.25, 0, 0.75, 0.25};
}

/// Faces of this many corners or more go by those sums, as large rings do. Smaller ones have hardly
/// more corners than sums take columns.
inline constexpr std::int32_t kSummedRing = 32;

/// c_m of all sizes, those that meshes have many of made once.
class FaceWeights {
 public:
  explicit FaceWeights(Weights weights);

  [[nodiscard]] Weights weights() const { return weights_; }
  /// c_m(0..m-1). Large ones are computed into `scratch`, which keeps the last of them and must be
  /// used for nothing else.
  [[nodiscard]] std::span<const double> of(std::int32_t m, std::vector<double>& scratch) const;

 private:
  static constexpr std::int32_t kCachedSize = 64;
  Weights weights_;
  std::array<std::vector<double>, kCachedSize + 1> cached_;
};

/// The smallest eigenvalue of the circulant: the closed form of the spectral bound for one face
/// size, so that the limit-mask matrix of any closed mesh has its spectrum in
/// [min over face sizes, 1].
[[nodiscard]] double smallest_face_eigenvalue(Weights weights, std::int32_t m);

/// By the number of sharp edges at the vertex: none, one, two, three or more (or tagged).
enum class VertexKind : std::uint8_t { Smooth, Dart, Crease, Corner };

/// How the surface continues in the sector between two sharp edges at a corner vertex.
enum class CornerSector : std::uint8_t { Convex, HalfPlane, Reflex };

/// The sharp edges and vertices of a mesh. A sharp edge is a boundary edge or one tagged with
/// infinite sharpness; lower sharpness counts as none.
struct SharpFeatures {
  std::vector<VertexKind> vertex_kinds;     ///< one per vertex
  std::vector<std::int32_t> sharp_of_edge;  ///< per edge of the mesh its number among the sharp, or
                                            ///< -1; empty when there is none
  std::vector<std::int32_t> corner_of_vertex;  ///< per vertex its number among corners, or -1;
                                               ///< empty when there is none
  std::vector<std::int32_t> corner_vertices;   ///< by that number
  std::int32_t sharp_edge_count = 0;
  std::int32_t interior_sharp_edge_count = 0;
  std::int32_t corner_count = 0;
  /// Sectors at corners by (vertex, sharp edge that starts the sector counter-clockwise).
  std::unordered_map<std::uint64_t, CornerSector> corner_sectors;

  [[nodiscard]] static std::uint64_t sector_key(std::int32_t vertex, std::int32_t sharp_edge) {
    return static_cast<std::uint64_t>(vertex) << 32 | static_cast<std::uint32_t>(sharp_edge);
  }
};

/// `topology` is of `mesh`. Sector angles are measured on `rest_positions`, one per vertex of the
/// mesh: fixed once, so that a deformed surface keeps its rules.
[[nodiscard]] SharpFeatures find_sharp_features(const PolygonMesh& mesh,
                                                const MeshTopology& topology,
                                                std::span<const glm::dvec3> rest_positions,
                                                const SharpFeatureOptions& options);

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
