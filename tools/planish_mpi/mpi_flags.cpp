#include "mpi_flags.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "help/manual.h"
#include "mpi_options.h"
#include "options/fit_flags.h"
#include "planish/core/formatted.h"
#include "planish/core/lower_case.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/core/version.h"
#include "planish/core/visible_text.h"
#include "planish/job/build_info.h"
#include "planish/job/input.h"
#include "planish/pipeline/option_table.h"

namespace planish::command {
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
    refuse("--watchdog", "\"" + visible(text) + "\" is no number of seconds from 0");
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
  add_page_flags(run, {rest.page, rest.page_limit, rest.page_no_times});
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
