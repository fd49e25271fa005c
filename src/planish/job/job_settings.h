#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "planish/core/option.h"
#include "planish/pipeline/settings.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

/// Everything that can be set for one job, by flags of `fit` or keys of a scene file: the rows of
/// option_table() and point_option_table().
struct Settings : FitSettings {
  ReconstructOptions points;  ///< how a point cloud becomes a mesh
};

/// A name of option_table() or point_option_table() and a text that its flag takes.
using NamedSetting = std::pair<std::string_view, std::string_view>;

/// The row of either table; null: there is none.
[[nodiscard]] const OptionInfo* find_setting(std::string_view name);

/// Whether a row says what becomes of files and points that are read: meshes in memory are none.
[[nodiscard]] bool is_of_inputs(const OptionInfo& option);

/// "--chord-error" of "chord_errors"; a name that is none as it is.
[[nodiscard]] std::string flag_of_setting(std::string_view name);

/// Sets what is given in the order of the tables, whatever its own: a preset first. Throws
/// Error{InvalidArgument} for names that are none and for values, spelled by `spell`.
void apply_settings(std::span<const NamedSetting> given, Settings& settings,
                    SpellOption spell = flag_of_setting);

/// The defaults but for what is given. Throws as apply_settings() and check_consistent().
[[nodiscard]] Settings settings_of(std::span<const NamedSetting> given,
                                   SpellOption spell = flag_of_setting);
[[nodiscard]] Settings settings_of(std::initializer_list<NamedSetting> given);

// Stable names, as given in flags and written in reports.
[[nodiscard]] std::string_view name_of(Scheme scheme);
[[nodiscard]] std::string_view name_of(Weights weights);
[[nodiscard]] std::string_view name_of(InterpolationMethod method);
[[nodiscard]] std::string_view name_of(Solver solver);
[[nodiscard]] std::string_view name_of(BoundaryRule boundary);

/// The subdivision for people: "doo-sabin weights", "averaged weights", "catmull-clark", "loop".
[[nodiscard]] std::string subdivision_text(Scheme scheme, Weights weights);

}  // namespace planish
