#include "mpi_report.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "build_info.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

using Json = nlohmann::ordered_json;

// Why a method was taken where none was named.
Json choice_of(const MpiJob& job) {
  if (job.settings.interpolation != InterpolationChoice::Auto) return nullptr;
  return "progressive: ranks do not measure both methods; --interpolation fair takes the other";
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json fair_json(const MpiJob& job, const DistributedFit& fit) {
  if (!fit.fair) return nullptr;
  return {{"polish", job.settings.polish_steps},
          {"shrunk_vertices", fit.fair->shrunk_vertices},
          {"reversed_vertices", fit.fair->reversed_vertices},
          {"cured_vertices", fit.fair->cured_vertices},
          {"flagged_edges", fit.fair->flagged_edges},
          {"flagged_faces", fit.fair->flagged_faces}};
}

Json solve_json(const MpiJob& job, const DistributedFit& fit) {
  const PetscSolution& solution = fit.solution;
  Json history = Json::array();
  for (const double error : solution.history) history.push_back(number(error));
  return {{"scheme", "doo-sabin"},
          {"interpolation", fit.fair ? "fair" : "progressive"},
          {"choice", choice_of(job)},
          {"fair", fair_json(job, fit)},
          {"weights", name_of(job.settings.weights)},
          {"boundary", name_of(job.settings.boundary)},
          {"creases", name_of(job.settings.creases)},
          {"solver", fit.fair ? "none" : name_of(job.settings.solver)},
          {"engine", "PETSc " + PetscSession::version()},
          {"tolerance", job.settings.tolerance},
          {"spectral_bound", fit.spectral_bound},
          {"entries", fit.entries},
          {"converged", solution.converged},
          {"stop_reason", name_of(solution.stop_reason)},
          {"iterations", solution.iterations},
          {"error", {{"max", number(solution.error.max)}, {"rms", number(solution.error.rms)}}},
          {"batch_errors", history},
          {"reductions", solution.reductions}};
}

Json ranks_json(const DistributedFit& fit) {
  Json ranks = Json::array();
  for (const RankFigures& rank : fit.ranks) {
    Json timing = Json::object();
    for (std::size_t p = 0; p < std::size(kPhases); ++p)
      timing[std::string(kPhases[p])] = rank.milliseconds[p];
    ranks.push_back({{"rank", rank.rank},
                     {"host", plain_utf8(std::string(rank.host.data()))},
                     {"vertices", rank.vertices},
                     {"faces", rank.faces},
                     {"ghosts", rank.ghosts},
                     {"halo", rank.halo},
                     {"peers", rank.peers},
                     {"peak_bytes", rank.peak_bytes},
                     {"timing_ms", timing}});
  }
  return ranks;
}

Json tiles_json(const MpiJob& job, const DistributedFit& fit) {
  const TilesFile& file = fit.tiles->file;
  Json levels = Json::array();
  for (const TileLevel& level : file.levels)
    levels.push_back({{"level", level.level},
                      {"tiles", level.tiles},
                      {"bytes", level.bytes},
                      {"vertices", level.vertex_count},
                      {"triangles", level.triangle_count},
                      {"geometric_error", level.geometric_error}});
  return {{"kind", "tiles"},
          {"path", plain_utf8(job.tiles)},
          {"level", job.options.tiles_options.level},
          {"bytes", file.byte_count},
          {"vertices", file.row_count},
          {"quads", file.face_count},
          {"as_written_error", number(file.largest_distance / fit.placement.diagonal)},
          {"blocks", fit.tiles->blocks},
          {"resumed_blocks", fit.tiles->resumed},
          {"tiles", levels}};
}

// Of level 1, as planish fit has it of a set of tiles.
Json surface_json(const DistributedFit& fit) {
  if (!fit.tiles) return nullptr;
  const SurfaceQuality& quality = fit.tiles->quality;
  return {{"level", 1},
          {"reference", "input"},
          {"folded_area", quality.folded_area},
          {"folded_area_elsewhere", quality.folded_area_elsewhere},
          {"rms_normal_deviation", quality.rms_normal_deviation},
          {"max_normal_deviation", quality.max_normal_deviation},
          {"bending", quality.bending}};
}

// What is in place: "  wrote big.json: 5 tiles, 1234 bytes".
std::string written_text(const MpiJob& job, const DistributedFit& fit) {
  std::ostringstream text;
  if (fit.tiles) {
    const TilesFile& file = fit.tiles->file;
    std::int64_t tiles = 0;
    for (const TileLevel& level : file.levels) tiles += level.tiles;
    text << "  wrote " << visible(job.tiles) << ": " << counted(tiles, "tile") << ", "
         << file.byte_count << " bytes";
    if (fit.tiles->resumed > 0)
      text << "; " << fit.tiles->resumed << " of " << counted(fit.tiles->blocks, "block")
           << " were there";
    text << "\n";
  }
  std::error_code error;
  for (const std::string& path : {job.cage, job.report}) {
    if (path.empty() || path == "-") continue;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    text << "  wrote " << visible(path);
    if (!error) text << ": " << bytes << " bytes";
    text << "\n";
  }
  return text.str();
}

}  // namespace

