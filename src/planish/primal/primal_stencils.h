#pragma once

#include <opensubdiv/far/topologyLevel.h>
#include <opensubdiv/far/topologyRefiner.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/primal/scheme.h"
#include "planish/solve/stencil_builder.h"
#include "planish/solve/stencil_table.h"

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

/// A vertex with the edges and faces around it, counter-clockwise, at a boundary from the first to
/// the last edge. Face i lies between edges i and i + 1.
struct VertexStar {
  std::int32_t vertex = 0;
  float sharpness = 0;
  std::vector<std::int32_t> edge_ends;  ///< the edges' other vertices
  std::vector<float> edge_sharpness;
  /// Catmull-Clark where every face is a quad: its corner opposite to the vertex; else empty.
  std::vector<std::int32_t> face_ends;
  std::int32_t face_count = 0;

  [[nodiscard]] std::int32_t edge_count() const {
    return static_cast<std::int32_t>(edge_ends.size());
  }
  [[nodiscard]] bool is_boundary() const { return face_count < edge_count(); }
};

/// The star of a vertex of M_level, with `face_ends` from level 1 on. Reuse `star` to avoid
/// allocation.
void gather_star(const PrimalSplit& split, int level, std::int32_t vertex, VertexStar& star);

// Sectors: the faces between two edges of infinite sharpness, which part the normals.

/// 1 where there are fewer than two such edges.
[[nodiscard]] std::int32_t sector_count(const VertexStar& star);
/// The sector that holds the star's face `face`.
[[nodiscard]] std::int32_t sector_of(const VertexStar& star, std::int32_t face);

/// A sector's faces.
struct Sector {
  std::int32_t first_edge, face_count;
};
/// For stars of at least two sectors and for boundaries.
[[nodiscard]] Sector sector(const VertexStar& star, std::int32_t index);

/// Weights of a star's points.
struct StarWeights {
  double vertex = 0;
  std::vector<double> edges;  ///< one per edge
  std::vector<double> faces;  ///< one per face; empty for Loop
};

/// One of Sdc's masks, in double: weights of a vertex or an edge's two vertices, of the edges' ends
/// and of the faces. Vectors may be longer than the counts.
class SubdivisionMask {
 public:
  // What Sdc::Scheme asks of a mask, in its spelling.
  using Weight = double;
  [[nodiscard]] int GetNumVertexWeights() const { return vertex_count_; }
  [[nodiscard]] int GetNumEdgeWeights() const { return edge_count_; }
  [[nodiscard]] int GetNumFaceWeights() const { return face_count_; }
  void SetNumVertexWeights(int count) { vertex_count_ = grow(vertices_, count); }
  void SetNumEdgeWeights(int count) { edge_count_ = grow(edges_, count); }
  void SetNumFaceWeights(int count) { face_count_ = grow(faces_, count); }
  double& VertexWeight(int index) { return vertices_[index]; }
  double& EdgeWeight(int index) { return edges_[index]; }
  double& FaceWeight(int index) { return faces_[index]; }
  [[nodiscard]] bool AreFaceWeightsForFaceCenters() const { return for_centres_; }
  void SetFaceWeightsForFaceCenters(bool on) { for_centres_ = on; }

  // The weight, or 0 where the mask has none.
  [[nodiscard]] double vertex(int i) const { return i < vertex_count_ ? vertices_[i] : 0.0; }
  [[nodiscard]] double edge(int i) const { return i < edge_count_ ? edges_[i] : 0.0; }
  [[nodiscard]] double face(int i) const { return i < face_count_ ? faces_[i] : 0.0; }

 private:
  static int grow(std::vector<double>& weights, int count) {
    if (static_cast<int>(weights.size()) < count) weights.resize(static_cast<std::size_t>(count));
    return count;
  }

  int vertex_count_ = 0, edge_count_ = 0, face_count_ = 0;
  bool for_centres_ = false;
  std::vector<double> vertices_, edges_, faces_;
};

/// Where the vertex goes: face weights are for the faces' centres.
void vertex_mask(PrimalScheme scheme, const VertexStar& star, SubdivisionMask& mask);

/// The new vertex of an edge: face weights are for the faces' centres (Catmull-Clark) or their
/// vertices opposite to the edge (Loop).
void edge_mask(PrimalScheme scheme, float sharpness, std::int32_t face_count,
               SubdivisionMask& mask);

