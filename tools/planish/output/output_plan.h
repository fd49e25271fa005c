#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "planish/files/formats.h"

namespace planish::command {

enum class OutputKind { Surface, Cage };

/// One output as asked for. A surface of several levels becomes several files.
struct OutputRequest {
  std::string path;  ///< "-": a GLB to stdout
  OutputKind kind = OutputKind::Surface;
  std::vector<int> levels;  ///< of a surface
  std::string where;        ///< for messages: "-o" or "scene.json: jobs[0].outputs[1]"
};

/// One file to be written.
struct PlannedOutput {
  std::filesystem::path path;
  OutputKind kind = OutputKind::Surface;
  FileFormat format = FileFormat::Glb;
  int level = 0;  ///< of a surface
  bool to_stdout = false;
};

struct PathRules {
  bool overwrite = false;       ///< existing files may be replaced
  bool create_folders = false;  ///< missing folders are made when files are written
};

/// All paths of a process, so that no file is written twice or over an input.
class PathClaims {
 public:
  explicit PathClaims(PathRules rules) : rules_(rules) {}

  void add_input(const std::filesystem::path& path);
  /// "-" claims stdout. Throws Error{InvalidArgument} for a path that is taken, an input, a folder
  /// or an existing file without leave to overwrite; Error{UnwritableOutput} for a folder that is
  /// missing or not writable. Only looks, creates nothing.
  void add_output(const std::filesystem::path& path, std::string_view where);

 private:
  PathRules rules_;
  std::set<std::filesystem::path> inputs_, outputs_;
};

/// The files that a request becomes: NAME.glb, or NAME_LOD0.glb, NAME_LOD1.glb... in the order of
/// the levels. Claims each. Throws as PathClaims, and Error{InvalidArgument} for an extension that
/// is not written or several levels to stdout.
[[nodiscard]] std::vector<PlannedOutput> plan_output(const OutputRequest& request,
                                                     PathClaims& claims);

/// Refuses surfaces that cannot carry vertex attributes, such as .obj, with Error{InvalidArgument}.
void require_attribute_formats(const std::vector<PlannedOutput>& outputs);

/// The .bin that is written beside a .gltf.
[[nodiscard]] std::filesystem::path gltf_companion(const std::filesystem::path& path);

}  // namespace planish::command
