#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/core/option.h"
#include "planish/pipeline/found_creases.h"
#include "planish/pipeline/settings.h"

namespace planish {

/// What a cage says about how it was made, so that `verify` needs no flags.
struct CageHeader {
  /// The defaults where it says nothing, of the progressive method.
  FitSettings settings{.interpolation = InterpolationChoice::Progressive, .creases = {}};
  std::optional<FoundCreases> found;  ///< of the prepared mesh
  std::string source;                 ///< file name of the input; may be empty
};

/// Comment lines "planish key=value" for MeshWriteOptions: what shapes the surface, the tolerance
/// and the input's file name.
[[nodiscard]] std::vector<std::string> cage_header_lines(FitSettings settings,
                                                         InterpolationMethod method,
                                                         const std::string& source,
                                                         const FoundCreases& found = {});

/// Reads them back; a leading comment sign is allowed. Keys that are not known are left to newer
/// versions. Throws Error{UnreadableInput} naming `name` for a known key whose value is none.
[[nodiscard]] CageHeader parse_cage_header(std::span<const std::string> lines,
                                           const std::string& name);

/// Whether cages say it: the same options are flags of `verify`.
[[nodiscard]] bool is_of_cages(const OptionInfo& option);

/// Throws Error{InvalidArgument} for the method auto: a cage was made by one of the others.
void require_known_method(const FitSettings& settings, std::string_view where);

}  // namespace planish
