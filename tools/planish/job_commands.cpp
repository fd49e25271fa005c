#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "batch.h"
#include "commands.h"
#include "large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"
#include "planish/job/report.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "scene_file.h"
#include "terminal.h"

namespace planish::command {
namespace {

constexpr const char* kFiles = "Files";
constexpr const char* kSurface = "Surface";
constexpr const char* kPoints = "Points (inputs without faces)";

FileFormat output_format_of(const FitFlags& flags, FormatUse use, FileFormat initial) {
  if (flags.output_format.empty()) return initial;
  for (const FormatInfo& info : formats())
    if (info.name == flags.output_format && serves(info.format, FormatUse::WriteSurface))
      return serves(info.format, use) ? info.format : initial;
  refuse("--output-format", "\"{}\" is not one of {}", visible(flags.output_format),
         names_of(FormatUse::WriteSurface));
}

bool is_of_files(const FitOption& option) {
  return option.stage == OptionStage::Fineness || option.stage == OptionStage::Input;
}

// Of several inputs a name without an extension is a folder that will be made.
bool is_folder(const std::string& path, bool one_of_several) {
  const bool is_new =
      one_of_several && !path.empty() && path != "-" && !path_of(path).has_extension();
  return names_folder(path) || is_new;
}

// Where an output of that input goes: the path itself, or the input's name in a folder.
std::string output_path(const std::string& path, const std::string& input, FileFormat format,
                        const char* flag, bool one_of_several) {
  if (is_folder(path, one_of_several)) return path_in_folder(path, input, format);
  if (!one_of_several) return path;
  if (path == "-") refuse(flag, "stdout takes one surface only, and there are several inputs");
  refuse(flag, "{} is one file, and there are several inputs; name a folder: {} {}/", visible(path),
         flag, visible(path_of(path).stem()));
}

void add_file_flags(CLI::App& command, FitFlags& flags) {
  const auto option = [&](const char* name, auto& target, const std::string& help,
                          const std::string& type) {
    return command.add_option(name, target, help)->type_name(type)->group(kFiles);
  };
  command
      .add_option("INPUT", flags.inputs,
                  "meshes or points (" + extensions_of(FormatUse::Read) +
                      "), folders of them, or - for stdin")
      ->type_name("INPUT...")
      ->required();
  option("-o,--output", flags.outputs,
         "surface (" + extensions_of(FormatUse::WriteSurface) +
             "), - for a GLB on stdout, or a folder to write NAME.glb into; repeatable",
         "FILE")
      ->allow_extra_args(false);
  option("--cage", flags.cage, "cage (" + extensions_of(FormatUse::WriteCage) + "), or a folder",
         "FILE");
  option("--report", flags.report, "JSON report; - for stdout", "FILE");
  for (const FitOption& fineness : option_table())
    if (is_of_files(fineness)) add_option_flag(command, flags.options, fineness, kFiles);
  option("--source", flags.source,
         "compare the surface with this mesh in the report, not with the input", "FILE");
  option("--input-format", flags.input_format,
         "format of stdin, or where the extension is wrong [told by the content]",
         names_of(FormatUse::Read, "|"));
  option("--output-format", flags.output_format,
         "format of files in an output folder [glb; cages obj]",
         names_of(FormatUse::WriteSurface, "|"));
  option("-j,--jobs", flags.workers, "inputs at once; each uses all threads [1]", "N");
  command.add_flag("-f,--force", flags.force, "overwrite existing files")->group(kFiles);
  command
      .add_flag(
          "--dry-run", flags.dry_run,
          "check everything, and say what would be written, how large, in what memory and time")
      ->group(kFiles);
}

}  // namespace

bool has_flag(const FitOption& option) {
  return option.kind != OptionKind::Vertices && option.kind != OptionKind::Edges;
}

void add_fit_flags(CLI::App& command, FitFlags& flags) {
  add_file_flags(command, flags);
  add_page_flags(command, {flags.page, flags.page_limit, flags.page_no_times},
                 "HTML page to look at, - for stdout; a folder: a page each and index.html, the "
                 "worst first");
  for (const FitOption& option : option_table())
    if (!is_of_files(option) && has_flag(option))
      add_option_flag(command, flags.options, option, kSurface);
  for (const PointOption& option : point_option_table())
    add_option_flag(command, flags.options, option, kPoints);
  flags.memory.add_to(command);
}

std::optional<FileFormat> input_format_of(const FitFlags& flags) {
  if (flags.input_format.empty()) return std::nullopt;
  return parse_input_format(flags.input_format, "--input-format");
}

Settings settings_of(const FitFlags& flags) {
  Settings settings;
  apply_settings(std::vector<NamedSetting>(flags.options.begin(), flags.options.end()), settings);
  if (settings.adaptive.any() && flags.options.contains("levels")) {
    refuse("--levels", "a surface has levels or {}, not both; leave one of them out",
           flag_of_option(settings.adaptive.kinds()[0]));
  }
  check_consistent(settings);
  return settings;
}

int workers_of(const FitFlags& flags) {
  constexpr std::int64_t kMostWorkers = 256;
  if (flags.workers.empty()) return 1;
  std::int64_t workers = 0;
  if (!parse_integer(flags.workers, workers))
    refuse("--jobs", in_double_quotes(flags.workers) + " is no whole number");
  if (workers < 1 || workers > kMostWorkers)
    refuse("--jobs", "{} is out of range; 1 to 256 is wanted", workers);
  return static_cast<int>(workers);
}

namespace {

std::vector<std::string> given_settings(const FitFlags& flags) {
  std::vector<std::string> given;
  for (const auto& [name, text] : flags.options) given.emplace_back(name);
  return given;
}

}  // namespace

Job job_of(const FitFlags& flags, const Settings& settings, const std::string& input,
           bool one_of_several) {
  Job job;
  job.input = input;
  job.name = job_name_of(input);
  job.label = input_name(input);
  job.input_format = input_format_of(flags);
  job.settings = settings;
  job.given_settings = given_settings(flags);
  job.source = flags.source;
  const FileFormat surface = output_format_of(flags, FormatUse::WriteSurface, FileFormat::Glb);
  const FileFormat cage = output_format_of(flags, FormatUse::WriteMesh, FileFormat::Obj);
  for (const std::string& path : flags.outputs)
    job.outputs.push_back(
        surface_request(settings, output_path(path, input, surface, "-o", one_of_several), "-o"));
  if (!flags.cage.empty())
    job.outputs.push_back({.path = output_path(flags.cage, input, cage, "--cage", one_of_several),
                           .kind = OutputKind::Cage,
                           .where = "--cage"});
  return job;
}

namespace {

// Everything is looked at before work starts, and all that is wrong is said at once: first the
// inputs, then flags, then what would be written.
struct FitPlan {
  InputList inputs;
  std::vector<PlannedJob> jobs;
  DeviceList devices;
  PathClaims claims;
  PageOptions page{};
};

bool is_batch(const FitPlan& plan) {
  return plan.inputs.has_folder || plan.inputs.paths.size() > 1;
}

// A folder has a page of each input and, of several, a contact sheet.
bool has_page_folder(const FitFlags& flags, const FitPlan& plan) {
  return is_folder(flags.page, is_batch(plan));
}
std::string page_of_input(const FitFlags& flags, const std::string& input) {
  std::filesystem::path path = path_of(path_in_folder(flags.page, input, FileFormat::Glb));
  return utf8(path.replace_extension(".html"));
}
bool has_page_of_all(const FitFlags& flags, const FitPlan& plan) {
  return !flags.page.empty() && (is_batch(plan) || !has_page_folder(flags, plan));
}
std::string page_of_all(const FitFlags& flags, const FitPlan& plan) {
  if (!has_page_folder(flags, plan)) return flags.page;
  return utf8(path_of(flags.page) / "index.html");
}

// `planish fit -- a.obj -o b.glb`, `planish fit a.obj b.glb`: slips that end among the inputs.
std::string slip_among_inputs(const FitFlags& flags, const std::string& path) {
  std::error_code error;
  if (path == "-" || std::filesystem::exists(path_of(path), error)) return {};
  if (path.starts_with('-'))
    return visible(path) + " stands after --, where flags end; put flags before it";
  const auto format = format_of(path_of(path));
  const bool could_be_output = format && serves(*format, FormatUse::WriteSurface);
  if (flags.inputs.size() > 1 && path != flags.inputs.front() && could_be_output &&
      flags.outputs.empty())
    return formatted("{}: no such input; did you mean -o {}?", visible(path), visible(path));
  return {};
}

void check_inputs(const FitFlags& flags, const FitPlan& plan, std::optional<FileFormat> format,
                  Faults& faults) {
  for (const std::string& path : plan.inputs.paths) {
    faults.note([&] {
      const std::string slip = slip_among_inputs(flags, path);
      if (!slip.empty()) throw Error(ErrorCode::InvalidArgument, slip);
      require_readable(path, format);
    });
  }
  if (is_batch(plan)) faults.note([&] { require_distinct_stems(plan.inputs.paths); });
}

// What to type where nothing is to be written.
std::string nothing_to_write(const FitPlan& plan) {
  const std::string& first = plan.inputs.paths.empty() ? "mesh.obj" : plan.inputs.paths.front();
  const std::string line =
      is_batch(plan) ? "planish fit ... -o out/"
                     : formatted("planish fit {} -o {}", visible(first), output_beside(first));
  return "nothing to write; did you mean: " + line +
         "  (or --cage FILE, --page FILE, --report FILE)";
}

std::optional<FileFormat> requested_format(const FitFlags& flags, Faults& faults) {
  try {
    return input_format_of(flags);
  } catch (const Error& error) {
    faults.add(error);
    return std::nullopt;
  }
}

FitPlan plan_fit(const FitFlags& flags) {
  Faults faults;
  faults.note([&] { (void)workers_of(flags); });
  InputList inputs;
  const std::optional<FileFormat> format = requested_format(flags, faults);
  faults.note([&] { inputs = expand_inputs(flags.inputs); });
  const bool into_folders = inputs.paths.size() > 1 || inputs.has_folder ||
                            std::ranges::any_of(flags.outputs, names_folder) ||
                            names_folder(flags.cage) || names_folder(flags.page);
  FitPlan plan{.inputs = std::move(inputs),
               .jobs = {},
               .devices = {},
               .claims = PathClaims({.overwrite = flags.force,
                                     .create_folders = into_folders,
                                     .only_note = flags.dry_run,
                                     .stdout_is_terminal = stdout_is_terminal()})};
  PathClaims& claims = plan.claims;
  check_inputs(flags, plan, format, faults);
  Settings settings;
  faults.note([&] { settings = settings_of(flags); });
  const bool slipped = std::ranges::any_of(plan.inputs.paths, [&](const std::string& path) {
    return !slip_among_inputs(flags, path).empty();
  });
  if (!slipped && flags.outputs.empty() && flags.cage.empty() && flags.report.empty() &&
      flags.page.empty())
    faults.note([&] { throw Error(ErrorCode::InvalidArgument, nothing_to_write(plan)); });
  for (const std::string& path : plan.inputs.paths)
    claims.add_input(path_of(path), format, settings.textures);
  if (!flags.source.empty()) {
    faults.note([&] { require_readable(flags.source, {}); });
    claims.add_input(path_of(flags.source), {}, settings.textures);
  }
  for (const std::string& path : plan.inputs.paths) {
    PlannedJob planned;
    faults.note([&] { planned.job = job_of(flags, settings, path, is_batch(plan)); });
    claim_outputs(planned, claims, faults);
    if (has_page_folder(flags, plan)) {
      planned.job.page = page_of_input(flags, path);
      faults.note([&] { claims.add_page(path_of(planned.job.page), "--page"); });
    }
    plan.jobs.push_back(std::move(planned));
  }
  if (!flags.report.empty())
    faults.note([&] { claims.add_report(path_of(flags.report), "--report"); });
  if (has_page_of_all(flags, plan))
    faults.note([&] { claims.add_page(path_of(page_of_all(flags, plan)), "--page"); });
  faults.note([&] { plan.page = page_options(flags.page_limit, flags.page_no_times); });
  faults.note([&] { plan.devices = settle_devices(plan.jobs); });
  faults.throw_if_any();
  return plan;
}

ExitCode run_one(const FitFlags& flags, const FitPlan& plan, Console& console,
                 const std::vector<std::string>& arguments) {
  PlannedJob planned = plan.jobs.front();
  planned.job.report = flags.report;
  if (planned.job.page.empty()) planned.job.page = flags.page;
  const auto backend = open_backend(plan.devices.devices[planned.device], planned.job.settings);
  Progress progress(console, flags.messages.progress_mode());
  JobDisplay display(progress, planned.job.name);
  planned.job.page_options = plan.page;
  planned.job.digests = is_reported(planned.job);
  planned.job.arguments = arguments;
  planned.job.mesher = require_counted_mesher;
  const JobReport report =
      run_job(planned.job, planned.outputs, *backend, watch_of(console, display)).report;
  progress.finish();
  console.info(summary(report, console.level() == LogLevel::Debug));
  if (console.is_terminal()) console.info(next_step(report));
  return exit_code_of(report);
}

ExitCode run_several(const FitFlags& flags, const FitPlan& plan, Console& console,
                     const std::vector<std::string>& arguments) {
  const bool wants_sheet = has_page_folder(flags, plan);
  auto outcomes = run_batch(plan.jobs, plan.devices, console,
                            {.workers = workers_of(flags),
                             .progress = flags.messages.progress_mode(),
                             .arguments = arguments,
                             .page = plan.page,
                             .wants_page = !flags.page.empty() && !wants_sheet,
                             .wants_sheet = wants_sheet,
                             .wants_report = !flags.report.empty()});
  console.info(files_table(plan.jobs, outcomes));
  if (!flags.report.empty())
    write_batch_report(flags.report, batch_json(plan.jobs, outcomes, arguments), flags.force);
  const std::string page = page_of_all(flags, plan);
  if (wants_sheet) {
    write_batch_sheet(page, plan.jobs, outcomes, plan.page, console, flags.force, "file");
  } else if (!page.empty()) {
    write_batch_page(page, outcomes, plan.page, console, flags.force);
  }
  const ExitCode exit_code = exit_code_of(outcomes);
  if (exit_code != ExitCode::Done) console.error(failed_jobs_text(outcomes));
  return exit_code;
}

ExitCode run_fit_command(const FitFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  const FitPlan plan = plan_fit(flags);
  flags.memory.apply(flags.outputs.empty() ? flags.cage : flags.outputs.front());
  if (flags.dry_run)
    return describe_jobs(
        plan.jobs, plan.devices, plan.claims,
        {flags.report, has_page_of_all(flags, plan) ? page_of_all(flags, plan) : "",
         plan.page.limit_bytes});
  return is_batch(plan) ? run_several(flags, plan, console, arguments)
                        : run_one(flags, plan, console, arguments);
}

}  // namespace

void add_fit_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command =
      app.add_subcommand("fit", "a mesh or points in, the smooth surface through all vertices out");
  auto flags = std::make_shared<FitFlags>();
  add_fit_flags(*command, *flags);
  flags->messages.add_to(*command, true);
  invocation.texts["fit"] = {
      .examples = {"planish fit bunny.obj -o bunny.glb",
                   "planish fit bunny.obj -o bunny.glb --levels 3,1 --cage cage.obj",
                   "planish fit *.obj scans/ -o out/ -j 4 --report out/all.json",
                   "planish fit bunny.obj --page bunny.html",
                   "planish fit bunny.obj -o bunny.ply --preset paper --device cpu",
                   "cat bunny.obj | planish fit - -o - > bunny.glb"},
      .first_flags = {"--output", "--page", "--cage", "--report", "--levels", "--tolerance",
                      "--interpolation", "--creases", "--device", "--force", "--jobs", "-h",
                      "--help"},
      .notes =
          "--levels auto: dense is a mesh of 20,000 vertices or more, where faces of 3/4 of its "
          "area turn by less than 20 degrees to each neighbour. Exit codes: 0 done; 1 internal "
          "error; 2 usage; 3 input unreadable; 4 mesh unusable; "
          "5 not converged (files are written, and flagged); 6 no device, program or memory; 7 "
          "an output exists, is a folder, has no folder or cannot be written; 8 some of several "
          "inputs failed; 130 and 143 interrupted."};
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] {
      return run_fit_command(*flags, invocation.arguments);
    };
  });
}

