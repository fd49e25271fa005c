#include "mpi_flags.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "build_info.h"
#include "job/input.h"
#include "options/fit_flags.h"
#include "options/refuse.h"
#include "options/word_flags.h"
#include "output/cage_header.h"
#include "output/output_plan.h"
#include "planish/core/number_text.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "planish/files/tiles/write_tiles.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct MpiFlags {
  std::string input, input_format, output, levels, tile_vertices, cage, report, tolerance;
  std::string max_iterations, polish, block, watchdog;
  SettingWords words;
  bool force = false, skirts = false, resume = false;
  std::vector<std::string> refused;  // what they were given
};

struct Missing {
  const char* flag;
  const char* reason;
};

constexpr std::array kMissing{
    Missing{"--page", "pages are written by planish on one machine"},
    Missing{"--weld", "nothing is mended over ranks; weld by planish first"},
    Missing{"--chord-error", "tiles have levels; take --levels"},
    Missing{"--angle", "tiles have levels; take --levels"},
    Missing{"--source", "the report compares with the input only"},
    Missing{"-j,--jobs", "one input at a time; mpirun -n says how many ranks work on it"},
    Missing{"--output-format", "cages are PLY, surfaces 3D Tiles"}};

// What a word may be; others are planish's on one machine.
struct Allowed {
  std::string_view name;
  std::string_view words;  // with blanks around each
  const char* reason;
};

constexpr std::array kAllowed{
    Allowed{"preset", " paper ", ""},
    Allowed{"weights", " doo-sabin averaged ", ""},
    Allowed{"interpolation", " auto progressive fair ", ""},
    Allowed{"solver", " chebyshev plain ", "take chebyshev or plain"},
    Allowed{"precision", " auto double ", "ranks solve in double precision"},
    Allowed{"boundary", " edge edge-and-corner ", ""},
    Allowed{"creases", " use ignore ", "edges are not looked for over ranks; tag them in the file"},
    Allowed{"repair", " none ", "nothing is mended over ranks; mend the file by planish first"},
    Allowed{"scheme", " doo-sabin ", "take doo-sabin"},
    Allowed{"up", " y z ", ""},
};

void require_allowed(const MpiFlags& flags) {
  for (const auto& [name, value] : flags.words) {
    if (value.empty()) continue;
    const auto allowed = std::ranges::find(kAllowed, name, &Allowed::name);
    if (allowed == kAllowed.end()) refuse(flag_of(name), "is not available in planish-mpi");
    if (allowed->words.find(" " + value + " ") == std::string_view::npos &&
        *allowed->reason != '\0')
      refuse(flag_of(name),
             visible(value) + " is not available in planish-mpi: " + allowed->reason);
  }
}

double parse_seconds(const std::string& text) {
  double seconds = 0;
  if (!parse_number(text, seconds) || seconds < 0)
    refuse("--watchdog", "\"" + visible(text) + "\" is no number of seconds from 0");
  return seconds;
}

void require_ply(const std::string& path) {
  if (format_of(path) != FileFormat::Ply)
    refuse("--cage", visible(path) + ": ranks write cages as .ply only");
}

std::string version_line() {
  return std::string("planish-mpi ") + PLANISH_VERSION + " (" + kGitRevision + ")\nPETSc " +
         PetscSession::version() + "\n";
}

