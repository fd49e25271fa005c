#pragma once

namespace planish {

/// How the surface comes to pass through the given vertices.
enum class InterpolationMethod {
  Progressive,  ///< the paper's: control points of the mesh are moved until it does
  Fair,         ///< control points of level 1 are built to do so, without folds on uneven meshes
};

}  // namespace planish
