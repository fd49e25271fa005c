#pragma once

#include <span>
#include <string>
#include <string_view>

#include "planish/reconstruct/reconstruct.h"

namespace planish::command {

/// One setting of how points become a mesh: a flag of `fit` and `reconstruct`, a key of a scene
/// file. The flag is `--name` with '_' as '-'.
struct PointSetting {
  std::string_view name;     ///< as in a scene file
  std::string_view choices;  ///< for the help text
  std::string_view initial;  ///< the default, for the help text
  std::string_view help;
  bool is_number;  ///< a scene file may give it as a JSON number
  /// Throws Error{InvalidArgument}: `where` names the place, then the value and what is allowed.
  void (*set)(ReconstructOptions& options, std::string_view value, std::string_view where);
};

[[nodiscard]] std::span<const PointSetting> point_settings();

/// "--tolerance-mesh" of "tolerance_mesh".
[[nodiscard]] std::string flag_of(std::string_view setting);

}  // namespace planish::command
