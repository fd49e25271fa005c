#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::shapes {

/// The mesh as Wavefront OBJ: `# comment`, then vertices, faces with their attributes, and
/// `t crease` / `t corner` / `t hole` tags as OpenSubdiv reads them. Numbers are shortest
/// round-trip doubles, so equal meshes give equal bytes.
[[nodiscard]] std::string obj_text(const PolygonMesh& mesh, std::string_view comment);

/// A scene of the project: the file it stands in and how it is made.
struct Scene {
  std::string file;     ///< in scenes/, e.g. "goblet.obj"
  std::string comment;  ///< its first line says what it is
  std::function<PolygonMesh()> make;
};

/// All usable scenes, in the order of scenes/README.md.
[[nodiscard]] const std::vector<Scene>& scenes();

/// The scene as its OBJ file holds it: coordinates rounded to six decimals.
[[nodiscard]] PolygonMesh scene_mesh(const Scene& scene);

/// The bytes of the scene's OBJ file.
[[nodiscard]] std::string scene_text(const Scene& scene);

/// A file that must be refused, or taken with a warning.
struct BadFile {
  std::string file;   ///< in scenes/bad/
  int exit_code;      ///< without repair: 3 malformed, 4 mesh unusable, 0 taken with a warning
  int repaired;       ///< the same with repair
  std::string bytes;  ///< all of it
};

/// Every kind of malformed or unusable input, each as its smallest file.
[[nodiscard]] std::vector<BadFile> bad_files();

}  // namespace planish::shapes
