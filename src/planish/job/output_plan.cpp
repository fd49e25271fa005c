#include "planish/job/output_plan.h"

#include <algorithm>
#include <cmath>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"
#include "planish/files/tiles/tile.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

FileFormat format_for(const OutputRequest& request) {
  const auto format = format_of(path_of(request.path));
  const bool cage = request.kind == OutputKind::Cage;
  const FormatUse use = cage ? FormatUse::WriteCage : FormatUse::WriteSurface;
  if (!format || !serves(*format, use)) {
    const std::string converter = cage ? "" : conversion_from_glb(path_of(request.path));
    refuse(request.where,
           visible(request.path) + ": a " + (cage ? "cage" : "surface") + " is written as " +
               extensions_in_words(use) + (converter.empty() ? "" : "; " + converter) +
               (path_of(request.path).has_extension() || cage
                    ? ""
                    : "; a folder ends with a slash, as " + visible(request.path) + "/"));
  }
  return *format;
}

// Where the path leads, symbolic links resolved, so that two spellings of a file meet.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  const fs::path result = fs::weakly_canonical(fs::absolute(path), error);
  return platform::comparable(error ? fs::absolute(path).lexically_normal() : result);
}

// The folder that has to be there: the path's own, or the first above it that exists where the
// others will be made.
fs::path folder_needed(const fs::path& path, bool create_folders) {
  fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  while (create_folders && !fs::exists(folder, error) && folder.has_parent_path() &&
         folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  const bool is_new = create_folders && !folder.has_parent_path() && !fs::exists(folder, error);
  return is_new ? fs::path(".") : folder;
}

std::vector<Fineness> finenesses_of(const OutputRequest& request) {
  std::vector<Fineness> all;
  const AdaptiveChoice& adaptive = request.adaptive;
  for (const double error : adaptive.chord_errors) all.push_back({1, error, adaptive.angle});
  if (all.empty() && adaptive.angle > 0) all.push_back({1, 0, adaptive.angle});
  for (const DecimationTarget& target : adaptive.targets())
    all.push_back({.level = 1, .target = target});
  if (!all.empty()) return all;
  for (const int level : request.levels) all.push_back({level, 0, 0, request.by_density});
  return all;
}

bool is_finer(const Fineness& a, const Fineness& b) {
  if (a.level != b.level) return a.level > b.level;
  return left_out_by(a) < left_out_by(b);
}

// Coordinates of up to half a diagonal round by 3e-8 of it as float32.
void require_float_error(const OutputRequest& request, FileFormat format,
                         const Fineness& fineness) {
  constexpr double kLeastOfFloats = 1e-7;
  const double error = std::max(fineness.chord_error, fineness.target.distance);
  if (error == 0 || error >= kLeastOfFloats || info_of(format).keeps_doubles) return;
  refuse(request.where,
         "{}: a chord error of {} of the diagonal is finer than the file's float32 "
         "numbers hold; take 1e-7 or more, or write .ply, which keeps doubles",
         visible(request.path), short_number(error));
}

}  // namespace

Fineness settled(Fineness fineness, const MeshFineness& mesh) {
  if (fineness.by_density || mesh.is_own) fineness.level = mesh.level;
  if (fineness.target.triangles > 0)
    fineness.target.triangles = std::max<std::int64_t>(
        1, static_cast<std::int64_t>(mesh.share * static_cast<double>(fineness.target.triangles)));
  return fineness;
}

std::vector<PlannedOutput> settled(std::vector<PlannedOutput> outputs, const MeshFineness& mesh) {
  for (PlannedOutput& output : outputs) {
    output.fineness = settled(output.fineness, mesh);
    for (Fineness& coarser : output.coarser) coarser = settled(coarser, mesh);
  }
  return outputs;
}

double left_out_by(const Fineness& fineness) {
  const DecimationTarget& target = fineness.target;
  if (target.triangles > 0) return 1 / std::sqrt(static_cast<double>(target.triangles));
  if (target.any()) return std::max(target.edge_length, target.distance);
  return fineness.is_adaptive() ? fineness.chord_error : std::ldexp(1.0, -fineness.level);
}

std::string finenesses_text(const Fineness& finest, const std::vector<Fineness>& coarser) {
  std::string text = fineness_text(finest);
  for (std::size_t i = 0; i < coarser.size(); ++i)
    text += (i == 0 ? " and " : ", ") + fineness_text(coarser[i]);
  return text + (coarser.empty() ? "" : " as levels of detail");
}

