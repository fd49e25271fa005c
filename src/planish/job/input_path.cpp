#include "planish/job/input_path.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/lower_case.h"
#include "planish/core/nearest.h"
#include "planish/core/visible_text.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

// Formats that people have meshes in and planish does not read, and what converts each.
struct ForeignFormat {
  std::string_view extension, title, converter;
  std::string_view target = ".glb";  // what is read of what it writes
};

constexpr std::string_view kAssimp = "assimp export", kPdal = "pdal translate",
                           kCloudCompare = "CloudCompare";
constexpr std::array kForeign{ForeignFormat{"step", "STEP", "FreeCAD or gmsh"},
                              ForeignFormat{"stp", "STEP", "FreeCAD or gmsh"},
                              ForeignFormat{"iges", "IGES", "FreeCAD or gmsh"},
                              ForeignFormat{"igs", "IGES", "FreeCAD or gmsh"},
                              ForeignFormat{"brep", "BREP", "FreeCAD or gmsh"},
                              ForeignFormat{"fbx", "FBX", kAssimp},
                              ForeignFormat{"dae", "COLLADA", kAssimp},
                              ForeignFormat{"3ds", "3DS", kAssimp},
                              ForeignFormat{"3mf", "3MF", kAssimp},
                              ForeignFormat{"x3d", "X3D", kAssimp},
                              ForeignFormat{"stl", "STL", kAssimp},
                              ForeignFormat{"amf", "AMF", "MeshLab"},
                              ForeignFormat{"vtk", "VTK", "MeshLab"},
                              ForeignFormat{"laz", "LAZ", kPdal, ".las"},
                              ForeignFormat{"e57", "E57", kCloudCompare, ".ply"},
                              ForeignFormat{"usd", "USD", "Blender"},
                              ForeignFormat{"usda", "USD", "Blender"},
                              ForeignFormat{"usdc", "USD", "Blender"},
                              ForeignFormat{"usdz", "USD", "Blender"},
                              ForeignFormat{"abc", "Alembic", "Blender"},
                              ForeignFormat{"blend", "a Blender scene", "Blender"}};

const ForeignFormat* foreign_format(const fs::path& path) {
  std::string extension = lower_case(path.extension().string());
  if (extension.empty()) return nullptr;
  extension.erase(0, 1);
  const auto found = std::ranges::find(kForeign, extension, &ForeignFormat::extension);
  return found == kForeign.end() ? nullptr : &*found;
}

std::string conversion(const ForeignFormat& format, const fs::path& from, const fs::path& to) {
  if (format.converter == kCloudCompare)
    return "\"CloudCompare -SILENT -O " + visible(from) +
           " -C_EXPORT_FMT PLY -SAVE_CLOUDS\" converts it";
  if (format.converter != kAssimp && format.converter != kPdal)
    return std::string(format.converter) + " converts it";
  return formatted("\"{} {} {}\" converts it", format.converter, visible(from), visible(to));
}

// A readable file of nearly that name beside it.
std::string nearest_file(const fs::path& path) {
  constexpr std::size_t kLooked = 10'000;  // of a folder
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const auto format = format_of(name);
    if (format && serves(*format, FormatUse::Read) && names.size() < kLooked) names.push_back(name);
  }
  std::ranges::sort(names);
  const std::string wanted = path.filename().string();
  for (const std::string& name : names)
    if (lower_case(name) == lower_case(wanted)) return (path.parent_path() / name).string();
  const std::vector<std::string_view> known(names.begin(), names.end());
  const auto found = nearest(wanted, known);
  return found ? (path.parent_path() / *found).string() : std::string();
}

std::string missing_file_hint(const std::string& path) {
  if (path.starts_with("file://"))
    return "; a path is wanted, not a URL: " + visible(std::string_view(path).substr(7));
  if (path.find("://") != std::string::npos) return "; a file of this machine is wanted, not a URL";
  if (path.starts_with('~'))
    return "; the shell puts a home folder in place of ~ only where it stands unquoted at the "
           "front";
  const std::string near = nearest_file(path);
  return near.empty() ? "" : "; did you mean " + visible(near) + "?";
}

}  // namespace

std::string conversion_to_readable(const fs::path& path) {
  const ForeignFormat* format = foreign_format(path);
  if (format == nullptr) return {};
  fs::path to = path.filename();
  return conversion(*format, path, to.replace_extension(format->target));
}

std::string conversion_from_glb(const fs::path& path) {
  const ForeignFormat* format = foreign_format(path);
  if (format == nullptr || format->target != ".glb") return {};
  fs::path from = path;
  return "from a .glb " + conversion(*format, from.replace_extension(".glb"), path);
}

void require_input(const std::string& path, std::optional<FileFormat> format) {
  if (path == "-") return;
  const std::string shown = visible(path);
  std::error_code error;
  const bool exists = fs::exists(path, error);
  if (!exists) {
    const int reason = error ? error.value() : ENOENT;
    throw Error(ErrorCode::UnreadableInput,
                shown + ": cannot read: " + std::strerror(reason) + missing_file_hint(path));
  }
  if (fs::is_directory(path, error))
    throw Error(ErrorCode::UnreadableInput, shown + ": is a folder; name the files in it");
  if (::access(path.c_str(), R_OK) != 0)
    throw Error(ErrorCode::UnreadableInput, shown + ": cannot read: " + std::strerror(errno));
  const std::string converter = conversion_to_readable(path);
  const auto named = format_of(path);
  const bool is_read = named && serves(*named, FormatUse::Read);
  if (!format && !is_read && !converter.empty())
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {} is not read ({} are); {}", shown, foreign_format(path)->title,
                          names_of(FormatUse::Read), converter));
}

}  // namespace planish
