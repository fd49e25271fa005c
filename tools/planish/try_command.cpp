#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "batch.h"
#include "commands.h"
#include "devices.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/build_info.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"
#include "planish/job/page/sheet.h"
#include "planish/job/page/trial.h"
#include "planish/job/staged_files.h"
#include "planish/job/try_choices.h"
#include "planish/pipeline/option_table.h"
#include "scene_file.h"
#include "terminal.h"

namespace planish::command {
namespace {

struct TryFlags {
  std::string input, folder, report;
  FitFlags fit;  // what a surface is like, page and messages
};

// What is open unless it is named.
constexpr std::array<std::string_view, 4> kTried{"quads", "creases", "interpolation", "refine"};

bool is_open(std::string_view name, const std::string& text) {
  return std::ranges::find(kTried, name) != kTried.end() && text == fit_option(name).initial;
}

// Without what files alone hold.
bool is_taken(const FitOption& option) {
  constexpr std::array<std::string_view, 3> kOfSurface{"device", "up", "asset"};
  return has_flag(option) && (option.stage != OptionStage::Output ||
                              std::ranges::find(kOfSurface, option.name) != kOfSurface.end());
}

// The path as it would be typed beside the input.
std::string surface_beside(const std::string& input) {
  const std::string stem = utf8(path_of(input).stem());
  const std::string name = stem + ".glb";
  return path_of(input).lexically_normal() == path_of(name) ? stem + "_surface.glb" : name;
}

std::string surface_path(const TryFlags& flags, const std::string& stem) {
  const std::string name = utf8(path_of(flags.input).stem()) + "_" + stem + ".glb";
  return utf8(path_of(flags.folder) / path_of(name));
}

// The line to which a surface's own flags are added.
std::vector<std::string> fit_line(const TryFlags& flags) {
  std::vector<std::string> words{"planish", "fit", flags.input, "-o", surface_beside(flags.input)};
  if (!flags.fit.input_format.empty())
    words.insert(words.end(), {"--input-format", flags.fit.input_format});
  for (const FitOption& option : option_table()) {
    const auto given = flags.fit.options.find(option.name);
    if (given == flags.fit.options.end() || is_open(option.name, given->second)) continue;
    words.push_back(flag_of(option));
    if (option.kind != OptionKind::Switch) words.push_back(given->second);
  }
  return words;
}

std::string line_of(const std::vector<std::string>& words) {
  const std::filesystem::path folder = std::filesystem::current_path();
  std::string line;
  for (const std::string& word : words)
    line += (line.empty() ? "" : " ") + shell_word(relative_to(folder, word));
  return line;
}

std::string scene_of(const TryFlags& flags, const TriedSurface& tried) {
  Json job;
  job["input"] = relative_to(std::filesystem::current_path(), flags.input);
  if (!flags.fit.input_format.empty()) job["input_format"] = flags.fit.input_format;
  for (const FitOption& option : option_table()) {
    const auto given = flags.fit.options.find(option.name);
    if (given != flags.fit.options.end() && !is_open(option.name, given->second))
      job[std::string(option.name)] = value_json(option, given->second);
  }
  for (const auto& [name, value] : tried.settings) job[name] = value_json(fit_option(name), value);
  job["outputs"] = Json::array({{{"path", surface_beside(flags.input)}}});
  return json_text({{"version", 1}, {"jobs", Json::array({job})}});
}

std::string flags_of(const TriedSurface& tried) {
  std::string text;
  for (const auto& [name, value] : tried.settings)
    text += (text.empty() ? "" : " ") + flag_of_setting(name) + " " + value;
  return text.empty() ? "(none)" : text;
}

std::string table_of(const Trial& trial) {
  Table table({{"flags", Align::Left},
               {"cost", Align::Right},
               {"bends", Align::Right},
               {"folded", Align::Right},
               {"normals", Align::Right},
               {"", Align::Left}});
  for (const TriedSurface& tried : trial.surfaces) {
    const SheetRow row = sheet_row(tried.report);
    const bool has_cost = tried.failure.empty() && tried.is_measured;
    table.add_row({flags_of(tried), has_cost ? fixed(tried.cost.sum(), 3) : "-",
                   has_cost ? figure(tried.bending) : "-", has_cost ? percent(tried.folded) : "-",
                   row.is_measured ? fixed(row.normals, 1) : "-",
                   !tried.failure.empty() ? "failed"
                   : tried.is_taken       ? "taken"
                                          : ""});
  }
  return table.text() +
         "cost: what the least of is taken, once it is settled which edges are sharp; bends: the "
         "integral of\nboth squared curvatures; folded: of the area; normals: degrees rms off the "
         "input's faces\n";
}

// What the table says, and which settings make each.
nlohmann::ordered_json report_of(const TryFlags& flags, const Trial& trial,
                                 const std::vector<std::string>& arguments) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.try/1";
  json["tool"] = {{"name", "planish"}, {"version", PLANISH_VERSION}, {"git", git_revision()}};
  json["argv"] = arguments;
  json["exit_code"] = static_cast<int>(exit_code_of(trial.surfaces.front().report));
  json["input"] = {{"path", flags.input}};
  json["reason"] = trial.reason;
  json["surfaces"] = nlohmann::ordered_json::array();
  for (const TriedSurface& tried : trial.surfaces) {
    nlohmann::ordered_json& one = json["surfaces"].emplace_back();
    one["title"] = tried.title;
    one["settings"] = nlohmann::ordered_json::object();
    for (const auto& [name, value] : tried.settings) one["settings"][name] = value;
    one["taken"] = tried.is_taken;
    if (!tried.failure.empty()) {
      one["error"] = tried.failure;
      continue;
    }
    const SheetRow row = sheet_row(tried.report);
    const auto known = [](bool is_known, double number) {
      return is_known ? nlohmann::ordered_json(number) : nlohmann::ordered_json();
    };
    one["cost"] = known(tried.is_measured, tried.cost.sum());
    one["bending"] = known(tried.is_measured, tried.bending);
    one["folded"] = known(tried.is_measured, tried.folded);
    one["normals"] = known(row.is_measured, row.normals);
    one["file"] = nullptr;
    if (!flags.folder.empty()) one["file"] = surface_path(flags, tried.stem);
  }
  return json;
}

std::string mesh_extensions() {
  std::string text;
  for (const FormatInfo& info : formats())
    if (serves(info.format, FormatUse::Read) && !holds_points_only(info.format))
      text += (text.empty() ? "." : " .") + std::string(info.name);
  return text;
}

// Where the page goes; empty: nowhere.
std::string page_path(const TryFlags& flags) {
  if (!flags.fit.page.empty() || flags.folder.empty()) return flags.fit.page;
  return utf8(path_of(flags.folder) / "index.html");
}

void require_folder(const std::string& path) {
  if (path.empty() || names_folder(path)) return;
  if (path == "-" || path_of(path).has_extension())
    refuse("-o",
           "{}: is no folder, and several surfaces are written; name one: -o {}/, or --page "
           "FILE.html for the page alone",
           visible(path), visible(path_of(path).stem()));
}

// What is written, and the job as far as all ways share it.
struct TryPlan {
  std::vector<PlannedJob> jobs;  // one
  DeviceList devices;
  PageOptions page;
};

TryPlan plan_try(const TryFlags& flags) {
  Faults faults;
  TryPlan plan;
  faults.note([&] { require_readable(flags.input, input_format_of(flags.fit)); });
  PlannedJob& planned = plan.jobs.emplace_back();
  Settings settings;
  faults.note([&] { settings = settings_of(flags.fit); });
  faults.note([&] { planned.job = job_of(flags.fit, settings, flags.input, false); });
  faults.throw_if_any();
  faults.note([&] { require_open_choice(planned.job); });
  faults.note([&] { require_folder(flags.folder); });
  planned.job.arguments = fit_line(flags);
  planned.job.overwrites = flags.fit.force;
  PathClaims claims({.overwrite = flags.fit.force,
                     .create_folders = !flags.folder.empty(),
                     .stdout_is_terminal = stdout_is_terminal()});
  claims.add_input(path_of(flags.input), planned.job.input_format, settings.textures);
  if (!flags.folder.empty())
    for (const std::string& stem : stems_to_try(settings))
      faults.note([&] { claims.add_output(path_of(surface_path(flags, stem)), "-o"); });
  const std::string page = page_path(flags);
  if (!page.empty())
    faults.note([&] { claims.add_page(path_of(page), flags.fit.page.empty() ? "-o" : "--page"); });
  if (!flags.report.empty())
    faults.note([&] { claims.add_report(path_of(flags.report), "--report"); });
  faults.note([&] { plan.page = page_options(flags.fit.page_limit, flags.fit.page_no_times); });
  faults.note([&] { plan.devices = settle_devices(plan.jobs); });
  faults.throw_if_any();
  planned.job.page_options = plan.page;
  return plan;
}

std::string trial_page_of(const TryFlags& flags, Trial& trial, const PageOptions& options) {
  std::vector<TrialCard> cards;
  for (TriedSurface& tried : trial.surfaces) {
    TrialCard& card = cards.emplace_back();
    card.scene = scene_of(flags, tried);
    if (tried.failure.empty()) {
      card.command = line_of(tried.report.arguments);
      tried.page.report["outputs"][0]["path"] =
          flags.folder.empty() ? surface_beside(flags.input) : surface_path(flags, tried.stem);
    }
    card.tried = std::move(tried);
  }
  return make_trial_page(std::move(cards), options, std::filesystem::current_path(),
                         job_name_of(flags.input), trial.reason);
}

ExitCode run_try(const TryFlags& flags, const std::vector<std::string>& arguments) {
  const MessageFlags& messages = flags.fit.messages;
  Console console(messages.level(), messages.color_mode(), messages.form());
  const TryPlan plan = plan_try(flags);
  const PlannedJob& planned = plan.jobs.front();
  const auto backend = open_backend(plan.devices.devices[planned.device], planned.job.settings);
  Progress progress(console, messages.progress_mode());
  JobDisplay display(progress, planned.job.name);
  StagedFiles staged(flags.fit.force);
  const std::string page = page_path(flags);
  Trial trial = try_choices(planned.job, *backend, watch_of(console, display), !page.empty(),
                            [&](const TriedSurface& tried, std::string_view bytes) {
                              if (!flags.folder.empty())
                                staged.write(path_of(surface_path(flags, tried.stem)), bytes);
                            });
  progress.finish();
  const ExitCode exit_code = exit_code_of(trial.surfaces.front().report);
  const std::string table = table_of(trial);
  const std::string report = json_text(report_of(flags, trial, arguments));
  const auto count = std::ssize(trial.surfaces);
  const std::string text = page.empty() ? "" : trial_page_of(flags, trial, plan.page);
  if (!page.empty() && page != "-") staged.write(path_of(page), text);
  if (!flags.report.empty() && flags.report != "-") staged.write(path_of(flags.report), report);
  staged.commit();
  if (page == "-") write_stdout(text);
  if (flags.report == "-") write_stdout(report);
  console.info(table);
  if (!page.empty() && page != "-")
    console.info(formatted("{}: {}, page of {}", visible(page), byte_size(text.size()),
                           counted(count, "surface")));
  return exit_code;
}

}  // namespace