namespace {

struct RunFlags {
  std::string scene, device, report, page, page_limit;
  std::vector<std::string> names;
  bool force = false, dry_run = false, json = false, page_no_times = false;
  MessageFlags messages;

  /// Where the report of all jobs goes; empty: nowhere.
  [[nodiscard]] std::string report_path() const { return json ? "-" : report; }
};

// A mesh in the place of a scene.
void require_scene(const std::string& path) {
  const auto format = format_of(path_of(path));
  if (!format || info_of(*format).is_tiles) return;
  const std::filesystem::path stem = path_of(path).stem();
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: is no scene file; did you mean: planish fit {} -o {}.glb",
                        visible(path), visible(path), visible(stem)));
}

// The names of jobs are no paths.
std::string page_in_folder(const std::string& folder, std::string name) {
  std::ranges::replace(name, '/', '_');
  return utf8(path_of(folder) / path_of(name + ".html"));
}

// The jobs as the flags change them.
std::vector<PlannedJob> wanted_jobs(const RunFlags& flags) {
  require_scene(flags.scene);
  std::vector<PlannedJob> planned;
  for (Job& job : select_jobs(read_scene_file(path_of(flags.scene)), flags.names)) {
    if (!flags.device.empty()) {
      job.settings.device = flags.device;
      check_consistent(job.settings);
    }
    planned.push_back({.job = std::move(job), .outputs = {}});
  }
  // A folder has a page of each job, where the scene has no place for it.
  if (names_folder(flags.page))
    for (PlannedJob& one : planned)
      if (one.job.page.empty()) one.job.page = page_in_folder(flags.page, one.job.name);
  return planned;
}

