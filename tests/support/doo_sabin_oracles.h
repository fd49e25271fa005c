#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish::test {

/// The uniform biquadratic tensor-product B-spline surface of a grid() mesh whose net is extended
/// by one reflected row on every side (2 P_0 - P_1), evaluated from its basis functions. Vertex
/// (i, j) of the grid has parameters (i, j).
class BSplineOracle {
 public:
  BSplineOracle(const PolygonMesh& grid_mesh, int columns, int rows);

  [[nodiscard]] glm::dvec3 point(double u, double v) const;
  [[nodiscard]] glm::dvec3 normal(double u, double v) const;

 private:
  [[nodiscard]] glm::dvec3 control(int i, int j) const;
  template <class BasisU, class BasisV>
  [[nodiscard]] glm::dvec3 sum(const BasisU& basis_u, const BasisV& basis_v) const;

  std::vector<glm::dvec3> net_;  ///< with phantoms, (columns + 3) x (rows + 3)
  int columns_, rows_;
};

/// A closed polygon mesh in the course of explicit Doo-Sabin subdivision: every step makes a new
/// mesh of face polygons, edge quads and vertex polygons. Slow and literal on purpose: it is what
/// the library's dual formulation is held against.
struct ExplicitMesh {
  /// A face's corner, and the half-edge that leaves it.
  struct Corner {
    std::int32_t face, corner;
  };

  std::vector<glm::dvec3> points;
  std::vector<std::vector<std::int32_t>> faces;  ///< counter-clockwise
  /// twins[f][i] is the face and corner where the other half of the edge from corner i of face f
  /// begins. Kept explicitly: around a vertex of valence 2 two points are joined by two edges.
  std::vector<std::vector<Corner>> twins;
  std::vector<Corner>
      origins;  ///< the corner of the previous mesh that each point was made for; empty at level 0
  /// The polygon that has shrunk towards each base vertex's limit point; empty at level 0.
  std::vector<std::int32_t> polygon_of_base_vertex;
};

/// New corner points of one polygon. `Averaged` literally averages the vertex, the centroid and
/// the two edge midpoints; `DooSabin` uses the weights of Doo & Sabin 1978.
[[nodiscard]] std::vector<glm::dvec3> shrunk_polygon(Weights weights,
                                                     const std::vector<glm::dvec3>& polygon);

[[nodiscard]] ExplicitMesh explicit_mesh(const PolygonMesh& mesh);
[[nodiscard]] ExplicitMesh explicit_step(const ExplicitMesh& mesh, Weights weights);
[[nodiscard]] ExplicitMesh explicit_levels(const PolygonMesh& mesh, Weights weights, int levels);

[[nodiscard]] glm::dvec3 face_centroid(const ExplicitMesh& mesh, std::int32_t face);

/// Limit points of the base vertices: the centroids of their polygons, which no step moves.
[[nodiscard]] std::vector<glm::dvec3> explicit_limit_points(const ExplicitMesh& mesh);

/// Doo-Sabin surfaces with boundaries, creases, corners and darts by repeated quad split,
/// written from the formulas alone, with maps instead of tables. The oracle for open and sharp
/// meshes, where explicit subdivision of polygons has no rule.
class QuadSplitOracle {
 public:
  using Edge = std::pair<std::int32_t, std::int32_t>;  ///< smaller index first

  /// Faces around a vertex between two sharp edges (or all of them), counter-clockwise.
  struct Sector {
    std::vector<std::int32_t> faces;
    bool is_ring = false;
    Edge first{-1, -1}, last{-1, -1};  ///< where not a ring
  };

  /// Level 1 of `cage`. Sector angles are measured on `rest`, or on the cage where it is empty.
  QuadSplitOracle(const PolygonMesh& cage, Weights weights, BoundaryRule boundary,
                  std::span<const glm::dvec3> rest = {});

  /// One more quad split. Vertices keep their numbers; face q's children are 4q .. 4q + 3.
  void refine();

  [[nodiscard]] std::int32_t vertex_count() const { return vertex_count_; }
  [[nodiscard]] const std::vector<std::array<std::int32_t, 4>>& faces() const { return faces_; }
  /// The Doo-Sabin control point of face q.
  [[nodiscard]] glm::dvec3 face_point(std::int32_t q) const { return face_points_[q]; }
  /// Unused vertices count as corners: they stay where they are.
  [[nodiscard]] VertexKind kind(std::int32_t vertex) const;
  [[nodiscard]] glm::dvec3 limit_point(std::int32_t vertex) const;
  [[nodiscard]] const std::vector<Sector>& sectors(std::int32_t vertex) const {
    return sectors_.at(vertex);
  }
  /// The sector of `vertex` that face q lies in.
  [[nodiscard]] std::size_t sector_of(std::int32_t vertex, std::int32_t q) const;
  /// The two limit tangents of a sector; the normal is along their cross product.
  [[nodiscard]] std::pair<glm::dvec3, glm::dvec3> tangents(std::int32_t vertex,
                                                           std::size_t sector) const;
  [[nodiscard]] glm::dvec3 normal(std::int32_t vertex, std::size_t sector) const;

 private:
  using Corner = std::pair<std::int32_t, std::int32_t>;  ///< face, vertex

  void split(const std::vector<std::vector<std::int32_t>>& polygons);
  void find_sectors();
  [[nodiscard]] std::vector<std::int32_t> faces_from(std::int32_t vertex, std::int32_t start) const;
  void find_corners(const PolygonMesh& cage, BoundaryRule boundary,
                    std::span<const glm::dvec3> rest);
  [[nodiscard]] glm::dvec3 child_of_curve_point(Edge edge, std::int32_t end,
                                                const std::map<Corner, glm::dvec3>& children) const;
  [[nodiscard]] glm::dvec3 mean_beside(Edge edge, std::int32_t end,
                                       const std::map<Corner, glm::dvec3>& points) const;
  [[nodiscard]] std::vector<glm::dvec3> frame(std::int32_t vertex, std::size_t sector) const;
  [[nodiscard]] std::vector<glm::dvec3> children(std::int32_t vertex, std::size_t sector) const;

  Weights weights_;
  std::int32_t vertex_count_ = 0;
  std::vector<std::array<std::int32_t, 4>> faces_;
  std::vector<glm::dvec3> face_points_;
  std::map<Edge, glm::dvec3> curve_points_;             ///< of the sharp edges
  std::map<std::int32_t, std::vector<Edge>> sharp_at_;  ///< sharp edges around a vertex
  std::map<std::int32_t, glm::dvec3> corners_;          ///< positions of the corner vertices
  std::map<std::int32_t, std::vector<CornerSector>> corner_sectors_;
  std::map<std::int32_t, std::vector<Sector>> sectors_;
  std::map<Edge, std::int32_t> edge_vertices_;  ///< made by the latest split
  std::map<Edge, std::int32_t> face_left_of_;   ///< directed edge -> face
};

}  // namespace planish::test
