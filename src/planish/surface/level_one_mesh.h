#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "planish/doosabin/subdivision.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/evaluate.h"

namespace planish {

/// The mesh, which must outlive the result, without its unused vertices. Takes what was prepared of
/// it, or of another with the same faces and tags, or else prepares it. Throws Error{UnusableMesh}.
[[nodiscard]] UsedPart usable_part(const PolygonMesh& mesh,
                                   std::shared_ptr<const PreparedMesh> prepared = nullptr);

/// A mesh with everything that its level 1 depends on besides control points; a fair net's first
/// step takes the weights of 1978.
struct SubdividedMesh {
  /// The mesh must outlive it. Makes what is not given. Throws Error{UnusableMesh}.
  SubdividedMesh(const PolygonMesh& mesh, const SharpFeatureOptions& sharp,
                 std::shared_ptr<const PreparedMesh> prepared = nullptr,
                 std::shared_ptr<const SharpFeatures> found = nullptr);
  SubdividedMesh(const SubdividedMesh&) = delete;
  SubdividedMesh& operator=(const SubdividedMesh&) = delete;

  UsedPart used;
  std::shared_ptr<const SharpFeatures> features;
  Subdivision subdivision;
};

/// A corner of a polygon of level_one_mesh().
struct NetCorner {
  /// A neighbour of a corner of the given mesh in its face.
  enum class Toward { Previous, Next };

  std::int32_t vertex;  ///< of the net
  std::int32_t face;    ///< of Q_1, a corner of the given mesh: the one it is seen from
  /// Below 0 for the control point of `face` itself; else the point lies this share of the way from
  /// the corner to a neighbour.
  double along = -1;
  Toward toward = Toward::Next;
};

/// Which way the faces of a ring lie.
enum class RingAround { Vertex, Edge };

/// Texture coordinates of the mesh of level 1. Each control point takes the mean over its face of
/// Q_1, moved so that the mean around every vertex without a seam is the given coordinate. A
/// polygon across a seam lies in the chart of most of its corners, which is continued over the
/// others. Polygons with a corner that has no coordinate have none.
class LevelOneUvs {
 public:
  explicit LevelOneUvs(const SubdividedMesh& base);

  /// The next polygon. `closed`: the faces of its corners are all of a vertex's, in their order;
  /// otherwise the first and the last corner are not compared.
  void add(std::span<const NetCorner> polygon, RingAround around, bool closed);
  void move_to(PolygonMesh& net);

 private:
  struct Chart {
    std::size_t first, count;
  };

  [[nodiscard]] std::int32_t neighbour(std::int32_t corner, NetCorner::Toward toward) const;
  [[nodiscard]] glm::dvec2 given(std::int32_t corner) const;
  [[nodiscard]] glm::dvec2 value(const NetCorner& corner) const;
  [[nodiscard]] bool is_seam(const NetCorner& from, const NetCorner& to, RingAround around) const;
  [[nodiscard]] glm::dvec2 mean_over(std::int32_t corner) const;
  void interpolate_given();
  void add_continued(std::span<const NetCorner> polygon, Chart chart, RingAround around,
                     bool closed);
  std::int32_t index_of(const NetCorner& corner);

  const SubdividedMesh& base_;
  const PolygonMesh& mesh_;
  std::vector<std::int32_t> mesh_face_;  // of each corner
  std::vector<bool> has_uvs_;            // per face of the mesh
  std::vector<glm::dvec2> uvs_;
  std::vector<std::int32_t> face_uvs_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> index_on_edge_;
};

/// The polygon mesh of level 1, the cage of a fair surface. Its first vertices are the state, in
/// its order and in model coordinates. Its faces: first those around the vertices of `mesh`, then
/// those within its faces, then those across its edges. Around a smooth vertex lies one polygon,
/// whose centroid is the limit point; between two sharp edges one polygon for each sector, closed
/// by the segment between their curve points, whose middle is the limit point; around a corner each
/// such polygon also holds the corner itself; a sharp edge has a quad on each of its sides.
/// Vertices of valence two have none. Segments of sharp curves between two polygons are tagged as
/// creases, corners as corners.
/// Holes: polygons across the border of a hole are cut along it, at the limit point and at the
/// middles of their edges, which are further vertices, and the parts within are tagged. Texture
/// coordinates: see LevelOneUvs. Colours and groups are carried, a polygon across several groups
/// taking that of its first face.
/// `around`, where given, gets for each polygon what it lies around: a vertex of `mesh` (without
/// the unused ones), a face behind all vertices, an edge behind all faces.
/// Throws Error{UnusableMesh}, Error{InvalidArgument} for a state of another size.
[[nodiscard]] PolygonMesh level_one_mesh(const PolygonMesh& mesh, const LevelOne& level_one,
                                         const SharpFeatureOptions& sharp,
                                         std::vector<std::int32_t>* around = nullptr);
[[nodiscard]] PolygonMesh level_one_mesh(const SubdividedMesh& base, const LevelOne& level_one,
                                         std::vector<std::int32_t>* around = nullptr);

/// The state that a cage made by level_one_mesh() holds, in model coordinates; evaluate() makes of
/// it the surface that the cage was made from. Throws Error{InvalidArgument} for a mesh that is no
/// such cage of `mesh`: too few vertices, other faces.
[[nodiscard]] LevelOne level_one_of_cage(const PolygonMesh& mesh, const PolygonMesh& cage,
                                         const SharpFeatureOptions& sharp);

}  // namespace planish
