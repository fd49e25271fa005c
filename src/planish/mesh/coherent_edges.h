#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <unordered_map>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// How far the two faces of an edge turn, told from what its surroundings do.
class EdgeTurns {
 public:
  /// `face_normals`: of any length, zero where a face has no area. All must outlive it.
  EdgeTurns(const PolygonMesh& mesh, const MeshTopology& topology,
            std::span<const glm::dvec3> face_normals);

  /// In radians; 0 at boundaries and faces without area.
  [[nodiscard]] double turn(std::int32_t edge) const;
  /// Above 0 at ridges, below at valleys.
  [[nodiscard]] double signed_turn(std::int32_t edge) const;

  /// Whether an edge is a line of the shape rather than part of an even curvature or of noise: it
  /// turns by a right angle's two thirds; or by twice as much as the third sharpest edge at one of
  /// its ends, where two are the line's own, if there are more than three, and is no strip of a
  /// coarse cylinder, whose edges beyond both its faces turn alike, not both by two thirds, and are
  /// about as far off; or bounds a chamfer.
  [[nodiscard]] bool stands_out(std::int32_t edge) const;
  /// Whether one of its ends is flat but for two edges, or one of its sides is up to the next line:
  /// a line of a part, however little it turns.
  [[nodiscard]] bool is_clear(std::int32_t edge) const;

 private:
  using Around = std::array<double, 4>;  // the largest turns at a vertex, largest first
  [[nodiscard]] Around look_around(std::int32_t vertex) const;
  [[nodiscard]] Around around(std::int32_t vertex) const;
  [[nodiscard]] double third_turn(std::int32_t vertex) const;
  [[nodiscard]] bool is_flat_up_to_line(std::int32_t corner, bool is_ccw, double line) const;
  struct Strip {
    double width = 0;                           // 0: there is no other edge
    std::int32_t far_edge = -1, far_face = -1;  // what lies beyond
  };
  enum class Across { Any, Alike };
  [[nodiscard]] Strip strip(std::int32_t edge, std::int32_t face, Across across) const;
  [[nodiscard]] bool ends_at_walls(std::int32_t edge) const;
  // Whether it is an edge of a chamfer: of a strip that is far narrower than what lies beyond both
  // its edges, one of which ends where four lines meet, among them one that turns by a right
  // angle's two thirds, as walls do. (Solids with bevels all around have none: they are meant to
  // be round.)
  [[nodiscard]] bool bounds_chamfer(std::int32_t edge) const;
  [[nodiscard]] glm::dvec3 middle_of(std::int32_t edge) const;
  [[nodiscard]] glm::dvec3 along(std::int32_t edge) const;

  const PolygonMesh& mesh_;
  const MeshTopology& topology_;
  std::span<const glm::dvec3> normals_;
  std::unordered_map<std::int32_t, Around> hubs_;
};

}  // namespace planish