std::string fineness_text(const Fineness& fineness) {
  if (!fineness.is_adaptive()) return formatted("level {}", fineness.level);
  const DecimationTarget& target = fineness.target;
  if (target.triangles > 0) return formatted("at most {}", counted(target.triangles, "face"));
  if (target.edge_length > 0) return "edges of " + short_number(target.edge_length);
  if (target.distance > 0) return "distance " + short_number(target.distance);
  std::string text;
  if (fineness.chord_error > 0) text = "chord error " + short_number(fineness.chord_error);
  if (fineness.angle > 0)
    text += (text.empty() ? "angle " : " and angle ") + short_number(fineness.angle);
  return text;
}

void PathClaims::refuse_place(const fs::path& path, std::string_view where,
                              const std::string& what) {
  if (!rules_.only_note)
    throw Error(ErrorCode::UnwritableOutput, std::string(where) + ": " + visible(path) + what);
  refusals_.emplace(resolved(path), visible(path) + what);
}

void PathClaims::check_folder(const fs::path& path, std::string_view where) {
  const fs::path folder = folder_needed(path, rules_.create_folders);
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    refuse_place(path, where, ": there is no folder " + visible(folder) + "; make it first");
  } else if (!platform::may_write_into(folder)) {
    refuse_place(path, where, ": the folder " + visible(folder) + " is not writable");
  }
}

void PathClaims::add_input(const fs::path& path, std::optional<FileFormat> format,
                           FileReach reach) {
  if (path != "-") inputs_.add(path, format, reach);
}

void PathClaims::add_output(const fs::path& path, std::string_view where,
                            std::optional<FileFormat> format) {
  if (path == "-") {
    if (!outputs_.insert("-").second) refuse(where, "stdout can take one thing only");
    return;
  }
  if (path.empty()) refuse(where, "the path is empty");
  const fs::path target = resolved(path);
  const std::string harm = format ? inputs_.objection(path, *format) : inputs_.objection(path);
  if (!harm.empty()) refuse(where, harm);
  if (!outputs_.insert(target).second) refuse(where, visible(path) + " is written twice");
  if (outputs_.contains(target.parent_path()))
    refuse(where, visible(path) + " lies in the folder of tiles; choose another");
  std::error_code error;
  if (const std::string why = platform::objection_to_name(path); !why.empty()) {
    refuse_place(path, where, ": " + why);
  } else if (fs::is_directory(path, error)) {
    refuse_place(path, where, " is a folder");
  } else if (fs::is_other(fs::status(path, error))) {
    // A whole file would take its place, and who reads there would wait for ever.
    refuse_place(
        path, where,
        " is a pipe or a device, where files are put in place whole; \"-o -\" writes a GLB "
        "to stdout");
  } else if (!rules_.overwrite && fs::exists(fs::symlink_status(path, error))) {
    refuse_place(path, where, " exists; --force overwrites it");
  } else {
    check_folder(path, where);
  }
}

void PathClaims::add_tile_folder(const fs::path& folder, std::string_view where) {
  const fs::path target = resolved(folder);
  if (!outputs_.insert(target).second) refuse(where, visible(folder) + " is written twice");
  for (const fs::path& other : outputs_) {
    if (other.parent_path() == target)
      refuse(where, "{}, the folder of the tiles, has {} in it; choose another name",
             visible(folder), visible(other));
  }
  std::error_code error;
  const fs::file_status status = fs::symlink_status(folder, error);
  if (!fs::exists(status)) return;
  if (!fs::is_directory(status)) {
    refuse_place(folder, where,
                 ", the folder of the tiles, is something else; choose another name");
    return;
  }
  const fs::path foreign = foreign_in_tiles(folder);
  if (!foreign.empty()) {
    refuse_place(folder, where,
                 ", the folder of the tiles, holds " + visible(foreign) +
                     ", which is none; move it away, or choose another name");
  } else if (!rules_.overwrite && !fs::is_empty(folder, error)) {
    refuse_place(folder, where, " exists; --force replaces it");
  }
}

void PathClaims::add_report(const fs::path& path, std::string_view where) {
  if (path != "-" && path.extension() != ".json")
    refuse(where, visible(path) + ": a report is JSON, and its name ends in .json");
  add_output(path, where);
}

void require_page_path(const fs::path& path, std::string_view where) {
  if (path == "-" || path.extension() == ".html" || path.extension() == ".htm") return;
  refuse(where, "{}: a page is an .html file", visible(path));
}

void PathClaims::add_page(const fs::path& path, std::string_view where) {
  require_page_path(path, where);
  if (path == "-" && rules_.stdout_is_terminal)
    refuse(where, "a page is not written to a terminal; name a file");
  add_output(path, where);
}

std::string PathClaims::refusal(const fs::path& path) const {
  const auto found = refusals_.find(resolved(path));
  return found == refusals_.end() ? std::string() : found->second;
}

bool has_cage(const std::vector<PlannedOutput>& outputs) {
  return std::ranges::find(outputs, OutputKind::Cage, &PlannedOutput::kind) != outputs.end();
}