// Of a folder the contact sheet.
std::string page_of_scene(const std::string& page) {
  return names_folder(page) ? utf8(path_of(page) / "index.html") : page;
}

void claim_files(const RunFlags& flags, std::vector<PlannedJob>& jobs, PathClaims& claims) {
  Faults faults;
  claims.add_input(path_of(flags.scene));
  for (const PlannedJob& planned : jobs) {
    const FileReach reach = planned.job.settings.textures;
    claims.add_input(path_of(planned.job.input), planned.job.input_format, reach);
    if (!planned.job.source.empty()) claims.add_input(path_of(planned.job.source), {}, reach);
  }
  for (PlannedJob& planned : jobs) {
    const Job& job = planned.job;
    claim_outputs(planned, claims, faults);
    if (!job.report.empty())
      faults.note([&] { claims.add_report(path_of(job.report), "report of job " + job.name); });
    if (!job.page.empty())
      faults.note([&] { claims.add_page(path_of(job.page), "page of job " + job.name); });
  }
  if (flags.json && !flags.report.empty())
    faults.note(
        [] { throw Error(ErrorCode::InvalidArgument, "--json is --report -; give one of them"); });
  if (!flags.report_path().empty())
    faults.note([&] { claims.add_report(path_of(flags.report_path()), "--report"); });
  if (!flags.page.empty())
    faults.note([&] { claims.add_page(path_of(page_of_scene(flags.page)), "--page"); });
  faults.throw_if_any();
}

