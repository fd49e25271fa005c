#include <CLI/CLI.hpp>
#include <memory>

#include "commands.h"
#include "large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/platform/machine.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/build_info.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"
#include "planish/job/output_plan.h"
#include "planish/job/staged_files.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "terminal.h"

namespace planish::command {
namespace {

struct ReconstructFlags {
  std::string input, input_format, report;
  std::vector<std::string> outputs;
  OptionTexts options;
  bool force = false;
  MemoryFlags memory;
  MessageFlags messages;
};

FileFormat output_format(const std::string& path) {
  const auto format = format_of(path_of(path));
  if (format && serves(*format, FormatUse::WriteMesh)) return *format;
  throw Error(ErrorCode::InvalidArgument,
              formatted("-o: {}: the extension is none of a mesh that is written ({})",
                        visible(path), names_of(FormatUse::WriteMesh)));
}

// A PLY may be one of a mesh: its vertices are points all the same.
PointInput read_cloud(const std::string& path, std::optional<FileFormat> format, bool has_report,
                      const Callbacks& callbacks) {
  InputFile file = load_input(path, format, callbacks);
  if (has_report) file.take_digest();
  return points_of(file, callbacks);
}

void write_reconstruction(const ReconstructFlags& flags, const std::vector<std::string>& arguments,
                          const PointInput& input, const Reconstruction& result,
                          const std::vector<Warning>& warnings, StagedFiles& staged) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.report/1";
  json["tool"] = {{"name", "planish"}, {"version", PLANISH_VERSION}, {"git", git_revision()}};
  json["argv"] = arguments;
  json["exit_code"] = 0;
  json["input"] = {
      {"path", flags.input}, {"sha256", input.sha256}, {"format", name_of(input.format)}};
  json["reconstruction"] = to_json(facts_of(input, result));
  json["outputs"] = flags.outputs;
  json["memory"] = {{"host_peak_bytes", platform::peak_memory()}};
  json["warnings"] = nlohmann::ordered_json::array();
  for (const Warning& w : warnings)
    json["warnings"].push_back(
        {{"code", w.code}, {"message", w.message}, {"count", w.count}, {"first", w.first}});
  if (flags.report == "-") {
    write_stdout(json_text(json));
    return;
  }
  staged.write(path_of(flags.report), json_text(json));
}

ReconstructOptions reconstruct_options(const ReconstructFlags& flags) {
  ReconstructOptions options;
  apply_flags(flags.options, point_option_table(), options);
  FitSettings settings;
  apply_flags(flags.options, option_table(), settings);
  options.pair_quads = settings.quads != QuadChoice::Off;
  return options;
}

std::optional<FileFormat> input_format_of(const ReconstructFlags& flags) {
  if (flags.input_format.empty()) return std::nullopt;
  return parse_input_format(flags.input_format, "--input-format");
}

// All that is wrong before work, at once.
void check_files(const ReconstructFlags& flags) {
  Faults faults;
  faults.note([&] { require_readable(flags.input, input_format_of(flags)); });
  faults.note([&] { (void)reconstruct_options(flags); });
  if (flags.outputs.empty() && flags.report.empty())
    faults.note([&] {
      throw Error(ErrorCode::InvalidArgument,
                  formatted("nothing to write; did you mean: planish reconstruct {} -o {}.obj",
                            visible(flags.input), job_name_of(flags.input)));
    });
  PathClaims claims({.overwrite = flags.force});
  claims.add_input(path_of(flags.input), input_format_of(flags));
  for (const std::string& path : flags.outputs) {
    faults.note([&] {
      (void)output_format(path);
      claims.add_output(path_of(path), "-o");
    });
  }
  if (!flags.report.empty())
    faults.note([&] { claims.add_report(path_of(flags.report), "--report"); });
  faults.note([] { (void)require_mesher(); });
  faults.throw_if_any();
}

ExitCode run_reconstruct(const ReconstructFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  check_files(flags);
  flags.memory.apply(flags.outputs.empty() ? flags.report : flags.outputs.front());
  ReconstructOptions options = reconstruct_options(flags);
  Progress all(console, flags.messages.progress_mode());
  JobDisplay display(all, job_name_of(flags.input));
  JobProgress progress(display.visit());
  progress.plan({{"read", 2}, {"points", 100}});
  std::vector<Warning> warnings;
  options.callbacks.progress = [&](std::string_view step, double fraction) {
    progress.update(step, fraction);
  };
  options.callbacks.warning = [&](const Warning& warning) {
    warnings.push_back(warning);
    console.warning(named_message(input_name(flags.input), warning.message));
  };
  const PointInput input =
      read_cloud(flags.input, input_format_of(flags), !flags.report.empty(), options.callbacks);
  progress.update("points", 0);
  const Reconstruction result = reconstruct_input(input, require_counted_mesher(), options);
  StagedFiles staged(flags.force);
  for (const std::string& path : flags.outputs) {
    const std::filesystem::path target = staged.stage(path_of(path));
    staged.naming_targets([&] { write_mesh(target, output_format(path), result.mesh); });
  }
  all.finish();
  check_interrupt();
  if (!flags.report.empty())
    write_reconstruction(flags, arguments, input, result, warnings, staged);
  staged.commit();
  console.info(input.name + "\n" + points_text(facts_of(input, result)));
  return ExitCode::Done;
}

}  // namespace

