#pragma once

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// Rocker arm of an engine, y up: a bored hub along z, a ribbed arm to a boss with a blind socket
/// for the push rod, another down to the valve pad. Quads only, genus 1, about 14,000 vertices.
[[nodiscard]] PolygonMesh rocker_arm();

}  // namespace planish::shapes
