#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "job/input.h"
#include "options/settings.h"
#include "planish/pipeline/verify_cage.h"

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

/// verify_cage(). Formats without crease tags (all but OBJ) take those of the given mesh. Throws as
/// that.
[[nodiscard]] Verification verify(const Input& cage, const Input& given,
                                  const VerifyOptions& options);

}  // namespace planish::command
