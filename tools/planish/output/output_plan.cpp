#include "output/output_plan.h"

#include <unistd.h>

#include "options/refuse.h"
#include "planish/core/error.h"

namespace planish::command {
namespace {

namespace fs = std::filesystem;

FileFormat format_for(const OutputRequest& request) {
  const auto format = format_of(request.path);
  const bool cage = request.kind == OutputKind::Cage;
  const FormatUse use = cage ? FormatUse::WriteCage : FormatUse::WriteSurface;
  if (!format || !serves(*format, use)) {
    refuse(request.where, request.path + ": a " + (cage ? "cage" : "surface") + " is written as " +
                              extensions_in_words(use));
  }
  return *format;
}

// Where the path leads, symbolic links resolved, so that two spellings of a file meet.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  fs::path result = fs::weakly_canonical(fs::absolute(path), error);
  return error ? fs::absolute(path).lexically_normal() : result;
}

void require_writable_folder(const fs::path& path, std::string_view where, bool create_folders) {
  fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  while (create_folders && !fs::exists(folder, error) && folder.has_parent_path() &&
         folder != folder.parent_path()) {
    folder = folder.parent_path();
  }
  if (!fs::is_directory(folder, error) && create_folders && !folder.has_parent_path() &&
      !fs::exists(folder, error)) {
    folder = ".";
  }
  const std::string subject = std::string(where) + ": " + path.string() + ": ";
  if (!fs::is_directory(folder, error)) {
    throw Error(ErrorCode::UnwritableOutput,
                subject + "there is no folder " + folder.string() + "; make it first");
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw Error(ErrorCode::UnwritableOutput,
                subject + "the folder " + folder.string() + " is not writable");
  }
}

}  // namespace

void PathClaims::add_input(const fs::path& path) {
  if (path != "-") inputs_.insert(resolved(path));
}

void PathClaims::add_output(const fs::path& path, std::string_view where) {
  if (path == "-") {
    if (!outputs_.insert("-").second) refuse(where, "stdout can take one thing only");
    return;
  }
  if (path.empty()) refuse(where, "the path is empty");
  const fs::path target = resolved(path);
  if (inputs_.contains(target)) refuse(where, path.string() + " is the input as well");
  if (!outputs_.insert(target).second) refuse(where, path.string() + " is written twice");
  std::error_code error;
  if (fs::is_directory(path, error)) refuse(where, path.string() + " is a folder");
  if (!rules_.overwrite && fs::exists(fs::symlink_status(path, error))) {
    refuse(where, path.string() + " exists; --force overwrites it");
  }
  require_writable_folder(path, where, rules_.create_folders);
}

void require_attribute_formats(const std::vector<PlannedOutput>& outputs) {
  for (const PlannedOutput& output : outputs) {
    const bool carries = info_of(output.format).is_gltf || output.format == FileFormat::Ply;
    if (output.kind == OutputKind::Cage || carries) continue;
    refuse("--attributes", output.path.string() + " cannot hold them; .glb, .gltf and .ply can");
  }
}

fs::path gltf_companion(const fs::path& path) {
  fs::path companion = path;
  return companion.replace_extension(".bin");
}

std::vector<PlannedOutput> plan_output(const OutputRequest& request, PathClaims& claims) {
  const bool several = request.levels.size() > 1;
  if (request.path == "-") {
    if (request.kind == OutputKind::Cage) refuse(request.where, "a cage needs a file");
    if (several) refuse(request.where, "stdout takes one level only");
    claims.add_output("-", request.where);
    return {{"-", OutputKind::Surface, FileFormat::Glb, request.levels.at(0), true}};
  }
  if (request.path.empty()) refuse(request.where, "the path is empty");
  const FileFormat format = format_for(request);
  std::vector<PlannedOutput> planned;
  if (request.kind == OutputKind::Cage) {
    planned.push_back({request.path, request.kind, format});
  } else {
    for (std::size_t i = 0; i < request.levels.size(); ++i) {
      fs::path path = request.path;
      if (several) {
        path.replace_filename(path.stem().string() + "_LOD" + std::to_string(i) +
                              path.extension().string());
      }
      planned.push_back({path, request.kind, format, request.levels[i]});
    }
  }
  for (const PlannedOutput& output : planned) {
    claims.add_output(output.path, request.where);
    if (format == FileFormat::Gltf) {
      claims.add_output(gltf_companion(output.path), request.where);
    }
  }
  return planned;
}

}  // namespace planish::command
