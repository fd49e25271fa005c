#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/adaptive/decimate.h"
#include "planish/files/gltf/asset/gltf_asset.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/job/job.h"
#include "planish/job/job_input.h"
#include "planish/job/output_plan.h"
#include "planish/job/report.h"
#include "planish/job/staged_files.h"
#include "planish/measure/vertex_fields.h"
#include "planish/pipeline/bake_maps.h"
#include "planish/pipeline/fit.h"
#include "planish/queries/limit_surface.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/kept_rows.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

/// One level of a job's surface.
class JobLevel {
 public:
  /// Made piece by piece, as often as it is asked for.
  explicit JobLevel(std::unique_ptr<SurfaceBlocks> blocks, Callbacks callbacks)
      : blocks_(std::move(blocks)), callbacks_(std::move(callbacks)) {}
  /// As fine as it has to be.
  JobLevel(std::unique_ptr<const AdaptiveSurface> adaptive, const LimitSurface& lies_on,
           std::optional<DecimationFigures> decimated = std::nullopt);
  /// Of the schemes that make it whole; `mesh` is what was fitted.
  JobLevel(std::unique_ptr<const SurfaceMesh> whole, const PolygonMesh& mesh);

  [[nodiscard]] int level() const { return blocks().info().level; }
  [[nodiscard]] const SurfaceBlocks& blocks() const { return kept_ ? *kept_ : *blocks_; }
  [[nodiscard]] bool is_whole() const { return made_whole_ != nullptr || adaptive_ != nullptr; }
  /// Makes rows and quads once for all who read them from now on: see KeepOptions.
  void keep(const glm::dvec3& origin, QuadVisit visit);
  [[nodiscard]] bool is_kept() const { return kept_ != nullptr; }
  /// How near it is to the surface, where it is decimated.
  [[nodiscard]] const std::optional<DecimationFigures>& decimated() const { return decimated_; }
  /// All of it in memory, for those who need neighbours; collected when first asked for.
  [[nodiscard]] const SurfaceMesh& whole();
  /// Frees what whole() collected, unless that is all that there is.
  void let_go() { collected_.reset(); }

 private:
  std::unique_ptr<const AdaptiveSurface> adaptive_;
  std::optional<DecimationFigures> decimated_;
  std::unique_ptr<const SurfaceMesh> made_whole_, collected_;
  std::unique_ptr<SurfaceBlocks> blocks_, kept_;  // kept_ reads blocks_
  Callbacks callbacks_;
};

/// The surface of a fitted mesh; what its levels share is made once.
class JobSurface {
 public:
  /// All of it must outlive the surface.
  JobSurface(const FittedMesh& fitted, Backend& backend, Callbacks callbacks);

  /// Throws as evaluate(). The surface must outlive its levels.
  [[nodiscard]] JobLevel level(int level);
  /// Throws as tessellate() and decimate().
  [[nodiscard]] JobLevel adaptive(const Fineness& fineness);
  /// Throws as level(). Of Doo-Sabin surfaces.
  [[nodiscard]] const LimitSurface& limit();
  /// What the levels so far were taken from; null before the first, and with other schemes.
  [[nodiscard]] const DooSabinSurface* doo_sabin() const { return doo_sabin_.get(); }
  /// The same, made now where no level was; null with other schemes.
  [[nodiscard]] std::shared_ptr<const DooSabinSurface> made_doo_sabin();

 private:
  const FittedMesh& fitted_;
  Backend& backend_;
  EvaluateOptions options_;
  std::shared_ptr<const DooSabinSurface> doo_sabin_;  // made with the first level
  std::unique_ptr<const LimitSurface> limit_;         // made when first asked for
};

/// A fitted job on its way to its files.
struct FittedJob {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const JobInput& made;
  const FittedMesh& fitted;  ///< what `made` comes to
  JobReport& report;
  StagedFiles& staged;
};

/// Shows a mesh of the job to its page, where there is one.
void show_mesh(const FittedJob& work, std::size_t mesh, JobSurface& all);

/// Writes cages, evaluates every level once, whatever the number of files that show it, and
/// measures the surface; all noted in the report. Shows it to the page. Returns what is meant for
/// stdout.
[[nodiscard]] std::vector<std::byte> write_outputs(const FittedJob& work);

/// The files of a job whose mesh is fitted already. Throws planish::Error.
[[nodiscard]] std::vector<WrittenOutput> write_fitted(const FittedMesh& fitted, Job job,
                                                      PathClaims& claims, Backend& backend,
                                                      const JobWatch& watch);

/// Where distances of points are measured on a tessellation: from this level on it is as good as
/// the surface.
inline constexpr int kPointDistanceLevel = 2;

