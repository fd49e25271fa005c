#pragma once

#include <span>
#include <string>
#include <string_view>

#include "planish/job/given_setting.h"
#include "planish/job/job_settings.h"

namespace planish::command {

/// An option of `planish fit`, `planish run` or a scene file: by its name there, with '_' for '-'.
enum class MpiOption { Taken, SomeWords, Refused };

/// What planish-mpi makes of it. One that it has not heard of is refused.
[[nodiscard]] MpiOption mpi_option(std::string_view name);

/// The words of it that are taken, "chebyshev|plain"; empty where that is all or nothing.
[[nodiscard]] std::string words_taken(std::string_view name);

/// Throws Error{InvalidArgument}, `where: value is not available in planish-mpi: remedy`, for the
/// first that is refused. Of settings that were given twice the later one counts. `settings` is
/// what all of them came to.
void require_available(std::span<const GivenSetting> given, const FitSettings& settings);

}  // namespace planish::command
