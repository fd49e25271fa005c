#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/adaptive/decimate.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/measure/vertex_fields.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/part_settings.h"
#include "planish/pipeline/verify_cage.h"
#include "planish/pipeline/write_fitted_step.h"
#include "planish/solve/backend.h"

namespace planish {

enum class PrecisionChoice { Auto, Float, Double };
enum class UpAxis { Y, Z };
enum class RepairChoice { None, Safe };
/// A glTF that becomes one: with all that it holds, or one mesh of its scene.
enum class AssetChoice { Keep, Merge };
/// Several levels of detail: a file each, or one glTF by MSFT_lod.
enum class LodChoice { Files, Msft };
/// Auto: fair for point clouds; of meshes the better one by measurement, and progressive where a
/// cage is wanted.
enum class InterpolationChoice { Auto, Progressive, Fair };

/// Which edges and vertices are sharp besides boundaries.
struct CreaseChoice {
  bool use_tags = true;                    ///< those that the file tags
  bool finds_features = false;             ///< and those that find_features() finds
  std::optional<double> dihedral_degrees;  ///< and those whose faces turn by more
  bool split_normals = false;              ///< and those where the file splits its normals
  bool chooses = false;                    ///< finds features where nothing is tagged
};

/// How far the surface may leave the given vertices to bend less.
struct WithinChoice {
  std::optional<double> of_diagonal;  ///< empty: not at all
  bool is_measured = false;           ///< by the noise
};

/// Surfaces as fine as they have to be, instead of levels: by a chord error, an angle or both, or
/// decimated to one of the others. Several of a list are levels of detail.
struct AdaptiveChoice {
  std::vector<double> chord_errors;  ///< of the diagonal
  double angle = 0;                  ///< degrees; 0: any
  std::vector<std::int64_t> faces;   ///< triangles of a file, at most
  std::vector<double> edge_lengths;  ///< in the input's unit
  std::vector<double> distances;     ///< of the diagonal: pixels of a view's

  [[nodiscard]] bool any() const { return !kinds().empty(); }
  /// The options that are given, of which a surface has one: "chord_errors", which an angle may be
  /// beside, "angle", "faces", "edge_lengths", "pixels".
  [[nodiscard]] std::vector<std::string_view> kinds() const;
  /// How many levels of detail they are; 0 where there is none of them.
  [[nodiscard]] std::size_t count() const;
  /// Of faces, edge lengths or distances.
  [[nodiscard]] std::vector<DecimationTarget> targets() const;
};

/// What option_table() is the table of: everything that can be set for one mesh, wherever.
struct FitSettings {
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  InterpolationChoice interpolation = InterpolationChoice::Auto;
  std::int32_t polish_steps = 8;
  Solver solver = Solver::Chebyshev;
  double tolerance = 1e-6;
  std::int32_t max_iterations = 200;
  PrecisionChoice precision = PrecisionChoice::Auto;
  BoundaryRule boundary = BoundaryRule::Edge;
  CreaseChoice creases{.chooses = true};
  RepairChoice repair = RepairChoice::Safe;
  WithinChoice within;
  QuadChoice quads = QuadChoice::Auto;  ///< points: on
  RefineChoice refine = RefineChoice::Auto;
  std::optional<double> weld;            ///< vertices within this fraction of the diagonal, first
  std::vector<CreaseEdge> crease_edges;  ///< of a scene file, besides the input's own tags
  std::vector<CornerVertex> corner_vertices;
  UpAxis up = UpAxis::Y;
  FieldChoice attributes;             ///< that surfaces carry as data
  std::optional<Scheme> cage_scheme;  ///< of control cages; empty: the surface's
  AssetChoice asset = AssetChoice::Keep;
  LodChoice lods = LodChoice::Files;
  std::vector<PartSetting> parts;          ///< of meshes of an asset, instead of these
  FileReach textures = FileReach::Beside;  ///< of files that the input names
  GltfCompression compression = GltfCompression::None;
  int bake = 0;                          ///< texels along a side of baked maps; 0: none
  std::int64_t tile_vertices = 262'144;  ///< about so many has a file of 3D Tiles
  bool skirts = false;                   ///< along the boundaries of tiles
  StepSettings step;
  std::string device = "auto";
  std::vector<int> levels{2};
  bool levels_by_density = true;  ///< then 2 is the most: see MeshDensity
  AdaptiveChoice adaptive;

  /// Levels that are named, which no density lessens.
  void set_levels(std::vector<int> given) {
    levels = std::move(given);
    levels_by_density = false;
  }
  /// Of a mesh that make_ready() made, which has no tags but those that count.
  [[nodiscard]] SharpFeatureOptions sharp() const { return {boundary, true}; }
};

/// What they come to for the functions of the pipeline.
[[nodiscard]] MeshFitOptions mesh_fit_options(const FitSettings& settings);
/// Of a mesh that make_ready() made.
[[nodiscard]] FitOptions fit_options(const FitSettings& settings, InterpolationMethod method);
/// The method auto is progressive here.
[[nodiscard]] VerifyOptions verify_options(const FitSettings& settings);
/// What the CPU solves in: as chosen; auto takes double for tolerances that float does not reach.
[[nodiscard]] Precision solve_precision(const FitSettings& settings);

/// How whoever gives settings spells them: "--weights", "options.weights".
using SpellOption = std::string (*)(std::string_view name);
/// "--chord-error" of "chord_errors".
[[nodiscard]] std::string flag_of_option(std::string_view name);

/// Throws Error{InvalidArgument} where settings contradict each other, as far as that can be told
/// without a mesh and a device.
void check_consistent(const FitSettings& settings, SpellOption spell = flag_of_option);

/// What was left open as it was taken for a fit, but the method.
void settle(FitSettings& settings, const FittedMesh& fitted);

}  // namespace planish
