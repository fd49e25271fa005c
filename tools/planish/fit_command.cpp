#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "commands.h"
#include "job/batch.h"
#include "job/describe_job.h"
#include "memory/large_arrays.h"
#include "options/fit_flags.h"
#include "options/input_list.h"
#include "options/page_flags.h"
#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/job/details.h"
#include "planish/job/point_input.h"
#include "terminal/faults.h"
#include "terminal/watch.h"

namespace planish::command {
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

// `planish fit -- a.obj -o b.glb`, `planish fit a.obj b.glb`: slips that end among the inputs.
std::string slip_among_inputs(const FitFlags& flags, const std::string& path) {
  std::error_code error;
  if (path == "-" || std::filesystem::exists(path, error)) return {};
  if (path.starts_with('-'))
    return visible(path) + " stands after --, where flags end; put flags before it";
  const auto format = format_of(path);
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
                            names_folder(flags.cage);
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
    claims.add_input(path, format, settings.textures);
  if (!flags.source.empty()) {
    faults.note([&] { require_readable(flags.source, {}); });
    claims.add_input(flags.source, {}, settings.textures);
  }
  for (const std::string& path : plan.inputs.paths) {
    PlannedJob planned;
    faults.note([&] { planned.job = job_of(flags, settings, path, is_batch(plan)); });
    claim_outputs(planned, claims, faults);
    plan.jobs.push_back(std::move(planned));
  }
  if (!flags.report.empty()) faults.note([&] { claims.add_report(flags.report, "--report"); });
  if (!flags.page.empty()) {
    faults.note([&] { claims.add_page(flags.page, "--page"); });
  }
  faults.note([&] { plan.page = page_options(flags.page_limit, flags.page_no_times); });
  faults.note([&] { plan.devices = settle_devices(plan.jobs); });
  faults.throw_if_any();
  return plan;
}

ExitCode run_one(const FitFlags& flags, const FitPlan& plan, Console& console,
                 const std::vector<std::string>& arguments) {
  PlannedJob planned = plan.jobs.front();
  planned.job.report = flags.report;
  planned.job.page = flags.page;
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
  auto outcomes = run_batch(plan.jobs, plan.devices, console,
                            {.workers = workers_of(flags),
                             .progress = flags.messages.progress_mode(),
                             .arguments = arguments,
                             .page = plan.page,
                             .wants_page = !flags.page.empty(),
                             .wants_report = !flags.report.empty()});
  console.info(files_table(plan.jobs, outcomes));
  if (!flags.report.empty())
    write_batch_report(flags.report, batch_json(plan.jobs, outcomes, arguments), flags.force);
  if (!flags.page.empty()) write_batch_page(flags.page, outcomes, plan.page, console, flags.force);
  const ExitCode exit_code = exit_code_of(outcomes);
  if (exit_code != ExitCode::Done) console.error(failed_jobs_text(outcomes));
  return exit_code;
}

ExitCode run_fit_command(const FitFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  const FitPlan plan = plan_fit(flags);
  flags.memory.apply(flags.outputs.empty() ? flags.cage : flags.outputs.front());
  if (flags.dry_run)
    return describe_jobs(plan.jobs, plan.devices, plan.claims,
                         {flags.report, flags.page, plan.page.limit_bytes});
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

}  // namespace planish::command
