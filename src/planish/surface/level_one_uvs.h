#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/subdivided_mesh.h"

namespace planish {

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

}  // namespace planish
