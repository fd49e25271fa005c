#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/backend/cpu_backend.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/pipeline/fit.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/vertex_fields.h"

namespace planish::command {

enum class PrecisionChoice { Auto, Float, Double };
enum class UpAxis { Y, Z };
enum class RepairChoice { None, Safe };
/// Auto: fair for point clouds; of meshes the better one by measurement, and progressive where a
/// cage is wanted.
enum class InterpolationChoice { Auto, Progressive, Fair };

/// Which edges and vertices are sharp besides boundaries.
struct CreaseChoice {
  bool use_tags = true;                    ///< those that the file tags
  std::optional<double> dihedral_degrees;  ///< and those whose faces turn by more
  bool split_normals = false;              ///< and those where the file splits its normals
};

/// Surfaces as fine as they have to be, instead of levels.
struct AdaptiveChoice {
  std::vector<double> chord_errors;  ///< of the diagonal; several are levels of detail
  double angle = 0;                  ///< degrees; 0: any

  [[nodiscard]] bool any() const { return !chord_errors.empty() || angle > 0; }
};

/// Everything that can be set for one job, by flags of `fit` or keys of a scene file.
struct Settings {
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  InterpolationChoice interpolation = InterpolationChoice::Auto;
  std::int32_t polish_steps = 8;
  Solver solver = Solver::Chebyshev;
  double tolerance = 1e-6;
  std::int32_t max_iterations = 200;
  PrecisionChoice precision = PrecisionChoice::Auto;
  BoundaryRule boundary = BoundaryRule::Edge;
  CreaseChoice creases;
  RepairChoice repair = RepairChoice::Safe;
  std::optional<double> weld;            ///< vertices within this fraction of the diagonal, first
  std::vector<CreaseEdge> crease_edges;  ///< of a scene file, besides the input's own tags
  std::vector<CornerVertex> corner_vertices;
  UpAxis up = UpAxis::Y;
  FieldChoice attributes;  ///< that surfaces carry as data
  GltfCompression compression = GltfCompression::None;
  std::int64_t tile_vertices = 262'144;  ///< about so many has a file of 3D Tiles
  bool skirts = false;                   ///< along the boundaries of tiles
  std::string device = "auto";
  std::vector<int> levels{2};
  AdaptiveChoice adaptive;
  ReconstructOptions points{.measure_noise = true};  ///< how a point cloud becomes a mesh

  /// Of a mesh that prepare() made, which has no tags but those that count.
  [[nodiscard]] SharpFeatureOptions sharp() const { return {boundary, true}; }
};

/// Options of a fit with the settings, but for what the settings leave open and whom it answers.
[[nodiscard]] FitOptions fit_options(const Settings& settings, InterpolationMethod method);

/// One setting that is given as a word. The flag is `--name` with '_' as '-'.
struct WordSetting {
  std::string_view name;     ///< as in a scene file
  std::string_view choices;  ///< for the help text
  std::string_view initial;  ///< the default, for the help text
  std::string_view help;
  bool belongs_to_solve;  ///< may stand in a scene file's "solve"
  /// Throws Error{InvalidArgument}: `where` ("--weights", "scene.json: jobs[0].weights") names
  /// the place, then the value, what is allowed and the nearest of it.
  void (*set)(Settings& settings, std::string_view value, std::string_view where);
};

/// In the order in which they have to be set: a preset first, so that others override it.
[[nodiscard]] std::span<const WordSetting> word_settings();

// Settings that are numbers; the same errors. As text: of a flag.
void set_tolerance(Settings& settings, double value, std::string_view where);
void set_tolerance(Settings& settings, std::string_view text, std::string_view where);
[[nodiscard]] std::int64_t parse_whole(std::string_view text, std::string_view where);
void set_max_iterations(Settings& settings, std::int64_t value, std::string_view where);
void set_polish_steps(Settings& settings, std::int64_t value, std::string_view where);
void set_weld(Settings& settings, double value, std::string_view where);
void set_weld(Settings& settings, std::string_view text, std::string_view where);
void set_tile_vertices(Settings& settings, std::int64_t value, std::string_view where);
/// Each 0 to kMaxLevel, none twice, at least one.
[[nodiscard]] std::vector<int> checked_levels(std::span<const std::int64_t> values,
                                              std::string_view where);

/// Each above 0 and at most 1, none twice, at least one.
[[nodiscard]] std::vector<double> checked_chord_errors(std::span<const double> values,
                                                       std::string_view where);
/// Above 0 and at most 180 degrees.
[[nodiscard]] double checked_angle(double value, std::string_view where);
/// A list of numbers between commas.
[[nodiscard]] std::vector<double> parse_numbers(std::string_view text, std::string_view where);

/// Throws Error{InvalidArgument} where settings contradict each other, as far as that can be told
/// before a device is open.
void check_consistent(const Settings& settings);

/// What the CPU solves in: as chosen; auto takes double for tolerances below 1e-8.
[[nodiscard]] Precision solve_precision(const Settings& settings);

// Stable names, as given in flags and written in reports.
[[nodiscard]] std::string_view name_of(Scheme scheme);
[[nodiscard]] std::string_view name_of(Weights weights);
[[nodiscard]] std::string_view name_of(InterpolationMethod method);
[[nodiscard]] std::string_view name_of(Solver solver);
[[nodiscard]] std::string_view name_of(BoundaryRule boundary);
[[nodiscard]] std::string name_of(const CreaseChoice& creases);
[[nodiscard]] std::string_view name_of(RepairChoice repair);
[[nodiscard]] std::string_view name_of(GltfCompression compression);

/// The subdivision for people: "doo-sabin weights", "averaged weights", "catmull-clark", "loop".
[[nodiscard]] std::string subdivision_text(Scheme scheme, Weights weights);

/// Shared by the flags of `fit` and `verify`. Same errors as WordSetting::set.
[[nodiscard]] Scheme parse_scheme(std::string_view value, std::string_view where);
[[nodiscard]] Weights parse_weights(std::string_view value, std::string_view where);
[[nodiscard]] InterpolationMethod parse_method(std::string_view value, std::string_view where);
[[nodiscard]] BoundaryRule parse_boundary(std::string_view value, std::string_view where);
[[nodiscard]] CreaseChoice parse_creases(std::string_view value, std::string_view where);
[[nodiscard]] RepairChoice parse_repair(std::string_view value, std::string_view where);

}  // namespace planish::command