std::string mpi_report(const std::vector<std::string>& arguments, const MpiJob& job,
                       const DistributedFit& fit, ExitCode exit_code) {
  std::int64_t halo = 0;
  for (const RankFigures& rank : fit.ranks) halo += rank.halo;
  Json argv = Json::array(), warnings = Json::array(), outputs = Json::array();
  for (const std::string& argument : arguments) argv.push_back(plain_utf8(argument));
  for (const Warning& warning : fit.warnings)
    warnings.push_back({{"code", warning.code},
                        {"message", plain_utf8(warning.message)},
                        {"count", warning.count},
                        {"first", warning.first}});
  if (fit.tiles) outputs.push_back(tiles_json(job, fit));
  if (!job.cage.empty()) outputs.push_back({{"kind", "cage"}, {"path", plain_utf8(job.cage)}});
  const Json report = {
      {"schema", "planish.distributed/1"},
      {"tool", {{"name", "planish-mpi"}, {"version", PLANISH_VERSION}, {"git", kGitRevision}}},
      {"argv", argv},
      {"exit_code", static_cast<int>(exit_code)},
      {"input",
       {{"path", plain_utf8(job.input)},
        {"vertices", fit.vertices},
        {"faces", fit.faces},
        {"unused_vertices", fit.unused_vertices},
        {"diagonal", fit.placement.diagonal},
        {"vertex_kinds",
         {{"smooth", fit.kinds[0]},
          {"dart", fit.kinds[1]},
          {"crease", fit.kinds[2]},
          {"corner", fit.kinds[3]}}}}},
      {"solve", solve_json(job, fit)},
      {"surface", surface_json(fit)},
      {"outputs", outputs},
      {"ranks", ranks_json(fit)},
      {"halo", {{"ghosts", halo}, {"bytes_per_product", 24 * halo}}},
      {"warnings", warnings}};
  return report.dump(2) + "\n";
}

std::string mpi_summary(const MpiJob& job, const DistributedFit& fit) {
  std::ostringstream text;
  text << visible(job.input) << ": " << fit.vertices << " vertices, " << fit.faces << " faces on "
       << fit.ranks.size() << (fit.ranks.size() == 1 ? " rank, " : " ranks, ");
  if (fit.fair) {
    text << "fair, ";
  } else {
    text << fit.solution.iterations << " iterations, ";
  }
  text << "largest vertex error " << std::setprecision(3) << fit.solution.error.max
       << (fit.solution.converged ? "" : " (not converged)") << "\n";
  if (const Json choice = choice_of(job); choice.is_string())
    text << "  method " << choice.get<std::string>() << "\n";
  if (fit.tiles) {
    for (const TileLevel& level : fit.tiles->file.levels)
      text << "  level " << level.level << ": " << level.tiles
           << (level.tiles == 1 ? " tile, " : " tiles, ") << level.vertex_count << " vertices, "
           << level.bytes << " bytes\n";
  }
  text << written_text(job, fit);
  for (std::size_t p = 0; p < std::size(kPhases); ++p) {
    double slowest = 0;
    for (const RankFigures& rank : fit.ranks) slowest = std::max(slowest, rank.milliseconds[p]);
    text << (p == 0 ? "  " : ", ") << kPhases[p] << " " << std::setprecision(3) << slowest / 1000
         << " s";
  }
  std::int64_t peak = 0;
  for (const RankFigures& rank : fit.ranks) peak = std::max(peak, rank.peak_bytes);
  text << "; peak of a rank " << peak / 1000000 << " MB\n";
  // Messages end their lines themselves.
  std::string summary = text.str();
  summary.pop_back();
  return summary;
}

}  // namespace planish::command