ExitCode run_scene(const RunFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  std::vector<PlannedJob> jobs = wanted_jobs(flags);
  PathClaims claims({.overwrite = flags.force,
                     .create_folders = true,
                     .only_note = flags.dry_run,
                     .stdout_is_terminal = stdout_is_terminal()});
  claim_files(flags, jobs, claims);
  const PageOptions page = page_options(flags.page_limit, flags.page_no_times);
  const DeviceList devices = settle_devices(jobs);
  if (flags.dry_run)
    return describe_jobs(jobs, devices, claims,
                         {flags.report_path(), page_of_scene(flags.page), page.limit_bytes});
  const bool wants_sheet = names_folder(flags.page);
  auto outcomes = run_batch(jobs, devices, console,
                            {.workers = 1,
                             .progress = flags.messages.progress_mode(),
                             .arguments = arguments,
                             .page = page,
                             .wants_page = !flags.page.empty() && !wants_sheet,
                             .wants_sheet = wants_sheet,
                             .wants_report = !flags.report_path().empty()});
  if (wants_sheet) {
    write_batch_sheet(page_of_scene(flags.page), jobs, outcomes, page, console, flags.force, "job");
  } else if (!flags.page.empty()) {
    write_batch_page(flags.page, outcomes, page, console, flags.force);
  }
  const std::string report = flags.report_path();
  if (!report.empty())
    write_batch_report(report, batch_json(jobs, outcomes, arguments), flags.force);
  if (report == "-" || flags.page == "-") {
    console.info(batch_table(jobs, outcomes));
  } else if (console.level() >= LogLevel::Info) {
    write_text(batch_table(jobs, outcomes));
  }
  const ExitCode exit_code = exit_code_of(outcomes);
  if (exit_code != ExitCode::Done) console.error(failed_jobs_text(outcomes));
  return exit_code;
}

}  // namespace

