#include "mpi_job.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <system_error>

#include "commands.h"
#include "help.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/build_info.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/fit_report.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish::command {
namespace {

// What is in no table of options: files, messages, and what ranks have besides.
constexpr std::string_view kTaken[] = {
    "input", "output",  "cage",           "report", "input_format", "force",
    "quiet", "verbose", "log_level",      "color",  "progress",     "help",
    "scene", "job",     "block_vertices", "resume", "watchdog",     "partition"};

struct Refused {
  std::string_view name, remedy;
};

constexpr std::string_view kNoPage = "planish on one machine writes pages; leave it out";

constexpr std::string_view kNoBudget =
    "each rank holds its part of the mesh; more ranks on more machines hold more";

constexpr Refused kRefused[] = {
    {"source", "the report compares with the input only; leave it out"},
    {"moves", "ranks do not edit; take planish on one machine"},
    {"jobs", "one input at a time; mpirun -n says how many ranks work on it"},
    {"output_format", "surfaces are 3D Tiles, cages PLY; leave it out"},
    {"dry_run", "ranks make no forecast; take planish on one machine for it"},
    {"json", "each job of a scene names its own report; leave it out"},
    {"report_of_jobs", "each job of a scene names its own report; leave it out"},
    {"memory", kNoBudget},
    {"temporary", kNoBudget},
    {"page", kNoPage},
    {"page_limit", kNoPage},
    {"page_no_times", kNoPage},
};

// Flags are named by their long name: "chord_error" of the option chord_errors.
const OptionInfo* option_of(std::string_view name) {
  const auto is_it = [&](const OptionInfo& option) {
    std::string flag = flag_of(option).substr(2);
    std::ranges::replace(flag, '-', '_');
    return option.name == name || flag == name;
  };
  const auto fit = std::ranges::find_if(option_table(), is_it);
  if (fit != option_table().end()) return &*fit;
  const auto point = std::ranges::find_if(point_option_table(), is_it);
  return point == point_option_table().end() ? nullptr : &*point;
}

RankRule rule_of(std::string_view name) {
  if (const OptionInfo* option = option_of(name)) return option->ranks;
  if (std::ranges::find(kTaken, name) != std::end(kTaken)) return {};
  const auto refused = std::ranges::find(kRefused, name, &Refused::name);
  if (refused != std::end(kRefused)) return {"", refused->remedy};
  return {"", "take planish on one machine"};
}

bool takes(const RankRule& rule, std::string_view value) {
  if (rule.words == "*") return true;
  if (rule.words.starts_with('!')) return rule.words.substr(1) != value;
  for (std::string_view rest = rule.words; !rest.empty();) {
    const std::size_t end = std::min(rest.find('|'), rest.size());
    if (rest.substr(0, end) == value) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

[[noreturn]] void refuse_option(const GivenSetting& option, std::string_view remedy) {
  // A switch says nothing but its name.
  const bool is_switch = option.value.empty() || option.value == "true";
  refuse(option.where, (is_switch ? "" : visible(option.value) + " ") +
                           "is not available in planish-mpi: " + std::string(remedy));
}

}  // namespace

MpiOption mpi_option(std::string_view name) {
  const RankRule rule = rule_of(name);
  if (rule.words == "*") return MpiOption::Taken;
  return rule.words.empty() ? MpiOption::Refused : MpiOption::SomeWords;
}

std::string words_taken(std::string_view name) {
  const RankRule rule = rule_of(name);
  const bool is_list = rule.words != "*" && !rule.words.starts_with('!');
  return std::string(is_list ? rule.words : "");
}

void require_available(std::span<const GivenSetting> given, const FitSettings& settings) {
  for (std::size_t i = 0; i < given.size(); ++i) {
    const GivenSetting& one = given[i];
    const auto later = given.subspan(i + 1);
    if (std::ranges::find(later, one.name, &GivenSetting::name) != later.end()) continue;
    const OptionInfo* option = option_of(one.name);
    const bool is_fineness = option != nullptr && option->stage == OptionStage::Fineness;
    if (is_fineness && !settings.adaptive.any()) continue;
    const RankRule rule = rule_of(one.name);
    if (!takes(rule, one.value)) refuse_option(one, rule.remedy);
  }
}

namespace {

void take_output(const OutputRequest& request, MpiJob& job) {
  const auto format = format_of(request.path);
  const bool is_cage = request.kind == OutputKind::Cage;
  if (is_cage && format != FileFormat::Ply)
    refuse(request.where, visible(request.path) + ": ranks write cages as .ply only");
  if (!is_cage && (!format || !info_of(*format).is_tiles))
    refuse(request.where,
           visible(request.path) +
               ": ranks write surfaces as 3D Tiles (.json) only; take NAME.json, or planish on one "
               "machine");
  std::string& path = is_cage ? job.cage : job.tiles;
  if (!path.empty())
    refuse(request.where, visible(request.path) + ": ranks write one " +
                              (is_cage ? "cage" : "set of tiles") + " of a mesh, and there is " +
                              visible(path) + " already; make two jobs of it");
  path = request.path;
  job.outputs.push_back(request);
  if (is_cage) return;
  if (request.adaptive.any())
    refuse(request.where, visible(request.path) +
                              ": 3D Tiles have levels, not a chord error or an angle; take levels");
  job.options.tiles_options.level = std::ranges::max(request.levels);
  if (job.options.tiles_options.level < 1)
    refuse(request.where == "-o" ? "--levels" : request.where,
           visible(request.path) + ": 3D Tiles have levels from 1 on, not 0");
}

void take_settings(MpiJob& job) {
  const Settings& settings = job.settings;
  DistributedOptions& options = job.options;
  options.method = settings.interpolation == InterpolationChoice::Fair
                       ? InterpolationMethod::Fair
                       : InterpolationMethod::Progressive;
  options.polish_steps = settings.polish_steps;
  options.weights = settings.weights;
  options.sharp = {settings.boundary, settings.creases.use_tags};
  options.crease_edges = settings.crease_edges;
  options.corner_vertices = settings.corner_vertices;
  options.solver = settings.solver;
  options.tolerance = settings.tolerance;
  options.within = settings.within.of_diagonal.value_or(0.0);
  options.max_iterations = settings.max_iterations;
  job.settings.quads = QuadChoice::Off;
  job.settings.refine = RefineChoice::Off;
  options.creases = creases_text(settings.creases.use_tags, false, {});
  TilesOptions& tiles = options.tiles_options;
  tiles.tile_vertices = settings.tile_vertices;
  tiles.skirts = settings.skirts;
  tiles.gltf.z_up = settings.up == UpAxis::Z;
}

bool is_given(const Job& job, std::string_view name) {
  return std::ranges::find(job.given, name, &GivenSetting::name) != job.given.end();
}

}  // namespace

MpiJob mpi_job_of(const Job& job, const MpiSettings& own) {
  require_available(job.given, job.settings);
  MpiJob made;
  made.name = job.name;
  made.input = job.input;
  made.input_format = job.input_format;
  made.settings = job.settings;
  // Nothing is mended over ranks: what planish does by itself is not refused, but left out.
  if (!is_given(job, "repair")) made.settings.repair = RepairChoice::None;
  if (job.input == "-")
    refuse("INPUT", "stdin cannot be read in ranges; write it to a file, and name that");
  for (const OutputRequest& request : job.outputs) take_output(request, made);
  take_settings(made);
  DistributedOptions& options = made.options;
  options.name = job.input;
  options.tiles = made.tiles;
  options.cage = made.cage;
  options.resume = own.resume && !made.tiles.empty();
  options.replaces = own.force;
  options.tiles_options.gltf.name = plain_utf8(utf8(std::filesystem::path(job.input).stem()));
  options.cage_header = cage_header_lines(made.settings, options.method, job.input);
  if (own.block_vertices) options.block_vertices = *own.block_vertices;
  made.report = job.report;
  return made;
}

void claim_files(const std::vector<MpiJob>& jobs, const std::string& scene,
                 const MpiSettings& own) {
  PathClaims claims({.overwrite = own.force, .create_folders = own.is_scene});
  if (!scene.empty()) claims.add_input(scene);
  for (const MpiJob& job : jobs) claims.add_input(job.input);
  for (const MpiJob& job : jobs) {
    for (const OutputRequest& request : job.outputs) (void)plan_output(request, claims);
    if (!job.report.empty())
      claims.add_report(job.report, own.is_scene ? "report of job " + job.name : "--report");
  }
}

std::vector<PlannedStep> steps_of(const MpiJob& job) {
  // Seconds of 4 million vertices, and of tiles of level 2.
  const bool is_fair = job.options.method == InterpolationMethod::Fair;
  const double tiles =
      job.tiles.empty() ? 0 : 1.25 * std::ldexp(1.0, 2 * job.options.tiles_options.level);
  return {{"read", 0.5},    {"sort", 1.6}, {"faces", 0.4},
          {"rings", 0.3},   {"rows", 2.1}, {"solve", is_fair ? 55.0 : 0.6},
          {"tiles", tiles}, {"write", 0.5}};
}

void make_folders(const MpiJob& job) {
  for (const std::string& path : {job.tiles, job.cage, job.report}) {
    if (path.empty() || path == "-") continue;
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
      throw Error(ErrorCode::UnwritableOutput,
                  formatted("{}: cannot make the folder {}: {}", visible(path), visible(folder),
                            error.message()));
  }
}

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

namespace {

struct OwnFlags {
  std::string block, watchdog, partition;
  bool resume = false, force = false;
};

// Flags of `planish run` that ranks have not: looked at for the refusal only.
struct RunRest {
  std::string device, report, page, page_limit;
  bool dry_run = false, json = false, page_no_times = false;
};

double parse_seconds(const std::string& text) {
  double seconds = 0;
  if (!parse_number(text, seconds) || seconds < 0)
    refuse("--watchdog", in_double_quotes(text) + " is no number of seconds from 0");
  return seconds;
}

std::string version_line() {
  return formatted("planish-mpi {} ({})\nPETSc {}\n", PLANISH_VERSION, git_revision(),
                   PetscSession::version());
}

void add_own_flags(CLI::App& command, OwnFlags& flags) {
  const char* group = "Ranks";
  command
      .add_flag("--resume", flags.resume,
                "go on with the tiles that an ended job of the same input and options has left")
      ->group(group);
  command
      .add_option("--block-vertices", flags.block,
                  "vertices of a unit of work without tiles [65536]")
      ->type_name("N")
      ->group(group);
  command
      .add_option("--watchdog", flags.watchdog,
                  "end the job after so many seconds without progress; 0: never [600]")
      ->type_name("SECONDS")
      ->group(group);
  command
      .add_option("--partition", flags.partition,
                  "of vertices over ranks: runs along a space-filling curve [hilbert]")
      ->type_name("hilbert")
      ->group(group);
}

MpiSettings own_settings(const OwnFlags& flags) {
  MpiSettings own;
  own.resume = flags.resume;
  own.force = flags.force;
  if (!flags.watchdog.empty()) own.watchdog_seconds = parse_seconds(flags.watchdog);
  if (!flags.partition.empty() && flags.partition != "hilbert")
    refuse("--partition",
           visible(flags.partition) +
               " is not available in planish-mpi: its files would change with the ranks; take "
               "hilbert");
  if (flags.block.empty()) return own;
  std::int64_t block = 0;
  if (!parse_integer(flags.block, block) || block < 1 || block > std::int64_t{1} << 24)
    refuse("--block-vertices", visible(flags.block) + " is out of range; 1 to 16777216 is wanted");
  own.block_vertices = block;
  return own;
}

// "--chord-error" and "chord_error"; "INPUT" and "input" of what has no dashes.
std::string flag_of(const CLI::Option& option) {
  if (option.get_lnames().empty()) return option.get_single_name();
  return "--" + option.get_lnames().front();
}

std::string name_of(const CLI::Option& option) {
  std::string name = flag_of(option);
  name.erase(0, name.find_first_not_of('-'));
  std::ranges::replace(name, '-', '_');
  return lower_case(name);
}

// What ranks have not is not shown, and refused where it is given.
void show_available(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const std::string name = name_of(*option), words = words_taken(name);
    if (!words.empty()) option->type_name(words);
    if (mpi_option(name) == MpiOption::Refused) option->group("");
  }
}

// Where planish's own words do not hold.
void describe_fit(CLI::App& fit) {
  const auto says = [&](const char* flag, const char* text) {
    fit.get_option(flag)->description(text);
  };
  says("INPUT", "mesh: binary PLY and OBJ are read by all ranks");
  says("--output", "surface as 3D Tiles (.json; tiles in a folder beside)");
  says("--cage", "control cage (.ply)");
  says("--levels", "tiles have all levels from 1 to the finest of these [2]");
  says("--input-format", "against the extension");
  fit.get_option("--input-format")->type_name(names_of(FormatUse::ReadMesh, "|"));
  says("--interpolation",
       "progressive: as in the paper; fair: without folds on uneven meshes; auto: progressive, for "
       "ranks do not measure both [auto]");
  says("--levels", "quad splits, 1 to 6: tiles have all from 1 to it; auto is 2 [auto]");
  says("--precision", "of the solve; auto is double [auto]");
  says("--repair", "nothing is mended over ranks [none]");
  says("--scheme", "subdivision scheme [doo-sabin]");
  says("--solver", "chebyshev; plain as in the paper [chebyshev]");
  says("--creases", "sharp edges: tagged ones, none [use]");
  says("--compress", "of tiles [none]");
  says("--device", "ranks work on the CPU [auto]");
}

std::vector<GivenSetting> given_flags(const CLI::App& command) {
  std::vector<GivenSetting> given;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    std::string value;
    for (const std::string& word : option->results()) value += (value.empty() ? "" : " ") + word;
    given.push_back({name_of(*option), flag_of(*option), value});
  }
  return given;
}

// Flags that would do nothing are slips of the hand, which a scene's defaults are not.
void require_tiles_for(const FitFlags& flags, const OwnFlags& own) {
  const auto refuse_if = [](bool is_there, const std::string& flag) {
    if (is_there) refuse(flag, "belongs to 3D Tiles; name them: -o NAME.json");
  };
  for (const FitOption& option : option_table())
    if (option.needs == OptionNeeds::Tiles || option.stage == OptionStage::Fineness)
      refuse_if(flags.options.contains(option.name), flag_of(option));
  refuse_if(own.resume, "--resume");
}

Job fit_job_of(const CLI::App& fit, const FitFlags& flags, const OwnFlags& own) {
  std::vector<GivenSetting> given = given_flags(fit);
  require_available(given, {.adaptive = {.angle = 1}});
  if (flags.inputs.size() != 1)
    refuse("INPUT", "{} meshes; one at a time, or a scene: planish-mpi run SCENE",
           flags.inputs.size());
  const Settings settings = settings_of(flags);
  for (const FitOption& option : option_table()) {
    const bool lacks_fair =
        option.needs == OptionNeeds::Fair && settings.interpolation != InterpolationChoice::Fair;
    if (lacks_fair && flags.options.contains(option.name))
      refuse(flag_of(option), "belongs to the fair method; take --interpolation fair");
  }
  if (flags.outputs.empty()) require_tiles_for(flags, own);
  if (!flags.outputs.empty() && !own.block.empty())
    refuse("--block-vertices", "blocks of tiles are a quarter of --tile-vertices; set that");
  Job job = job_of(flags, settings, flags.inputs.front(), false);
  job.given = std::move(given);
  job.report = flags.report;
  if (flags.outputs.empty() && flags.cage.empty() && flags.report.empty())
    refuse("-o",
           "nothing to write; name tiles (-o NAME.json), a cage (--cage FILE.ply) or a report");
  return job;
}

void add_run_flags(CLI::App& run, MpiRequest& request, OwnFlags& own, RunRest& rest) {
  run.add_option("SCENE", request.scene, "scene file (JSON), as planish run reads it")->required();
  run.add_option("JOB", request.names, "names of jobs; all where none is named");
  run.add_flag("-f,--force", own.force, "overwrite existing files");
  run.add_option("--device", rest.device, "ranks work on the CPU [auto]");
  run.add_option("--report", rest.report)->group("");
  run.add_flag("--json", rest.json)->group("");
  run.add_flag("--dry-run", rest.dry_run)->group("");
  add_page_flags(run, {rest.page, rest.page_limit, rest.page_no_times},
                 "HTML page to look at: the surface in 3-D, figures, plots; - for stdout");
}

void require_run_available(const CLI::App& run) {
  std::vector<GivenSetting> given = given_flags(run);
  for (GivenSetting& flag : given)
    if (flag.name == "report") flag.name = "report_of_jobs";
  require_available(given, {});
}

// The page of a command, of the whole program where none is named.
std::string manual_of(const CLI::App& app, const std::string& command) {
  const HelpPage help = help_page(app, {});
  const auto page = std::ranges::find(help.commands, command, &HelpPage::name);
  return manual_page(page == help.commands.end() ? help : *page, help);
}

}  // namespace