void add_reconstruct_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command =
      app.add_subcommand("reconstruct", "points in, a polygon mesh within a tolerance of them out");
  auto flags = std::make_shared<ReconstructFlags>();
  const char* group = "Files";
  command
      ->add_option("POINTS", flags->input,
                   "points: " + extensions_of(FormatUse::ReadPoints) + "; - for stdin")
      ->type_name("POINTS")
      ->required();
  command
      ->add_option("-o,--output", flags->outputs,
                   "mesh: " + extensions_of(FormatUse::WriteMesh) + "; repeatable")
      ->type_name("FILE")
      ->group(group)
      ->allow_extra_args(false);
  command->add_option("--report", flags->report, "JSON report; - for stdout")
      ->type_name("FILE")
      ->group(group);
  command
      ->add_option("--input-format", flags->input_format,
                   "format of stdin, or where the extension is wrong [told by the content]")
      ->type_name(names_of(FormatUse::ReadPoints, "|"))
      ->group(group);
  command->add_flag("-f,--force", flags->force, "overwrite existing files")->group(group);
  for (const PointOption& option : point_option_table())
    add_option_flag(*command, flags->options, option, "Points");
  add_option_flag(*command, flags->options, fit_option("quads"), "Points");
  flags->memory.add_to(*command);
  flags->messages.add_to(*command, true);
  invocation.texts["reconstruct"] = {
      .examples =
          {"planish reconstruct scan.ply -o mesh.obj",
           "planish reconstruct scan.xyz -o mesh.ply --tolerance-mesh 1e-3 --report scan.json",
           "planish reconstruct noisy.pcd -o mesh.obj --smooth 2 --spacing even"},
      .first_flags = {},
      .notes =
          "The first mesh of the points is the work of the program planish-reconstruct, which this "
          "command and planish fit start: beside planish, on PATH, or where the environment "
          "variable "
          "PLANISH_RECONSTRUCT says. It takes no flags, reads points from standard input and "
          "writes "
          "triangles to standard output, both binary. It alone of planish is under the GNU General "
          "Public License, version 3 or later, because CGAL's surface reconstruction is part of "
          "it.\n"
          "Exit codes: 0 done; 2 usage; 3 input unreadable; 4 no surface in the points; 6 no "
          "planish-reconstruct or no memory; 7 an output exists, has no folder or cannot be "
          "written; 130 and 143 interrupted."};
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] {
      return run_reconstruct(*flags, invocation.arguments);
    };
  });
}

}  // namespace planish::command