/// Notes in the report how good a level of the surface is, unless a level before it has: against
/// the source where there is one, else the input; the distances of a cloud's points from
/// kPointDistanceLevel on with schemes that measure_points() does not know. Nothing of it can be
/// seen at level 0. Warns "folded-area". `stored_about`: the origin of rows where a file is made of
/// them next; in the same pass they are kept for it.
void measure_surface(const FittedJob& work, JobLevel& surface,
                     const std::optional<glm::dvec3>& stored_about);

/// The distances of a cloud's points to the surface itself, by closest points.
void measure_points(const FittedJob& work, JobSurface& surface);

/// The distances of the source's vertices to the surface itself; the report must have figures of
/// the surface.
void measure_source(const FittedJob& work, JobSurface& surface);

/// What the choice of the method measured at level 1, as the figures of the surface where no other
/// level has any; false where there is none, or the source is what counts.
[[nodiscard]] bool note_chosen_surface(const FittedJob& work);

/// Notes the bending of kBendingLevel in place of that of the measured level; the report must have
/// figures of the surface.
void note_bending(const FittedJob& work, JobSurface& surface);

/// Notes how far the texture slides, and warns "sliding-texture" where that is farther than anybody
/// would have it; the report must have figures of the surface.
void note_texture_slide(const FittedJob& work, JobSurface& surface);

/// Notes how far sheets that repair separated are from each other on the surface that the report
/// has figures of; nothing where there is none: with other schemes.
void note_sheet_gap(const FittedMesh& fitted, const std::shared_ptr<const DooSabinSurface>& surface,
                    JobReport& report);

/// What every surface output of a job has in common.
struct SurfaceOutputOptions {
  GltfOptions gltf;
  std::span<const glm::dvec3> vertices;        ///< the input's
  std::span<const glm::dvec3> given;           ///< what the surface passes through in their place
  double diagonal = 1.0;                       ///< that errors are relative to
  bool digests = true;                         ///< of what is written
  double tolerance = 0;                        ///< relative, that compression keeps
  const MaterialLibrary* materials = nullptr;  ///< of the input
  bool may_be_scaled = true;                   ///< whether nodes may carry the grid of compression
};

/// Options for writing a surface as glTF, and how far it is off as written: known once it is.
struct MeasuredGltf {
  GltfOptions options;
  double distance = 0;  ///< in model units
};
/// Of one surface of a file. All that is given must outlive what is measured.
void measure_gltf(const PlannedOutput& planned, const SurfaceBlocks& surface,
                  const SurfaceOutputOptions& options, MeasuredGltf& measured);

/// What is known of a file of that surface before it is written.
[[nodiscard]] WrittenOutput counted_output(const PlannedOutput& planned, const SurfaceInfo& info);

/// Writes `surface` to `target` in the format of `planned` and measures what was written; a
/// planned stdout goes to `stdout_bytes` instead. Throws Error{UnwritableOutput}.
[[nodiscard]] WrittenOutput write_surface_output(const PlannedOutput& planned,
                                                 const std::filesystem::path& target,
                                                 JobLevel& surface,
                                                 const SurfaceOutputOptions& options,
                                                 std::vector<std::byte>& stdout_bytes);

/// Writes `surface` as a set of 3D Tiles, whose document is `target`, and measures what was
/// written. `settings` has the sizes of tiles.
[[nodiscard]] WrittenOutput write_tiles_output(const PlannedOutput& planned,
                                               const std::filesystem::path& target,
                                               const DooSabinSurface& surface,
                                               const Settings& settings,
                                               const SurfaceOutputOptions& options);

/// Writes the cage of a fitted mesh, with the materials of the input, and measures how far its
/// limit surface, recomputed in double from what is written, is from the mesh's vertices. The
/// options are those of surfaces beside it.
[[nodiscard]] WrittenOutput write_cage_output(const PlannedOutput& planned,
                                              const std::filesystem::path& target,
                                              const FittedMesh& whole, const JobReport& report,
                                              const SurfaceOutputOptions& options);

/// What all files of a job's surface have in common.
[[nodiscard]] SurfaceOutputOptions surface_options(const FittedJob& work);

/// Every fineness that a file of a surface has, but of tiles and of levels of detail in one, once.
[[nodiscard]] std::vector<Fineness> finenesses_of(const std::vector<PlannedOutput>& outputs);

/// A level, measured for the report.
[[nodiscard]] JobLevel measured_level(const FittedJob& work, JobSurface& surface, int level,
                                      const SurfaceOutputOptions& options);

