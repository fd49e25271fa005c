#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "job/input.h"
#include "options/settings.h"
#include "planish/backend/backend.h"

namespace planish::command {

struct VerifyOptions {
  InterpolationMethod interpolation = InterpolationMethod::Progressive;
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  BoundaryRule boundary = BoundaryRule::Edge;
  CreaseChoice creases;
  RepairChoice repair = RepairChoice::Safe;
  std::optional<double> weld;
  std::vector<std::int32_t> smoothed_vertices;  ///< see CageHeader
  double tolerance = 1e-6;
};

/// How far the given vertices are from the cage's limit surface, as fractions of the given mesh's
/// bounding-box diagonal.
struct Verification {
  ErrorNorms error;
  std::int64_t worst_vertex = -1;
  std::int64_t vertex_count = 0;
  bool confirmed = false;  ///< error.max is at most the tolerance
};

/// Evaluates the cage's limit points in double on the CPU and compares them with the given
/// vertices. Progressive: these are the cage's first ones. Fair: the cage is the mesh of level 1,
/// see level_one_mesh(). Formats without crease tags (all but OBJ) take those of the given mesh,
/// prepared as the options say. Throws Error{UnusableMesh} for a cage that is no cage of the given
/// mesh: other numbers of vertices, or other faces.
[[nodiscard]] Verification verify(const Input& cage, const Input& given,
                                  const VerifyOptions& options);

}  // namespace planish::command
