#include "mpi_report.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <system_error>

#include "planish/core/counted.h"
#include "planish/core/json.h"
#include "planish/core/number_text.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "planish/job/build_info.h"
#include "planish/job/report_json.h"
#include "planish/job/text.h"
#include "planish/pipeline/fit_report.h"

namespace planish::command {
namespace {

using Json = nlohmann::ordered_json;

// Why a method was taken where none was named.
std::optional<Choice> choice_of(const MpiJob& job) {
  if (job.settings.interpolation != InterpolationChoice::Auto) return std::nullopt;
  Choice choice;
  choice.reason =
      "progressive: ranks do not measure both methods; --interpolation fair takes the other";
  return choice;
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// The fit of all ranks as one machine would have it, for what a report says of that.
FittedMesh fitted_of(const MpiJob& job, const DistributedFit& fit) {
  const Settings& settings = job.settings;
  FittedMesh all;
  all.options = fit_options(
      settings, fit.fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive);
  all.repairs = false;
  all.uses_tags = settings.creases.use_tags;
  all.finds_features = settings.creases.finds_features;
  all.crease_degrees = settings.creases.dihedral_degrees;
  all.choice = choice_of(job);
  all.fit.spectral_bound = fit.spectral_bound;
  all.fit.within = fit.within;
  Interpolation& result = all.fit.interpolation;
  result.converged = fit.solution.converged;
  result.stop_reason = fit.solution.stop_reason;
  result.iterations = fit.solution.iterations;
  result.error = fit.solution.error;
  result.history = fit.solution.history;
  if (fit.fair) all.fit.fair.emplace(FairFit{*fit.fair, {}, {}});
  return all;
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
  Json argv = Json::array(), outputs = Json::array();
  for (const std::string& argument : arguments) argv.push_back(plain_utf8(argument));
  if (fit.tiles) outputs.push_back(tiles_json(job, fit));
  if (!job.cage.empty()) outputs.push_back({{"kind", "cage"}, {"path", plain_utf8(job.cage)}});
  const Json report = {
      {"schema", "planish.distributed/2"},
      {"tool", {{"name", "planish-mpi"}, {"version", PLANISH_VERSION}, {"git", git_revision()}}},
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
      {"solve", solve_json(fitted_of(job, fit).figures())},
      {"matrix",
       {{"engine", "PETSc " + PetscSession::version()},
        {"entries", fit.entries},
        {"reductions", fit.solution.reductions}}},
      // Of level 1, as planish fit has it of a set of tiles.
      {"surface", fit.tiles ? quality_json(fit.tiles->quality, 1) : Json()},
      {"outputs", outputs},
      {"ranks", ranks_json(fit)},
      {"halo", {{"ghosts", halo}, {"bytes_per_product", 24 * halo}}},
      {"warnings", warnings_json(fit.warnings)}};
  return json_text(report);
}

std::string mpi_summary(const MpiJob& job, const DistributedFit& fit) {
  std::ostringstream text;
  text << visible(job.input) << ": " << planish::counted(fit.vertices, "vertex") << ", "
       << planish::counted(fit.faces, "face") << " on " << counted(std::ssize(fit.ranks), "rank")
       << ", ";
  if (fit.fair) {
    text << "fair, ";
  } else {
    text << counted(fit.solution.iterations, "iteration") << ", ";
  }
  text << "largest vertex error " << std::setprecision(3) << fit.solution.error.max
       << (fit.solution.converged ? "" : " (not converged)") << "\n";
  if (const auto choice = choice_of(job)) text << "  method " << choice->reason << "\n";
  if (fit.within) text << "  within " << within_text(*fit.within) << "\n";
  if (fit.tiles) {
    for (const TileLevel& level : fit.tiles->file.levels)
      text << "  level " << level.level << ": " << planish::counted(level.tiles, "tile") << ", "
           << planish::counted(static_cast<std::int64_t>(level.vertex_count), "vertex") << ", "
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
