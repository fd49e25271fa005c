#include "options/fit_flags.h"

#include <CLI/CLI.hpp>
#include <charconv>

#include "job/input.h"
#include "options/input_list.h"
#include "options/point_settings.h"
#include "options/refuse.h"
#include "page/page_job.h"
#include "planish/core/visible_text.h"

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
  refuse("--output-format", "\"" + visible(flags.output_format) + "\" is not one of " +
                                names_of(FormatUse::WriteSurface));
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
  refuse(flag, visible(path) + " is one file, and there are several inputs; name a folder: " +
                   std::string(flag) + " " + visible(std::filesystem::path(path).stem()) + "/");
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
  option("--levels", flags.levels,
         "quad splits, 0 to 6 [2]; several write NAME_LOD0.glb, NAME_LOD1.glb, ...; "
         "3D Tiles have all from 1 to it",
         "L[,L2,...]");
  option("--chord-error", flags.chord_error,
         "instead of levels: triangles within so much of the surface, relative to the diagonal; "
         "several write NAME_LOD0.glb, ...",
         "E[,E2,...]");
  option("--angle", flags.angle,
         "instead of levels, or besides --chord-error: most degrees that the surface turns beneath "
         "a triangle",
         "DEGREES");
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

std::vector<int> parse_levels(const std::string& text) {
  std::vector<std::int64_t> values;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    std::int64_t value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || (next != end && *next != ',')) {
      refuse("--levels", "\"" + visible(text) + "\" is no list of levels such as 2 or 3,1");
    }
    values.push_back(value);
    if (next == end) break;
    at = next + 1;
  }
  return checked_levels(values, "--levels");
}

void add_fit_flags(CLI::App& command, FitFlags& flags) {
  add_file_flags(command, flags);
  add_page_flags(command, {flags.page, flags.page_limit, flags.page_no_times});
  for (const WordSetting& setting : word_settings())
    add_word_flag(command, flags.words, setting, kSurface);
  const auto number = [&](const char* name, std::string& target, const char* help,
                          const char* type) {
    command.add_option(name, target, help)->type_name(type)->group(kSurface);
  };
  number("--tolerance", flags.tolerance,
         "largest vertex error, relative to the bounding-box diagonal [1e-6]", "T");
  number("--max-iterations", flags.max_iterations, "give up after so many [200]", "N");
  number("--polish", flags.polish, "steps that even out the curvature of a fair surface [8]", "N");
  number("--weld", flags.weld,
         "meshes: make vertices one that lie within this fraction of the diagonal", "T");
  number("--tile-vertices", flags.tile_vertices, "about so many has each file of 3D Tiles [262144]",
         "N");
  command
      .add_flag("--skirts", flags.skirts,
                "hide gaps between 3D Tiles of different levels behind strips along their edges")
      ->group(kSurface);
  for (const PointSetting& setting : point_settings())
    add_word_flag(command, flags.words, setting, kPoints);
}

namespace {

void take_adaptive(const FitFlags& flags, AdaptiveChoice& adaptive) {
  const auto one_number = [](const std::string& text, const char* flag) {
    const std::vector<double> values = parse_numbers(text, flag);
    if (values.size() != 1) refuse(flag, "one number is wanted, not " + visible(text));
    return values.front();
  };
  if (!flags.chord_error.empty())
    adaptive.chord_errors =
        checked_chord_errors(parse_numbers(flags.chord_error, "--chord-error"), "--chord-error");
  if (!flags.angle.empty())
    adaptive.angle = checked_angle(one_number(flags.angle, "--angle"), "--angle");
  if (adaptive.any() && !flags.levels.empty()) {
    refuse("--levels", std::string("a surface has levels or ") +
                           (flags.chord_error.empty() ? "an --angle" : "a --chord-error") +
                           ", not both; leave one of them out");
  }
}

}  // namespace

std::optional<FileFormat> input_format_of(const FitFlags& flags) {
  if (flags.input_format.empty()) return std::nullopt;
  return parse_input_format(flags.input_format, "--input-format");
}

Settings settings_of(const FitFlags& flags) {
  Settings settings;
  apply_words(flags.words, word_settings(), settings);
  apply_words(flags.words, point_settings(), settings.points);
  const auto whole = [&](const std::string& text, const char* flag, auto set) {
    if (!text.empty()) set(settings, parse_whole(text, flag), flag);
  };
  if (!flags.tolerance.empty())
    set_tolerance(settings, std::string_view(flags.tolerance), "--tolerance");
  if (!flags.weld.empty()) set_weld(settings, std::string_view(flags.weld), "--weld");
  whole(flags.max_iterations, "--max-iterations", set_max_iterations);
  whole(flags.polish, "--polish", set_polish_steps);
  whole(flags.tile_vertices, "--tile-vertices", set_tile_vertices);
  settings.skirts = flags.skirts;
  if (!flags.levels.empty()) settings.levels = parse_levels(flags.levels);
  take_adaptive(flags, settings.adaptive);
  check_consistent(settings);
  return settings;
}

int workers_of(const FitFlags& flags) {
  constexpr std::int64_t kMost = 256;
  if (flags.workers.empty()) return 1;
  const std::int64_t workers = parse_whole(flags.workers, "--jobs");
  if (workers < 1 || workers > kMost)
    refuse("--jobs", std::to_string(workers) + " is out of range; 1 to 256 is wanted");
  return static_cast<int>(workers);
}

namespace {

std::vector<std::string> given_settings(const FitFlags& flags) {
  std::vector<std::string> given;
  for (const auto& [name, value] : flags.words)
    if (!value.empty()) given.emplace_back(name);
  if (!flags.max_iterations.empty()) given.emplace_back("max_iterations");
  if (!flags.polish.empty()) given.emplace_back("polish");
  if (!flags.weld.empty()) given.emplace_back("weld");
  if (!flags.tile_vertices.empty()) given.emplace_back("tile_vertices");
  if (flags.skirts) given.emplace_back("skirts");
  return given;
}

}  // namespace

Job job_of(const FitFlags& flags, const Settings& settings, const std::string& input,
           bool one_of_several) {
  Job job;
  job.input = input;
  job.name = job_name_of(input);
  job.input_format = input_format_of(flags);
  job.settings = settings;
  job.given_settings = given_settings(flags);
  job.source = flags.source;
  const FileFormat surface = output_format_of(flags, FormatUse::WriteSurface, FileFormat::Glb);
  const FileFormat cage = output_format_of(flags, FormatUse::WriteCage, FileFormat::Obj);
  for (const std::string& path : flags.outputs)
    job.outputs.push_back({output_path(path, input, surface, "-o", one_of_several),
                           OutputKind::Surface, settings.levels, settings.adaptive, "-o"});
  if (!flags.cage.empty())
    job.outputs.push_back({output_path(flags.cage, input, cage, "--cage", one_of_several),
                           OutputKind::Cage,
                           {},
                           {},
                           "--cage"});
  return job;
}

}  // namespace planish::command
