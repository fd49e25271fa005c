#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// A thing as a technical artist has it.
struct Prop {
  std::string name;
  std::int32_t segments;  ///< around the largest of what is round in it
  /// Coarse at 1, which is the prop; its true shape at n has n times as many segments.
  std::function<PolygonMesh(std::int32_t fineness)> make;
};

/// Props of games, furniture, buildings and vehicles; and parts of machines. What is round in a
/// fine one is round, what is sharp there is sharp; polygons of up to six sides stay as they are.
/// Where parts of a thing meet, they cross or stand apart: faces that lie on each other would have
/// the normals of either.
[[nodiscard]] std::vector<Prop> game_props();
[[nodiscard]] std::vector<Prop> machine_props();

}  // namespace planish::quality
