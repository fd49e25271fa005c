#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/adaptive/decimate.h"
#include "planish/job/job_settings.h"
#include "planish/job/output_plan.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/write_fitted_step.h"
#include "planish/reconstruct/reconstruct.h"
#include "planish/solve/backend.h"
#include "planish/surface/quality_sum.h"

namespace planish {

/// The tiles of one level of a tile set.
struct WrittenTiles {
  int level = 1;
  std::int64_t tiles = 0, vertices = 0, triangles = 0;
  std::uint64_t bytes = 0;
  double geometric_error = 0;  ///< the largest of its tiles, in model units
};

/// A normal texture that was baked into a file.
struct WrittenMap {
  std::string mesh;  ///< of an asset
  std::string material;
  std::uint64_t bytes = 0;             ///< of its image
  double covered = 0, overlapped = 0;  ///< see NormalMap
};

/// A file as written.
struct WrittenOutput {
  std::string path;  ///< "-" for stdout
  OutputKind kind = OutputKind::Surface;
  Fineness fineness;              ///< of a surface
  std::vector<Fineness> coarser;  ///< that are in the file, too
  std::uint64_t bytes = 0;        ///< a .gltf counts its .bin, a tile set its tiles
  std::string sha256;             ///< of the file named by path
  std::int64_t vertices = 0, quads = 0, triangles = 0;
  std::int64_t faces = 0;            ///< of any size
  Scheme scheme = Scheme::DooSabin;  ///< of a cage
  std::int64_t creases = 0;          ///< tagged edges of a cage
  /// Of each fineness that is decimated, in their order; of several meshes the worst figures.
  std::vector<DecimationFigures> decimated;
  /// Largest distance of FittedMesh::points() from their places on the surface in the file,
  /// recomputed in double from the numbers in the file; a fraction of the diagonal.
  double as_written_error = 0;
  std::vector<WrittenTiles> tile_levels;  ///< of a tile set
  std::optional<StepFigures> step;        ///< of a STEP file, which has no fineness
  int bake_size = 0;                      ///< of its maps; 0: none are baked
  std::vector<WrittenMap> maps;
};

/// A page for people; its path is empty where there is none.
struct WrittenPage {
  std::string path;
  std::uint64_t bytes = 0;
};

struct InputFacts {
  std::string path, sha256, format;
  MeshStatistics statistics{};
  std::int64_t folded_edges = 0;  ///< see FoldedEdges, as the area
  double folded_edge_area = 0;
  std::int64_t welded = 0, dropped = 0;  ///< by readers, too
  /// The file's own, or the reconstruction's, before mending; `statistics` has those after it.
  std::int64_t file_vertices = 0, file_faces = 0;
};

/// Of a cloud, and of the mesh through its points.
struct PointFacts {
  std::int64_t points = 0, missing = 0, used = 0;
  glm::dvec3 origin{0};
  ReconstructionFigures mesh;
};

/// What a job's moves did to its mesh.
struct MovedFigures {
  std::int64_t moves = 0;
  std::int64_t vertices = 0;  ///< that are not where they were
  double farthest = 0;        ///< of their ways, as a fraction of the diagonal
};

/// How good the surface is, measured on one of its levels.
struct MeasuredSurface {
  int level = 0;
  SurfaceQuality quality;
  std::string reference;  ///< file of the source; empty: the input mesh
  /// How far separated sheets are from each other along their edges, a fraction of the diagonal;
  /// empty: there are none, or the scheme has no such figure.
  std::optional<double> sheet_gap;
  /// Of level kBendingLevel, distances as fractions of the diagonal; empty: no texture coordinates,
  /// or not asked for.
  std::optional<TextureSlide> texture_slide;
  /// Of the surface's vertices on that level to the source, as fractions of the diagonal.
  std::optional<PointDistances> source_distances;
  /// Of the source's vertices to the surface itself, whatever the level.
  std::optional<PointDistances> distances_from_source;
};

/// Wall-clock milliseconds; topology is OpenSubdiv's refiner, choose what measuring and a fit that
/// was not taken cost.
struct JobTiming {
  double read = 0, check = 0, topology = 0, stencils = 0, upload = 0, solve = 0, choose = 0,
         evaluate = 0, write = 0;
  double total = 0;
};

/// The parts of JobTiming::total by their names, in the order of the work.
inline constexpr std::pair<const char*, double JobTiming::*> kTimedSteps[] = {
    {"read", &JobTiming::read},         {"check", &JobTiming::check},
    {"topology", &JobTiming::topology}, {"stencils", &JobTiming::stencils},
    {"upload", &JobTiming::upload},     {"solve", &JobTiming::solve},
    {"choose", &JobTiming::choose},     {"evaluate", &JobTiming::evaluate},
    {"write", &JobTiming::write}};

/// What a job did; the source of its JSON report, its summary and its table row.
struct JobReport {
  std::string job;
  std::string label;  ///< Job::label
  std::vector<std::string> arguments;
  /// Of a tolerance, an angle or limits of STEP: files are written, and say so.
  bool falls_short = false;
  InputFacts input;
  DeviceDescription device;
  Settings settings;
  FitFigures fit;                          ///< until there is one, with the method alone
  std::optional<MovedFigures> moved;       ///< where the job has moves
  std::optional<MeasuredSurface> surface;  ///< empty where none was evaluated
  std::optional<PointFacts> points;        ///< of a point cloud
  /// Distances of all used points to the surface, as fractions of the diagonal; of a cloud.
  std::optional<PointDistances> point_distances;
  std::vector<PartSetting> part_settings;  ///< that hold for it, of a mesh of an asset
  std::vector<WrittenOutput> outputs;
  /// Of several meshes of a glTF that stays an asset: the report of each, without outputs; solve,
  /// surface and the like of the job are empty then.
  std::vector<JobReport> meshes;
  std::string mesh_name;          ///< of a mesh of an asset
  std::int64_t mesh_number = -1;  ///< in its file; -1: the job's input is no asset
  /// Of a skinned mesh, see AssetAttributes.
  double lost_joint_weight = 0;
  WrittenPage page;  ///< not in the JSON, which the page holds itself
  JobTiming timing;
  std::uint64_t host_peak_bytes = 0, device_bytes = 0;
  std::vector<Warning> warnings;
  /// Of one of several meshes of an asset: its warnings are told with those of the others.
  bool is_told_with_others = false;
};

/// "exit_code" of a report that falls short.
inline constexpr int kFallsShortCode = 5;

/// As JSON by report.schema.json: the same wherever the job ran.
[[nodiscard]] std::string report_json(const JobReport& report);

/// "1,148 vertices, 1,254 after separating sheets, 2,200 faces": the file's own counts, with what
/// mending made of them where that differs, and joining so many pairs of triangles. Or, where so
/// many vertices were added, "400 vertices, 796 faces; with 757 vertices added 2,310 faces".
[[nodiscard]] std::string counts_text(std::int64_t file_vertices, std::int64_t file_faces,
                                      std::int64_t vertices, std::int64_t faces,
                                      std::int64_t joined, std::int64_t added);

/// For people: what went in, what was chosen and why with how good it is, and what came out; in
/// full with how it was computed. Lines of repair, of points and of what is missed come where there
/// is anything to say.
[[nodiscard]] std::string summary(const JobReport& report, bool is_full);
/// "0.001 of the diagonal: vertices are left by 0.0004 rms, ..."
[[nodiscard]] std::string within_text(const WithinFit& within);

}  // namespace planish
