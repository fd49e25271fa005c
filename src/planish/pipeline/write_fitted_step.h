#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/brep/brep.h"
#include "planish/brep/write_step.h"
#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/queries/limit_surface.h"

namespace planish {

struct GltfMaterials;  // materials.h

/// Whether faces on planes, cylinders, cones, spheres and tori are written as such.
enum class AnalyticChoice : std::uint8_t { Auto, Off };

constexpr double kMostAnalyticTolerance = 0.1;

/// How a surface becomes STEP.
struct StepSettings {
  BrepOptions faces;
  AnalyticChoice analytic = AnalyticChoice::Auto;
  /// Of vertices from such surfaces, of the diagonal; empty: see find_analytic_parts().
  std::optional<double> analytic_tolerance{};
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
  /// Those of parts that planes, cylinders, cones, spheres and tori make up, by kind.
  std::array<std::int64_t, kAnalyticKinds> analytic{};
  std::vector<double> radii;  ///< theirs, distinct ones, ascending
  std::int64_t analytic_parts = 0, mixed_parts = 0, freeform_parts = 0;
  std::string freeform_reason;   ///< why the first freeform part is, where they were looked for
  double analytic_distance = 0;  ///< of given vertices from analytic faces, in model units
  std::int64_t solids = 0, voids = 0, open_shells = 0;
  std::int64_t extraordinary = 0;  ///< see Brep, as the next three
  int deepest = 0;
  double max_angle = 0, max_deviation = 0;
  Brep::Spot max_angle_at, max_deviation_at;
  BrepCheck check;           ///< of the faces and edges that are written
  bool keeps_limits = true;  ///< max_angle and max_deviation are within the settings
  bool keeps_wishes = true;  ///< and where not, the limit is the one that nobody has set
  /// Of FittedMesh::points() from their places, and of vertices from analytic faces, in model
  /// units.
  double largest_distance = 0;

  /// Shells are valid, and limits that somebody has set are kept: else commands end with 5.
  [[nodiscard]] bool is_as_asked() const { return check.is_valid() && keeps_wishes; }
};

struct StepFileOptions {
  StepSettings settings;
  std::string name = "surface";   ///< of file and product
  std::filesystem::path shown{};  ///< what warnings call the file; empty: its path
  /// Of the mesh's groups, whose colours faces get; null: none.
  const GltfMaterials* materials = nullptr;
  /// Of points, the triangles through all of them, in which analytic faces are looked for; null:
  /// the fitted mesh's.
  const PolygonMesh* scan = nullptr;
  /// Gets all bytes in order while they are written: for a digest.
  std::function<void(std::span<const std::byte>)> observe;
  /// Steps "faces" and "write"; warnings "step-folds", "step-inside-out", "step-faces",
  /// "step-invalid", "step-spans", "step-limits" and "lost-attributes".
  Callbacks callbacks;
};

/// Programs take minutes with more faces.
constexpr std::int64_t kManyStepFaces = 5000;
constexpr double kShortStepSpan = 1e-3;  ///< millimetres, below which they may take it for nothing

/// Writes the surface of a fitted mesh as STEP, with the faces that its mesh has on analytic
/// surfaces (see make_analytic_faces()). `limit` makes the fit's Doo-Sabin surface where it is
/// wanted; empty: it is made here. Where the fit did not converge, or the settings' limits are not
/// kept, the file's description says so. Throws as make_brep(), write_step() and
/// CatmullClarkSplines, and Error{InvalidArgument} for Loop.
StepFigures write_fitted_step(const std::filesystem::path& path, const FittedMesh& fitted,
                              const StepFileOptions& options,
                              const std::function<const LimitSurface&()>& limit = {});

/// "near (1, 2, 3) in face 4".
[[nodiscard]] std::string words_of(const Brep::Spot& spot);

/// Throws Error{InvalidArgument} where surfaces of the scheme do not become STEP.
void require_step_scheme(Scheme scheme, std::string_view where);

}  // namespace planish