void add_try_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "try", "the surfaces that fit chooses from, side by side, and the flags that make each");
  auto flags = std::make_shared<TryFlags>();
  const char* const files = "Files";
  const auto option = [&](const char* name, std::string& target, const std::string& help,
                          const std::string& type) {
    return command->add_option(name, target, help)->type_name(type)->group(files);
  };
  command->add_option("INPUT", flags->input, "a mesh (" + mesh_extensions() + ")")
      ->type_name("INPUT")
      ->required();
  option("-o,--output", flags->folder, "write each surface as a GLB, and the page as index.html",
         "FOLDER");
  option("--report", flags->report, "JSON report; - for stdout", "FILE");
  option("--input-format", flags->fit.input_format,
         "format, where the extension is wrong [told by the content]",
         names_of(FormatUse::Read, "|"));
  command->add_flag("-f,--force", flags->fit.force, "overwrite existing files")->group(files);
  add_page_flags(*command, {flags->fit.page, flags->fit.page_limit, flags->fit.page_no_times},
                 "HTML page to choose on, - for stdout");
  for (const FitOption& row : option_table())
    if (is_taken(row)) add_option_flag(*command, flags->fit.options, row, "Surface");
  flags->fit.messages.add_to(*command, true);
  invocation.texts["try"] = {
      .examples = {"planish try part.stl --page part_tried.html", "planish try part.stl -o tried/",
                   "planish try part.stl --interpolation fair"},
      .first_flags = {"--output", "--page", "--report", "--force", "--quads", "--creases",
                      "--interpolation", "--refine", "--levels", "-h", "--help"},
      .notes =
          "Tried are faces as they are, joined to quads and with vertices added, both methods, "
          "edges sharp and round, as far as no flag names them. What is taken is the surface of "
          "planish fit without flags, byte for byte. Exit codes are those of planish fit."};
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_try(*flags, invocation.arguments); };
  });
}

}  // namespace planish::command
