#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "build_info.h"
#include "commands.h"
#include "job/point_input.h"
#include "options/point_settings.h"
#include "output/output_plan.h"
#include "output/staged_files.h"
#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "planish/core/version.h"
#include "report/report.h"
#include "terminal/interrupt.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct ReconstructFlags {
  std::string input, report;
  std::vector<std::string> outputs;
  std::map<std::string_view, std::string> words;  ///< by name of the setting
  bool force = false;
  MessageFlags messages;
};

constexpr const char* kReconstructExamples =
    "Examples:\n"
    "  planish reconstruct scan.ply -o mesh.obj\n"
    "  planish reconstruct scan.xyz -o mesh.ply --tolerance-mesh 1e-3 --report scan.json\n"
    "  planish reconstruct noisy.pcd -o mesh.obj --smooth 2 --spacing even\n"
    "Exit codes: 0 done, 2 usage or no planish-reconstruct, 3 input unreadable, 4 no surface in\n"
    "  the points, 6 no memory, 7 output not writable, 130 and 143 interrupted.\n";

FileFormat output_format(const std::string& path) {
  const auto format = format_of(path);
  if (format && serves(*format, FormatUse::WriteCage)) return *format;
  throw Error(ErrorCode::InvalidArgument,
              "-o: " + path + ": the extension is none of a mesh that is written (" +
                  names_of(FormatUse::WriteCage) + ")");
}

void write_report(const ReconstructFlags& flags, const std::vector<std::string>& arguments,
                  const PointInput& input, const Reconstruction& result,
                  const std::vector<Warning>& warnings, StagedFiles& staged) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.report/1";
  json["tool"] = {{"name", "planish"}, {"version", PLANISH_VERSION}, {"git", kGitRevision}};
  json["argv"] = arguments;
  json["exit_code"] = 0;
  json["input"] = {
      {"path", flags.input}, {"sha256", input.sha256}, {"format", name_of(input.format)}};
  json["reconstruction"] = reconstruction_json(input, result);
  json["outputs"] = flags.outputs;
  json["memory"] = {{"host_peak_bytes", peak_host_bytes()}};
  json["warnings"] = nlohmann::ordered_json::array();
  for (const Warning& w : warnings)
    json["warnings"].push_back(
        {{"code", w.code}, {"message", w.message}, {"count", w.count}, {"first", w.first}});
  if (flags.report == "-") {
    write_stdout(json_text(json));
    return;
  }
  OutputFile file(staged.stage(flags.report));
  file.write(json_text(json));
  file.commit();
}

ExitCode run_reconstruct(const ReconstructFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode());
  ReconstructOptions options;
  options.measure_noise = true;
  for (const PointSetting& setting : point_settings()) {
    const auto given = flags.words.find(setting.name);
    if (given != flags.words.end() && !given->second.empty())
      setting.set(options, given->second, flag_of(setting.name));
  }
  if (flags.outputs.empty() && flags.report.empty())
    throw Error(ErrorCode::InvalidArgument, "nothing to write: name a file with -o or --report");
  PathClaims claims({.overwrite = flags.force});
  claims.add_input(flags.input);
  for (const std::string& path : flags.outputs) {
    (void)output_format(path);
    claims.add_output(path, "-o");
  }
  if (!flags.report.empty()) claims.add_output(flags.report, "--report");
  (void)require_mesher();

  Progress progress(console, flags.messages.progress_mode());
  progress.begin_job(std::filesystem::path(flags.input).stem().string());
  std::vector<Warning> warnings;
  options.callbacks.progress = [&](std::string_view step, double fraction) {
    progress.update(step, fraction);
  };
  options.callbacks.cancelled = [] { return interrupt_signal() != 0; };
  options.callbacks.warning = [&](const Warning& warning) {
    warnings.push_back(warning);
    console.warning(warning.message);
  };
  progress.update("read", 0);
  const PointInput input = read_point_input(flags.input);
  const Reconstruction result = reconstruct_input(input, options);
  StagedFiles staged;
  for (const std::string& path : flags.outputs)
    write_mesh(staged.stage(path), output_format(path), result.mesh);
  progress.finish();
  check_interrupt();
  if (!flags.report.empty()) write_report(flags, arguments, input, result, warnings, staged);
  staged.commit();
  console.info(flags.input + "\n" + reconstruction_summary(input, result));
  return ExitCode::Done;
}

}  // namespace

void add_reconstruct_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command =
      app.add_subcommand("reconstruct", "points in, a polygon mesh within a tolerance of them out");
  auto flags = std::make_shared<ReconstructFlags>();
  command->add_option("POINTS", flags->input, "points: .ply .xyz .pts .pcd")
      ->type_name("")
      ->required();
  command
      ->add_option("-o,--output", flags->outputs,
                   "mesh: " + extensions_of(FormatUse::WriteCage) + "; repeatable")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command->add_option("--report", flags->report, "JSON report; - for stdout")->type_name("FILE");
  command->add_flag("-f,--force", flags->force, "overwrite existing files");
  for (const PointSetting& setting : point_settings()) {
    std::string help(setting.help);
    if (!setting.initial.empty()) help += " [" + std::string(setting.initial) + "]";
    command->add_option(flag_of(setting.name), flags->words[setting.name], help)
        ->type_name(std::string(setting.choices))
        ->group("Points");
  }
  flags->messages.add_to(*command, true);
  command->footer(kReconstructExamples);
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] {
      return run_reconstruct(*flags, invocation.arguments);
    };
  });
}

}  // namespace planish::command