/// What the fields of a surface's files are held by.
struct LevelFields {
  VertexFields figures;                     ///< that the job wants as data
  std::vector<VertexAttribute> attributes;  ///< that the mesh has
};

/// The surface of that fineness, measured where it is a level. The options get what its files say
/// of it, and the fields, which `fields` holds.
[[nodiscard]] JobLevel surface_of(const FittedJob& work, JobSurface& all, const Fineness& fineness,
                                  LevelFields& fields, SurfaceOutputOptions& options);

/// Figures that a job's report wants and that cannot be seen on its cage or at level 0.
void measure_rest(const FittedJob& work, JobSurface& all, const SurfaceOutputOptions& common);

/// A tolerance finer than float32 holds in the solve but not in a glTF file.
void warn_of_rounding(JobReport& report, const JobContext& context, const WrittenOutput& output);

/// Files of a level that nobody named that are large, and many times as large as the input.
void warn_of_size(JobReport& report, std::uint64_t input_bytes, const JobContext& context);

/// Surfaces of a job that bakes are of level 0, where nobody named one. Throws
/// Error{InvalidArgument} for other levels.
void settle_bake(Job& job);

/// Refuses outputs that hold no baked map with Error{InvalidArgument}.
void require_bakeable(const std::vector<PlannedOutput>& outputs);

/// The maps of a job's surface, of which `low` is level 0; null where it wants none.
[[nodiscard]] std::unique_ptr<const BakedSurface> baked_surface(const FittedJob& work,
                                                                JobSurface& all,
                                                                const JobLevel& low,
                                                                const GltfOptions& gltf);

/// The same of a mesh of an asset.
[[nodiscard]] std::unique_ptr<const BakedAssetMesh> baked_mesh(const FittedJob& work,
                                                               const GltfAsset& asset,
                                                               const AssetMesh& mesh,
                                                               JobSurface& all, const JobLevel& low,
                                                               const AssetAttributes& attributes);

/// Notes them in the report of an output. `mesh`: its name, of an asset.
void note_maps(std::span<const BakedMap> maps, const std::string& mesh, int size,
               WrittenOutput& written);

/// Why a glTF's scene becomes one mesh: the reason, empty where the settings say so; nothing: it
/// stays an asset.
[[nodiscard]] std::optional<std::string> reason_to_merge(const Job& job,
                                                         const std::vector<PlannedOutput>& outputs);

/// For jobs that keep no asset: throws Error{InvalidArgument} where a file is to have several
/// levels of detail.
void require_asset_for_lods(const std::vector<PlannedOutput>& outputs);

/// Refuses options of parts with Error{InvalidArgument} where the asset has no part of the name,
/// which says what names there are, where they contradict a mesh's others, or where a part has a
/// level and outputs have several.
void require_parts(const GltfAsset& asset, const Settings& settings,
                   const std::vector<PlannedOutput>& outputs);

/// The asset that a job's input is, where the job keeps it: a glTF with triangles all of whose
/// outputs are glTF surfaces. Warns "merged-asset" where that alone is missing. Null: the scene
/// becomes one mesh. Throws Error{UnreadableInput}, as require_asset_for_lods().
[[nodiscard]] std::unique_ptr<const GltfAsset> kept_asset(const Job& job,
                                                          const std::vector<PlannedOutput>& outputs,
                                                          const InputFile& file, JobReport& report,
                                                          const JobContext& context);

/// Runs a step of a mesh of the asset, by its number. False, with the warning "kept-mesh", for one
/// of several that no surface can be made of: it stays as it is.
[[nodiscard]] bool try_mesh(const GltfAsset& asset, std::int64_t number,
                            const std::function<void(const Warning&)>& warn,
                            const std::function<void()>& step);

/// Throws Error{UnusableMesh} where surfaces of none are left.
void require_any(const GltfAsset& asset, std::size_t count);

/// An asset on its way to its files. `file` holds its bytes.
struct AssetJob {
  const Job& job;
  const std::vector<PlannedOutput>& outputs;
  Backend& backend;
  const JobContext& context;
  const InputFile& file;
  const GltfAsset& asset;
  JobReport& report;
  StagedFiles& staged;
};

struct AssetResult {
  std::vector<std::byte> stdout_bytes;
  std::vector<FittedMesh> fitted;
};

/// Fits every mesh of the asset by itself, in its own coordinates, and writes the asset with their
/// surfaces. A mesh of several that no surface can be made of stays as it is, with the warning
/// "kept-mesh". The report of one mesh is the job's; those of several stand in JobReport::meshes.
/// Throws planish::Error.
[[nodiscard]] AssetResult run_asset(const AssetJob& work);

}  // namespace planish