/// Limit position and tangents of a star whose edges and vertex are smooth or of infinite
/// sharpness. Source: Sdc::Scheme::ComputeVertexLimitMask(), which is wrong next to faces other
/// than quads, at darts, at smooth vertices of valence 2 and in its tangents at corners.
struct LimitMasks {
  SubdivisionMask position, du, dv;
};
void limit_mask(PrimalScheme scheme, const VertexStar& star, LimitMasks& masks);

/// The weights of a star's points in its limit point, and in two tangents of a sector whose cross
/// product is the outward normal's direction.
struct StarLimit {
  StarWeights position, du, dv;
};

/// Computes limits; keeps scratch memory and the masks of the last star.
class StarLimits {
 public:
  explicit StarLimits(PrimalScheme scheme) : scheme_(scheme) {}

  /// The exact limit of subdivision, semi-sharp edges and darts included, of a star whose faces are
  /// quads (Catmull-Clark) or triangles (Loop). Derivatives are exact wherever the surface has a
  /// tangent plane; at corners of two and more faces and at tagged vertices without sharp edges,
  /// where it has none, they span a mean of the planes around.
  [[nodiscard]] const StarLimit& limit(const VertexStar& star, std::int32_t sector);

 private:
  void pull_back(const VertexStar& star, StarWeights& weights);
  void stationary_position();
  void stationary_tangents(std::int32_t sector);
  void ring_tangents(std::int32_t first_edge);
  void fan_tangents(const Sector& faces, bool corner);
  void settle_position();
  void settle_tangent(const VertexStar& star, const StarWeights& position, StarWeights& tangent);
  void take_odd_part(std::int32_t edge, StarWeights& tangent);
  void make_fan(std::int32_t face_count);
  [[nodiscard]] bool has_one_sharp_edge() const;

  PrimalScheme scheme_;
  VertexStar star_;  // with the sharpness of the step at hand
  VertexStar part_;  // the same as Sdc is shown it: turned, or one sector
  LimitMasks masks_;
  SubdivisionMask mask_;
  StarWeights pulled_;
  StarLimit limit_, fan_;
};

/// From the vertices of M_level to those of M_(level + 1): one step of the scheme, rows of
/// M_(level + 1). Source: OpenSubdiv's masks.
[[nodiscard]] StencilTable primal_refinement_table(const PrimalSplit& split, int level,
                                                   RowRange rows);

/// The output vertices of M_level, level >= 1, of which the first `vertex_count` are wanted.
[[nodiscard]] SectorRows primal_sector_rows(const PrimalSplit& split, int level,
                                            std::int64_t vertex_count);

/// Limit points, with du and dv whose cross product is the outward normal's direction, of rows of
/// `sectors`, from the vertices of M_level, level >= 1. See StarLimits.
[[nodiscard]] StencilTable primal_limit_table(const PrimalSplit& split, int level,
                                              const SectorRows& sectors, RowRange rows);

/// The matrix B of the interpolation: row v gives the limit point of vertex v of the mesh from all
/// control points. The split must have a level 1. Rows sum to 1.
[[nodiscard]] StencilTable primal_limit_masks(const PrimalSplit& split);

/// What is known of the eigenvalues of a primal scheme's B.
struct Spectrum {
  double smallest = 0;  ///< estimate of the smallest; at or below 0 the iterations do not converge
  bool proven = false;  ///< `smallest` is a lower bound
  /// B is self-adjoint in the inner product of primal_row_weights(): closed without any sharpness.
  bool self_adjoint = false;
};

/// By formula where that gives a bound above 0: without semi-sharp edges and darts the rows of
/// smooth vertices, scaled, are symmetric and the others depend on themselves alone, so that B's
/// eigenvalues are real and above the least of (n - 3) / (n + 5) over the smooth valences n
/// (Catmull-Clark; (s - n / 2) / (s + n) with Loop, s the ratio of own weight to an edge's plus n,
/// see the source) and 1/3 (creases). Elsewhere by Lanczos on the rows of smooth vertices.
/// `limit_masks` are primal_limit_masks() of the split.
[[nodiscard]] Spectrum primal_spectrum(const PrimalSplit& split,
                                       const StencilView<double>& limit_masks);

/// Per vertex the factor that makes the rows of smooth vertices symmetric: n (n + 5) with
/// Catmull-Clark, 3 / (8 beta) + n with Loop, where beta is the weight of an edge in the scheme's
/// mask for the vertex.
[[nodiscard]] std::vector<double> primal_row_weights(const PrimalSplit& split);

}  // namespace planish
