#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "options/settings.h"

namespace planish::command {

/// What a cage says about how it was made, so that `verify` needs no flags.
struct CageHeader {
  std::optional<InterpolationMethod> interpolation;
  std::optional<Scheme> scheme;
  std::optional<Weights> weights;
  std::optional<BoundaryRule> boundary;
  std::optional<CreaseChoice> creases;
  std::optional<RepairChoice> repair;
  std::optional<double> tolerance;
  std::optional<std::string> source;  ///< file name of the input
};

/// Comment lines "planish key=value" for MeshWriteOptions. Source: the input's file name.
[[nodiscard]] std::vector<std::string> cage_header_lines(const Settings& settings,
                                                         InterpolationMethod method,
                                                         const std::string& source);

/// Reads them back; a leading comment sign is allowed. Keys that are not known are left to newer
/// versions. Throws Error{UnreadableInput} naming `name` for a known key whose value is none.
[[nodiscard]] CageHeader parse_cage_header(std::span<const std::string> lines,
                                           const std::string& name);

}  // namespace planish::command
