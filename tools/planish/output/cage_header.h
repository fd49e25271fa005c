#pragma once

#include <cstdint>
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
  std::optional<double> tolerance, weld;
  /// Of the prepared mesh: where creases were found and taken back, ascending.
  std::vector<std::int32_t> smoothed_vertices;
  std::optional<std::string> source;  ///< file name of the input
};

/// Comment lines "planish key=value" for MeshWriteOptions, of the input's file name too.
[[nodiscard]] std::vector<std::string> cage_header_lines(
    const Settings& settings, InterpolationMethod method, const std::string& source,
    std::span<const std::int32_t> smoothed_vertices = {});

/// Reads them back; a leading comment sign is allowed. Keys that are not known are left to newer
/// versions. Throws Error{UnreadableInput} naming `name` for a known key whose value is none.
[[nodiscard]] CageHeader parse_cage_header(std::span<const std::string> lines,
                                           const std::string& name);

}  // namespace planish::command
