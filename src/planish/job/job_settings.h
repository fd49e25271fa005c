#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/option.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/settings.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

/// A setting as it was given: its name as in a scene file, the place ("--solver",
/// "scene.json:9: jobs[0].solve.solver") and the value as text.
struct GivenSetting {
  std::string name, where, value;
};

/// One of a job's "moves", which come after its fit: vertices of the input to positions, or by an
/// affine map; or moves that are taken back.
struct SceneMove {
  std::string where;                   ///< in its scene file
  std::vector<std::int32_t> vertices;  ///< of the input, from 0
  std::vector<glm::dvec3> to;          ///< one a vertex; empty: the map moves them
  glm::dmat4 map{1.0};
  double radius = 0;      ///< above 0: those around them move along, see select_around()
  std::int64_t undo = 0;  ///< above 0: so many moves are taken back, and nothing else
};

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