void take_tiles(const MpiFlags& flags, MpiJob& job) {
  Settings& settings = job.settings;
  if (flags.output.empty()) {
    for (const auto& [is_given, flag] : {std::pair{!flags.levels.empty(), "--levels"},
                                         {!flags.tile_vertices.empty(), "--tile-vertices"},
                                         {flags.skirts, "--skirts"},
                                         {flags.resume, "--resume"}})
      if (is_given) refuse(flag, "belongs to 3D Tiles; name them: -o NAME.json");
    return;
  }
  const auto format = format_of(flags.output);
  if (!format || !info_of(*format).is_tiles)
    refuse("-o", visible(flags.output) + ": ranks write surfaces as 3D Tiles (.json) only");
  if (!flags.block.empty())
    refuse("--block-vertices", "blocks of tiles are a quarter of --tile-vertices");
  if (!flags.levels.empty()) settings.levels = parse_levels(flags.levels);
  if (std::ranges::max(settings.levels) < 1)
    refuse("--levels", visible(flags.output) + ": 3D Tiles have levels from 1 on, not 0");
  if (!flags.tile_vertices.empty())
    set_tile_vertices(settings, parse_whole(flags.tile_vertices, "--tile-vertices"),
                      "--tile-vertices");
  DistributedOptions& options = job.options;
  options.tiles = job.tiles = flags.output;
  options.resume = flags.resume;
  options.creases = name_of(settings.creases);
  TilesOptions& tiles = options.tiles_options;
  tiles.level = std::ranges::max(settings.levels);
  tiles.tile_vertices = settings.tile_vertices;
  tiles.skirts = flags.skirts;
  tiles.gltf.name = plain_utf8(std::filesystem::path(flags.input).stem().string());
  tiles.gltf.z_up = settings.up == UpAxis::Z;
}

void take_method(const MpiFlags& flags, MpiJob& job) {
  Settings& settings = job.settings;
  const bool is_fair = settings.interpolation == InterpolationChoice::Fair;
  if (!flags.polish.empty()) {
    if (!is_fair) refuse("--polish", "belongs to the fair method; take --interpolation fair");
    set_polish_steps(settings, parse_whole(flags.polish, "--polish"), "--polish");
  }
  job.options.method = is_fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive;
  job.options.polish_steps = settings.polish_steps;
}

MpiJob job_of(const MpiFlags& flags) {
  require_allowed(flags);
  MpiJob job;
  job.input = flags.input;
  if (!flags.input_format.empty())
    job.input_format = parse_input_format(flags.input_format, "--input-format");
  if (job.input == "-") refuse("INPUT", "stdin cannot be read in ranges; name a file");
  Settings& settings = job.settings;
  settings.repair = RepairChoice::None;
  apply_words(flags.words, word_settings(), settings);
  if (!flags.tolerance.empty())
    set_tolerance(settings, std::string_view(flags.tolerance), "--tolerance");
  if (!flags.max_iterations.empty())
    set_max_iterations(settings, parse_whole(flags.max_iterations, "--max-iterations"),
                       "--max-iterations");
  take_method(flags, job);
  DistributedOptions& options = job.options;
  if (!flags.block.empty()) {
    options.block_vertices = parse_whole(flags.block, "--block-vertices");
    if (options.block_vertices < 1 || options.block_vertices > std::int64_t{1} << 24)
      refuse("--block-vertices", flags.block + " is out of range; 1 to 16777216 is wanted");
  }
  if (!flags.watchdog.empty()) job.watchdog_seconds = parse_seconds(flags.watchdog);
  options.weights = settings.weights;
  options.sharp = settings.sharp();
  options.solver = settings.solver;
  options.tolerance = settings.tolerance;
  options.max_iterations = settings.max_iterations;
  options.name = job.input;
  options.cage = job.cage = flags.cage;
  job.report = flags.report;
  job.force = flags.force;
  take_tiles(flags, job);
  if (job.cage.empty() && job.report.empty() && job.tiles.empty())
    refuse("-o",
           "nothing to write; name tiles (-o NAME.json), a cage (--cage FILE.ply) or a report");
  if (!job.cage.empty()) require_ply(job.cage);
  options.cage_header = cage_header_lines(settings, options.method, job.input);
  return job;
}

