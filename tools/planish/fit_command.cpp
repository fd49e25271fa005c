#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <map>
#include <memory>

#include "commands.h"
#include "devices.h"
#include "job/input.h"
#include "job/job.h"
#include "job/point_input.h"
#include "options/point_settings.h"
#include "page/page_job.h"
#include "planish/core/error.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct FitFlags {
  std::string input, input_format, cage, source, report, levels, page, page_limit;
  std::vector<std::string> outputs;
  std::map<std::string_view, std::string> words;  ///< by name of the setting
  double tolerance = Settings{}.tolerance;
  std::int64_t max_iterations = Settings{}.max_iterations;
  std::int64_t polish_steps = Settings{}.polish_steps;
  bool force = false, dry_run = false, page_no_times = false;
  MessageFlags messages;
};

constexpr const char* kFitExamples =
    "Examples:\n"
    "  planish fit bunny.obj -o bunny.glb\n"
    "  planish fit bunny.obj -o bunny.glb --levels 3,1 --cage cage.obj --report bunny.json\n"
    "  planish fit bunny.obj --page bunny.html       # to look at, in any browser\n"
    "  planish fit bunny.obj -o bunny.ply --preset paper --device cpu\n"
    "  cat bunny.obj | planish fit - --input-format obj -o - > bunny.glb\n"
    "Exit codes: 0 done, 1 internal error, 2 usage, 3 input unreadable, 4 mesh unusable,\n"
    "  5 not converged (files are written), 6 no device or memory, 7 output not writable,\n"
    "  130 and 143 interrupted.\n";

std::vector<int> parse_levels(const std::string& text) {
  std::vector<std::int64_t> values;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    std::int64_t value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && *next != ',')) {
      throw Error(ErrorCode::InvalidArgument,
                  "--levels: \"" + plain_utf8(text) + "\" is no list of levels such as 2 or 3,1");
    }
    values.push_back(value);
    if (next == end) break;
    at = next + 1;
  }
  return checked_levels(values, "--levels");
}

Settings settings_of(const FitFlags& flags) {
  Settings settings;
  for (const WordSetting& setting : word_settings()) {
    const auto given = flags.words.find(setting.name);
    if (given != flags.words.end() && !given->second.empty()) {
      setting.set(settings, given->second, flag_of(setting.name));
    }
  }
  for (const PointSetting& setting : point_settings()) {
    const auto given = flags.words.find(setting.name);
    if (given != flags.words.end() && !given->second.empty()) {
      setting.set(settings.points, given->second, flag_of(setting.name));
    }
  }
  set_tolerance(settings, flags.tolerance, "--tolerance");
  set_max_iterations(settings, flags.max_iterations, "--max-iterations");
  set_polish_steps(settings, flags.polish_steps, "--polish");
  if (!flags.levels.empty()) settings.levels = parse_levels(flags.levels);
  check_consistent(settings);
  return settings;
}

Job job_of(const FitFlags& flags) {
  Job job;
  job.input = flags.input;
  job.name = flags.input == "-" ? "stdin" : std::filesystem::path(flags.input).stem().string();
  if (!flags.input_format.empty()) {
    job.input_format = parse_mesh_format(flags.input_format, "--input-format");
  }
  require_readable(job.input, job.input_format);
  job.settings = settings_of(flags);
  for (const std::string& path : flags.outputs) {
    job.outputs.push_back({path, OutputKind::Surface, job.settings.levels, "-o"});
  }
  if (!flags.cage.empty()) job.outputs.push_back({flags.cage, OutputKind::Cage, {}, "--cage"});
  job.source = flags.source;
  job.report = flags.report;
  job.page = flags.page;
  if (!job.page.empty()) require_page_path(job.page, "--page");
  if (job.outputs.empty() && job.report.empty() && job.page.empty()) {
    throw Error(ErrorCode::InvalidArgument,
                "nothing to write: name a file with -o, --cage, --report or --page");
  }
  return job;
}

