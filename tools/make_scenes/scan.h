#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "make_scenes/surface_nets.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/triangles.h"

namespace planish::shapes {

enum class Sampling { Uniform, PoissonDisk };

struct ScanOptions {
  Sampling sampling = Sampling::Uniform;
  std::int32_t point_count = 200'000;
  double tolerance = 1e-4;  ///< of simplification, a fraction of the diagonal; 0 keeps every point
  double least_angle = -1;  ///< of its triangles, as in SimplifyOptions
  bool pair_quads = false;
  std::uint32_t seed = 1;
};

/// What a scanner and planish make of a shape: its surface sampled, every point moved onto the zero
/// set of `field` if there is one and rounded to 1e-6, the points meshed and simplified. Uneven
/// triangles, as simplification leaves them. Throws as reconstruct().
[[nodiscard]] PolygonMesh scan(const PolygonMesh& shape, const Field& field, const Mesher& mesher,
                               const ScanOptions& options = {});

/// The rocker arm scanned: a scene that needs a mesher, and changes with the simplifier.
inline constexpr const char* kScanFile = "rocker_arm_scan.obj";
[[nodiscard]] PolygonMesh scanned_rocker_arm(const Mesher& mesher);

}  // namespace planish::shapes