MpiRequest parse_mpi_flags(const std::vector<std::string>& arguments) {
  CLI::App app(
      "Interpolating Doo-Sabin surfaces over many machines: "
      "mpirun -n 4 planish-mpi fit big.ply -o big/tileset.json --cage cage.ply",
      "planish-mpi");
  app.require_subcommand(0, 1);  // "manual fit" is the page of fit
  MpiRequest request;
  FitFlags flags;
  OwnFlags fit_own, run_own;
  RunRest rest;
  bool wants_version = false;
  app.add_flag("--version", wants_version, "print versions");
  CLI::App& fit = *app.add_subcommand("fit", "mesh in, tiles, control cage and report out");
  add_fit_flags(fit, flags);
  describe_fit(fit);
  add_own_flags(fit, fit_own);
  request.messages.add_to(fit, true);
  show_available(fit);
  CLI::App& run = *app.add_subcommand("run", "the jobs of a scene file, one after another");
  add_run_flags(run, request, run_own, rest);
  add_own_flags(run, run_own);
  request.messages.add_to(run, true);
  show_available(run);
  // For the build, which installs what it prints; without a description it is not listed.
  CLI::App& manual = *app.add_subcommand("manual", "")->group("");
  std::string page;
  manual.add_option("COMMAND", page, "");
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
  try {
    app.parse(reversed);
  } catch (const CLI::CallForHelp&) {
    request.text = fit.parsed() ? fit.help() : run.parsed() ? run.help() : app.help();
    return request;
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::InvalidArgument, std::string(error.what()) + "; see planish-mpi --help");
  }
  if (manual.parsed()) request.text = manual_of(app, page);
  if (wants_version) request.text = version_line();
  if (request.text.empty() && !fit.parsed() && !run.parsed()) request.text = app.help();
  if (!request.text.empty()) return request;
  (void)request.messages.level();
  (void)request.messages.color_mode();
  (void)request.messages.progress_mode();
  if (run.parsed()) {
    require_run_available(run);
    request.own = own_settings(run_own);
    request.own.is_scene = true;
    return request;
  }
  fit_own.force = flags.force;
  request.own = own_settings(fit_own);
  request.jobs.push_back(fit_job_of(fit, flags, fit_own));
  return request;
}

}  // namespace planish::command
