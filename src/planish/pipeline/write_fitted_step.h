#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "planish/brep/brep.h"
#include "planish/brep/write_step.h"
#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/queries/limit_surface.h"

namespace planish {

struct GltfMaterials;  // materials.h

/// How a surface becomes STEP.
struct StepSettings {
  BrepOptions faces;
  StepUnit unit = StepUnit::OfInput;
};

/// What a unit is for coordinates of a file of that format: "glb".
[[nodiscard]] StepUnit settled_unit(StepUnit unit, std::string_view format);

/// What became of it.
struct StepFigures {
  std::uint64_t byte_count = 0;
  StepUnit unit = StepUnit::Millimetre;
  std::int64_t faces = 0, edges = 0, vertices = 0, control_points = 0;
  std::int64_t planes = 0;  ///< of the faces
  std::int64_t solids = 0, voids = 0, open_shells = 0;
  std::int64_t extraordinary = 0;  ///< see Brep, as the next three
  int deepest = 0;
  double max_angle = 0, max_deviation = 0;
  Brep::Spot max_angle_at, max_deviation_at;
  BrepCheck check;              ///< of the faces and edges that are written
  bool keeps_limits = true;     ///< max_angle and max_deviation are within the settings
  bool keeps_wishes = true;     ///< and where not, the limit is the one that nobody has set
  double largest_distance = 0;  ///< of FittedMesh::points() from their places, in model units

  /// Shells are valid, and limits that somebody has set are kept: else commands end with 5.
  [[nodiscard]] bool is_as_asked() const { return check.is_valid() && keeps_wishes; }
};

struct StepFileOptions {
  StepSettings settings;
  std::string name = "surface";   ///< of file and product
  std::filesystem::path shown{};  ///< what warnings call the file; empty: its path
  /// Of the mesh's groups, whose colours faces get; null: none.
  const GltfMaterials* materials = nullptr;
  /// Gets all bytes in order while they are written: for a digest.
  std::function<void(std::span<const std::byte>)> observe;
  /// Steps "faces" and "write"; warnings "step-folds", "step-inside-out", "step-faces",
  /// "step-invalid", "step-spans", "step-limits" and "lost-attributes".
  Callbacks callbacks;
};

/// Programs take minutes with more faces.
constexpr std::int64_t kManyStepFaces = 5000;
constexpr double kShortStepSpan = 1e-3;  ///< millimetres, below which they may take it for nothing

/// Writes the Doo-Sabin surface of a fitted mesh as STEP; `limit` is its. Where the fit did not
/// converge, or the settings' limits are not kept, the file's description says so. Throws as
/// make_brep() and write_step().
StepFigures write_fitted_step(const std::filesystem::path& path, const FittedMesh& fitted,
                              const LimitSurface& limit, const StepFileOptions& options);
/// The same of a surface that is made for it, Catmull-Clark's too. Throws as CatmullClarkSplines,
/// too, and Error{InvalidArgument} for Loop.
StepFigures write_fitted_step(const std::filesystem::path& path, const FittedMesh& fitted,
                              const StepFileOptions& options);

/// "near (1, 2, 3) in face 4".
[[nodiscard]] std::string words_of(const Brep::Spot& spot);

/// Throws Error{InvalidArgument} where surfaces of the scheme do not become STEP.
void require_step_scheme(Scheme scheme, std::string_view where);

}  // namespace planish
