#pragma once

#include <cstdint>
#include <vector>

#include "planish/primal/scheme.h"
#include "planish/primal/vertex_star.h"

namespace planish {

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

}  // namespace planish