void add_run_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand("run", "the jobs of a scene file, and a table of them");
  auto flags = std::make_shared<RunFlags>();
  const char* group = "Jobs";
  command->add_option("SCENE", flags->scene, "scene file (JSON)")->type_name("SCENE")->required();
  command->add_option("JOB", flags->names, "names of jobs; all where none is named")
      ->type_name("[JOB...]");
  command->add_option("--device", flags->device, "for all jobs, whatever the scene says")
      ->type_name("auto|cpu|vulkan|INDEX|NAME|UUID")
      ->group(group);
  command->add_option("--report", flags->report, "one JSON report of all jobs; - for stdout")
      ->type_name("FILE")
      ->group(group);
  add_page_flags(
      *command, {flags->page, flags->page_limit, flags->page_no_times},
      "HTML page to look at: surfaces in 3-D, figures, plots; - for stdout; a folder/: a "
      "page each and index.html, the worst first");
  command->add_flag("--json", flags->json, "the same as --report -")->group(group);
  command->add_flag("-f,--force", flags->force, "overwrite existing files")->group(group);
  command
      ->add_flag("--dry-run", flags->dry_run,
                 "check everything, and say what would be written, how large, in what memory and "
                 "time")
      ->group(group);
  flags->messages.add_to(*command, true);
  invocation.texts["run"] = {
      .examples = {"planish run scenes/table1.json",
                   "planish run scenes/table1.json --page out/table1.html --force",
                   "planish run scenes/table1.json goblet arm --force"},
      .first_flags = {},
      .notes =
          "scene.schema.json, installed with planish, describes the file.\n"
          "Exit codes are those of planish fit, and 8 when some jobs failed: the others are "
          "done."};
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_scene(*flags, invocation.arguments); };
  });
}

}  // namespace planish::command