ExitCode run_fit(const FitFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode());
  const Job job = job_of(flags);
  PathClaims claims({.overwrite = flags.force});
  claims.add_input(job.input);
  if (!job.source.empty()) claims.add_input(job.source);
  std::vector<PlannedOutput> outputs;
  for (const OutputRequest& request : job.outputs) {
    for (PlannedOutput& planned : plan_output(request, claims)) {
      outputs.push_back(std::move(planned));
    }
  }
  if (job.settings.attributes.any()) require_attribute_formats(outputs);
  if (!job.report.empty()) claims.add_output(job.report, "--report");
  if (!job.page.empty()) claims.add_output(job.page, "--page");
  const PageOptions page = page_options(flags.page_limit, flags.page_no_times);
  const DeviceList list = list_devices(scope_of(job.settings));
  const ListedDevice& device = list.devices[choose_device(list, job.settings)];
  if (flags.dry_run) {
    describe_job(job, outputs, device.description);
    return ExitCode::Done;
  }
  const std::unique_ptr<Backend> backend = open_backend(device, job.settings);
  Progress progress(console, flags.messages.progress_mode());
  const JobReport report = run_job(job, outputs, *backend, {console, progress, arguments, page});
  console.info(summary(report));
  return report.exit_code;
}

void add_setting_flags(CLI::App& command, FitFlags& flags) {
  for (const WordSetting& setting : word_settings()) {
    std::string help(setting.help);
    if (!setting.initial.empty()) help += " [" + std::string(setting.initial) + "]";
    command.add_option(flag_of(setting.name), flags.words[setting.name], help)
        ->type_name(std::string(setting.choices))
        ->group("Solve");
  }
  for (const PointSetting& setting : point_settings()) {
    std::string help(setting.help);
    if (!setting.initial.empty()) help += " [" + std::string(setting.initial) + "]";
    command.add_option(flag_of(setting.name), flags.words[setting.name], help)
        ->type_name(std::string(setting.choices))
        ->group("Points");
  }
  command
      .add_option("--tolerance", flags.tolerance,
                  "largest vertex error, relative to the bounding-box diagonal [1e-6]")
      ->type_name("T")
      ->group("Solve");
  command.add_option("--max-iterations", flags.max_iterations, "give up after so many [200]")
      ->type_name("N")
      ->group("Solve");
  command
      .add_option("--polish", flags.polish_steps,
                  "steps that even out the curvature of a fair surface [8]")
      ->type_name("N")
      ->group("Solve");
}

void add_file_flags(CLI::App& command, FitFlags& flags) {
  command
      .add_option("INPUT", flags.input,
                  "mesh: " + extensions_of(FormatUse::ReadMesh) +
                      ", - for stdin; or points: " + extensions_of(FormatUse::ReadPoints))
      ->type_name("")
      ->required();
  command
      .add_option("-o,--output", flags.outputs,
                  "surface: " + extensions_of(FormatUse::WriteSurface) +
                      "; - for a GLB on stdout; repeatable")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command.add_option("--cage", flags.cage, "control cage: " + extensions_of(FormatUse::WriteCage))
      ->type_name("FILE");
  command
      .add_option("--source", flags.source,
                  "mesh that the surface stands for: the report compares with it, not the input")
      ->type_name("FILE");
  command.add_option("--report", flags.report, "JSON report; - for stdout")->type_name("FILE");
  add_page_flags(command, {flags.page, flags.page_limit, flags.page_no_times});
  command
      .add_option("--levels", flags.levels,
                  "quad splits, 0 to 6 [2]; several write NAME_LOD0.glb, NAME_LOD1.glb, ...")
      ->type_name("L[,L2,...]");
  command.add_option("--input-format", flags.input_format, "of stdin, or against the extension")
      ->type_name(names_of(FormatUse::ReadMesh, "|"));
  command.add_flag("-f,--force", flags.force, "overwrite existing files");
  command.add_flag("--dry-run", flags.dry_run, "check everything and say what would be done");
}

}  // namespace

void add_fit_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command =
      app.add_subcommand("fit", "a mesh or points in, the smooth surface through all vertices out");
  auto flags = std::make_shared<FitFlags>();
  add_file_flags(*command, *flags);
  add_setting_flags(*command, *flags);
  flags->messages.add_to(*command, true);
  command->footer(kFitExamples);
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_fit(*flags, invocation.arguments); };
  });
}

}  // namespace planish::command
