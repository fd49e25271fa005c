#include "options/fit_flags.h"

#include <CLI/CLI.hpp>

#include "options/input_list.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/job/input.h"
#include "planish/job/text.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

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

// Where an output of that input goes: the path itself, or the input's name in a folder.
std::string output_path(const std::string& path, const std::string& input, FileFormat format,
                        const char* flag, bool one_of_several) {
  // Of several inputs a name without an extension is a folder that will be made.
  const bool is_new_folder =
      one_of_several && path != "-" && !std::filesystem::path(path).has_extension();
  if (names_folder(path) || is_new_folder) return path_in_folder(path, input, format);
  if (!one_of_several) return path;
  if (path == "-") refuse(flag, "stdout takes one surface only, and there are several inputs");
  refuse(flag, "{} is one file, and there are several inputs; name a folder: {} {}/", visible(path),
         flag, visible(std::filesystem::path(path).stem()));
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
  option("--cage", flags.cage,
         "control cage (" + extensions_of(FormatUse::WriteCage) + "), or a folder", "FILE");
  option("--report", flags.report, "JSON report; - for stdout", "FILE");
  for (const FitOption& fineness : option_table())
    if (is_of_files(fineness)) add_option_flag(command, flags.options, fineness, kFiles);
  option("--source", flags.source,
         "mesh that the surface stands for: the report compares with it, not the input", "FILE");
  option("--input-format", flags.input_format,
         "of stdin, or against the extension [what the content looks like]",
         names_of(FormatUse::Read, "|"));
  option("--output-format", flags.output_format, "in folders [glb; cages obj]",
         names_of(FormatUse::WriteSurface, "|"));
  option("-j,--jobs", flags.workers, "inputs at once, each on all threads [1]", "N");
  command.add_flag("-f,--force", flags.force, "overwrite existing files")->group(kFiles);
  command
      .add_flag(
          "--dry-run", flags.dry_run,
          "check everything, and say what would be written, how large, in what memory and time")
      ->group(kFiles);
}

}  // namespace

// Tags have no flag: they name vertices.
bool has_flag(const FitOption& option) {
  return option.kind != OptionKind::Vertices && option.kind != OptionKind::Edges;
}

void add_fit_flags(CLI::App& command, FitFlags& flags) {
  add_file_flags(command, flags);
  add_page_flags(command, {flags.page, flags.page_limit, flags.page_no_times});
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
    refuse("--levels",
           std::string("a surface has levels or ") +
               (settings.adaptive.chord_errors.empty() ? "an --angle" : "a --chord-error") +
               ", not both; leave one of them out");
  }
  check_consistent(settings);
  return settings;
}

int workers_of(const FitFlags& flags) {
  constexpr std::int64_t kMost = 256;
  if (flags.workers.empty()) return 1;
  std::int64_t workers = 0;
  if (!parse_integer(flags.workers, workers))
    refuse("--jobs", "\"" + visible(flags.workers) + "\" is no whole number");
  if (workers < 1 || workers > kMost)
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
  const FileFormat cage = output_format_of(flags, FormatUse::WriteCage, FileFormat::Obj);
  for (const std::string& path : flags.outputs)
    job.outputs.push_back(
        surface_request(settings, output_path(path, input, surface, "-o", one_of_several), "-o"));
  if (!flags.cage.empty())
    job.outputs.push_back({.path = output_path(flags.cage, input, cage, "--cage", one_of_several),
                           .kind = OutputKind::Cage,
                           .where = "--cage"});
  return job;
}

}  // namespace planish::command
