#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "planish/core/option.h"
#include "planish/pipeline/settings.h"

namespace planish {

using FitOption = Option<FitSettings>;

/// Everything that can be set for a mesh, one row each, in the order in which it has to be set: a
/// preset first, so that others override it. A new option is a member of FitSettings, a row here
/// and what it does.
[[nodiscard]] const std::vector<FitOption>& option_table();

/// The row of that name, which has to exist.
[[nodiscard]] const FitOption& fit_option(std::string_view name);

/// What an option of that name is set to, as it may be given.
[[nodiscard]] std::string option_text(const FitSettings& settings, std::string_view name);

}  // namespace planish
