#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace planish {

/// One of a job's "moves", which come after its fit: vertices of the input to positions, or by an
/// affine map; or moves that are taken back.
struct SceneMove {
  std::string where;                   ///< in its scene file
  std::vector<std::int32_t> vertices;  ///< of the input, from 0
  std::vector<glm::dvec3> to;          ///< one a vertex; empty: the map moves them
  glm::dmat4 map{1.0};
  double radius = 0;      ///< above 0: those around them move along, see select_around()
  std::int64_t undo = 0;  ///< above 0: so many moves are taken back, and nothing else
};

}  // namespace planish