void require_attribute_formats(const std::vector<PlannedOutput>& outputs) {
  for (const PlannedOutput& output : outputs) {
    const bool carries = info_of(output.format).is_gltf || output.format == FileFormat::Ply ||
                         output.format == FileFormat::Usda;
    if (output.kind == OutputKind::Cage || carries) continue;
    refuse("--attributes",
           utf8(output.path) + " cannot hold them; .glb, .gltf, .ply and .usda can");
  }
}

void require_tileable(const std::vector<PlannedOutput>& outputs, const Settings& settings) {
  for (const PlannedOutput& output : outputs) {
    if (!info_of(output.format).is_tiles) continue;
    if (settings.scheme != Scheme::DooSabin) {
      refuse("--scheme", "{}: 3D Tiles are made of Doo-Sabin surfaces, not of {}; write .glb",
             visible(output.path), name_of(settings.scheme));
    }
    if (output.fineness.level < 1)
      refuse("--levels", visible(output.path) + ": 3D Tiles have levels from 1 on, not 0");
  }
}

void require_step_surfaces(const std::vector<PlannedOutput>& outputs, const Settings& settings) {
  for (const PlannedOutput& output : outputs)
    if (info_of(output.format).is_brep)
      require_step_scheme(settings.scheme, "--scheme: " + visible(output.path));
}

void require_compressible(const std::vector<PlannedOutput>& outputs) {
  for (const PlannedOutput& output : outputs) {
    if (output.kind == OutputKind::Cage || info_of(output.format).is_gltf ||
        info_of(output.format).is_tiles)
      continue;
    refuse("--compress", visible(output.path) + " is not compressed; .glb, .gltf and 3D Tiles are");
  }
}

std::vector<PlannedOutput> plan_output(const OutputRequest& request, PathClaims& claims) {
  std::vector<Fineness> finenesses = finenesses_of(request);
  std::vector<Fineness> coarser;
  if (request.lods_in_one && finenesses.size() > 1) {
    const auto format = request.path == "-" ? FileFormat::Glb : format_for(request);
    if (!info_of(format).is_gltf)
      refuse(request.where, visible(request.path) +
                                ": levels of detail in one file are of glTF alone; take --lods "
                                "files");
    std::ranges::stable_sort(finenesses, is_finer);
    coarser.assign(finenesses.begin() + 1, finenesses.end());
    finenesses.resize(1);
  }
  const bool several = finenesses.size() > 1;
  if (request.path == "-") {
    if (request.kind == OutputKind::Cage) refuse(request.where, "a cage needs a file");
    if (several) refuse(request.where, "stdout takes one level only");
    if (claims.stdout_is_terminal())
      refuse(
          request.where,
          "a GLB is not written to a terminal; name a file, or send stdout somewhere: > out.glb");
    claims.add_output("-", request.where);
    require_float_error(request, FileFormat::Glb, finenesses.at(0));
    return {{"-", OutputKind::Surface, FileFormat::Glb, finenesses.at(0), true, coarser}};
  }
  if (request.path.empty()) refuse(request.where, "the path is empty");
  const FileFormat format = format_for(request);
  std::vector<PlannedOutput> planned;
  if (request.kind == OutputKind::Cage) {
    planned.push_back({path_of(request.path), request.kind, format, {}});
  } else if (info_of(format).is_tiles) {
    if (request.adaptive.any())
      refuse(request.where, visible(request.path) +
                                ": 3D Tiles have levels; take --levels instead of " +
                                flag_of_option(request.adaptive.kinds()[0]));
    // All levels up to the finest are in one set.
    planned.push_back({path_of(request.path),
                       request.kind,
                       format,
                       {std::ranges::max(request.levels), 0, 0, request.by_density}});
  } else if (info_of(format).is_brep) {
    planned.push_back({path_of(request.path), request.kind, format, {}});
  } else {
    for (std::size_t i = 0; i < finenesses.size(); ++i) {
      fs::path path = path_of(request.path);
      if (several) {
        path.replace_filename(
            path_of(formatted("{}_LOD{}{}", utf8(path.stem()), i, utf8(path.extension()))));
      }
      planned.push_back({path, request.kind, format, finenesses[i], false, coarser});
    }
  }
  for (PlannedOutput& output : planned) {
    for (const Fineness& fineness : output.finenesses())
      require_float_error(request, format, fineness);
    claims.add_output(output.path, request.where, format);
    const fs::path companion = companion_of(output.path, format);
    if (!companion.empty()) claims.add_output(companion, request.where);
    if (info_of(format).is_tiles) claims.add_tile_folder(tile_folder(output.path), request.where);
  }
  return planned;
}

}  // namespace planish