void add_flags(CLI::App& fit, MpiFlags& flags) {
  fit.add_option("INPUT", flags.input, "mesh: binary PLY and OBJ are read by all ranks")
      ->required();
  fit.add_option("-o,--output", flags.output,
                 "surface as 3D Tiles (.json; tiles in a folder beside)")
      ->type_name("FILE");
  fit.add_option("--levels", flags.levels, "tiles have all levels up to the finest of these [2]")
      ->type_name("N[,N...]");
  fit.add_option("--tile-vertices", flags.tile_vertices,
                 "about so many has each file of 3D Tiles [262144]")
      ->type_name("N");
  fit.add_flag("--skirts", flags.skirts,
               "hide gaps between 3D Tiles of different levels behind strips along their edges");
  fit.add_flag("--resume", flags.resume,
               "go on with the tiles that an ended job of the same input and options has left");
  fit.add_option("--cage", flags.cage, "control cage (.ply)")->type_name("FILE");
  fit.add_option("--report", flags.report, "JSON report")->type_name("FILE");
  fit.add_option("--input-format", flags.input_format, "against the extension")
      ->type_name(names_of(FormatUse::ReadMesh, "|"));
  fit.add_flag("-f,--force", flags.force, "overwrite existing files");
  fit.add_option("--tolerance", flags.tolerance,
                 "largest vertex error, relative to the bounding-box diagonal [1e-6]")
      ->type_name("T");
  fit.add_option("--max-iterations", flags.max_iterations, "give up after so many [200]")
      ->type_name("N");
  fit.add_option("--polish", flags.polish,
                 "steps that even out the curvature of a fair surface [8]")
      ->type_name("N");
  fit.add_option("--block-vertices", flags.block, "vertices of a unit of work [65536]")
      ->type_name("N");
  fit.add_option("--watchdog", flags.watchdog,
                 "end the job after so many seconds without progress; 0: never [600]")
      ->type_name("SECONDS");
  for (const WordSetting& setting : word_settings()) {
    const auto allowed = std::ranges::find(kAllowed, setting.name, &Allowed::name);
    add_word_flag(fit, flags.words, setting,
                  allowed == kAllowed.end() ? "" : "Surface (as planish fit)");
  }
  flags.refused.resize(kMissing.size());
  for (std::size_t i = 0; i < kMissing.size(); ++i)
    fit.add_option(kMissing[i].flag, flags.refused[i])->group("");
}

}  // namespace

MpiJob parse_mpi_flags(const std::vector<std::string>& arguments) {
  CLI::App app(
      "Interpolating Doo-Sabin surfaces over many machines: "
      "mpirun -n 4 planish-mpi fit big.ply -o big/tileset.json --cage cage.ply",
      "planish-mpi");
  MpiFlags flags;
  bool wants_version = false;
  app.add_flag("--version", wants_version, "print versions");
  CLI::App& fit = *app.add_subcommand("fit", "mesh in, tiles, control cage and report out");
  CLI::App& run = *app.add_subcommand("run", "")->allow_extras()->group("");
  add_flags(fit, flags);
  MpiJob job;
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
  try {
    app.parse(reversed);
  } catch (const CLI::CallForHelp&) {
    job.text = fit.parsed() ? fit.help() : app.help();
    return job;
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::InvalidArgument, std::string(error.what()) + "; see planish-mpi --help");
  }
  if (wants_version) {
    job.text = version_line();
    return job;
  }
  if (run.parsed()) refuse("run", "scene files are not available in planish-mpi; take fit");
  if (!fit.parsed()) {
    job.text = app.help();
    return job;
  }
  for (std::size_t i = 0; i < kMissing.size(); ++i)
    if (!flags.refused[i].empty()) refuse(kMissing[i].flag, kMissing[i].reason);
  return job_of(flags);
}

void require_writable(const MpiJob& job) {
  if (!job.tiles.empty()) {
    PathClaims claims({.overwrite = job.force});
    claims.add_input(job.input);
    for (const std::string& path : {job.cage, job.report})
      if (!path.empty()) claims.add_output(path, "--cage, --report");
    claims.add_output(job.tiles, "-o");
    claims.add_tile_folder(tile_folder(job.tiles), "-o");
  }
  for (const std::string& path : {job.cage, job.report}) {
    if (path.empty()) continue;
    std::error_code code;
    if (!job.force && std::filesystem::exists(path, code))
      throw Error(ErrorCode::UnwritableOutput, visible(path) + " exists; -f overwrites it");
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder, code))
      throw Error(ErrorCode::UnwritableOutput,
                  visible(path) + ": its folder " + visible(folder.string()) + " is not there");
  }
}

}  // namespace planish::command
