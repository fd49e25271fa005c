#include "planish/job/input.h"

#include <algorithm>
#include <array>
#include <future>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/job/build_info.h"
#include "planish/job/digest.h"
#include "planish/job/job_text.h"
#include "planish/job/report.h"
#include "planish/reconstruct/mesher_process.h"

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
  std::string extension = lower_case(utf8(path.extension()));
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
    const std::string name = utf8(entry->path().filename());
    const auto format = format_of(path_of(name));
    if (format && serves(*format, FormatUse::Read) && names.size() < kLooked) names.push_back(name);
  }
  std::ranges::sort(names);
  const std::string wanted = utf8(path.filename());
  for (const std::string& name : names)
    if (lower_case(name) == lower_case(wanted)) return utf8(path.parent_path() / path_of(name));
  const std::vector<std::string_view> known(names.begin(), names.end());
  const auto found = nearest(wanted, known);
  return found ? utf8(path.parent_path() / path_of(*found)) : std::string();
}

std::string missing_file_hint(const std::string& path) {
  if (path.starts_with("file://"))
    return "; a path is wanted, not a URL: " + visible(std::string_view(path).substr(7));
  if (path.find("://") != std::string::npos) return "; a file of this machine is wanted, not a URL";
  if (path.starts_with('~'))
    return "; the shell puts a home folder in place of ~ only where it stands unquoted at the "
           "front";
  const std::string near = nearest_file(path_of(path));
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
  const fs::path place = path_of(path);
  std::error_code error;
  const bool exists = fs::exists(place, error);
  if (!exists) {
    if (!error) error = std::make_error_code(std::errc::no_such_file_or_directory);
    throw Error(ErrorCode::UnreadableInput,
                shown + ": cannot read: " + error.message() + missing_file_hint(path));
  }
  if (fs::is_directory(place, error))
    throw Error(ErrorCode::UnreadableInput, shown + ": is a folder; name the files in it");
  if (const std::error_code refused = platform::may_read(place))
    throw Error(ErrorCode::UnreadableInput, shown + ": cannot read: " + refused.message());
  const std::string converter = conversion_to_readable(place);
  const auto named = format_of(place);
  const bool is_read = named && serves(*named, FormatUse::Read);
  if (!format && !is_read && !converter.empty())
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {} is not read ({} are); {}", shown, foreign_format(place)->title,
                          names_of(FormatUse::Read), converter));
}

namespace {

FileFormat settled_format(const InputFile& file, std::optional<FileFormat> format) {
  if (format) return *format;
  // A document of tiles has the extension of any JSON.
  if (const auto named = format_of(file.path); named && !info_of(*named).is_tiles) return *named;
  if (const auto sniffed = sniff_format(file.bytes)) return *sniffed;
  throw Error(ErrorCode::UnreadableInput,
              file.name + ": neither name nor content is that of a format that is read (" +
                  names_of(FormatUse::Read) + "); name it with --input-format");
}

}  // namespace

InputFile load_input(const std::string& path, std::optional<FileFormat> format,
                     const Callbacks& callbacks) {
  InputFile file;
  file.name = input_name(path);
  if (path == "-") {
    callbacks.report("read", 0);
    file.bytes = read_stream(platform::kStandardInput, file.name);
  } else {
    file.path = path_of(path);
    file.bytes = read_file(file.path, share_of(callbacks, 0, kFileLoaded));
  }
  if (const std::string_view foreign = foreign_content(file.bytes); !foreign.empty())
    throw Error(ErrorCode::UnreadableInput, formatted("{}: {}", file.name, foreign));
  file.format = settled_format(file, format);
  return file;
}

void InputFile::take_digest() {
  // It takes as long as a reader: beside it. Moving the file leaves its bytes in place.
  digest = std::async(kHasThreads ? std::launch::async : std::launch::deferred,
                      [all = std::span<const std::byte>(bytes), stop = AdoptedStop::current()] {
                        const AdoptedStop adopted(stop);
                        return planish::sha256(all);
                      });
}

Input mesh_of(const InputFile& file, const Callbacks& callbacks) {
  if (holds_points_only(file.format)) {
    throw Error(ErrorCode::InvalidArgument,
                file.name + ": holds points, and a mesh is wanted here; \"planish reconstruct " +
                    file.name + " -o mesh.obj\" makes one of them");
  }
  Input input{
      .name = file.name,
      .file = read_mesh(file.for_reader(), file.format, share_of(callbacks, kFileLoaded, 1)),
      .sha256 = {}};
  input.sha256 = file.sha256();
  return input;
}

Input read_input(const std::string& path, FileReach reach, const Callbacks& callbacks) {
  InputFile file = load_input(path, std::nullopt, callbacks);
  file.reach = reach;
  return mesh_of(file, callbacks);
}

FileFormat parse_input_format(std::string_view value, std::string_view where) {
  std::vector<std::string_view> names;
  for (const FormatInfo& info : formats()) {
    if (!serves(info.format, FormatUse::Read)) continue;
    if (info.name == value) return info.format;
    names.push_back(info.name);
  }
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: \"{}\" is not one of {}{}", where, visible(value),
                        names_of(FormatUse::Read), did_you_mean(value, names)));
}

bool is_point_path(const std::string& path, std::optional<FileFormat> format) {
  if (!format) format = format_of(path_of(path));
  return format && holds_points_only(*format);
}

void require_readable(const std::string& path, std::optional<FileFormat> format) {
  require_input(path, format);
  if (is_point_path(path, format)) (void)require_mesher();
}

PointInput points_of(const InputFile& file, const Callbacks& callbacks) {
  if (!serves(file.format, FormatUse::ReadPoints))
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} is no format of points ({} are)", file.name,
                          name_of(file.format), names_of(FormatUse::ReadPoints)));
  return {.name = file.name,
          .cloud = read_points(FileBytes{.bytes = file.bytes,
                                         .name = file.name,
                                         .path = file.path,
                                         .is_strict = file.is_strict},
                               file.format, share_of(callbacks, kFileLoaded, 1)),
          .sha256 = file.sha256(),
          .format = file.format};
}

std::optional<PointInput> points_of(const Input& input) {
  const PolygonMesh& mesh = input.file.mesh;
  // Fewer make no surface: such a file of another format is a mesh that lacks its faces.
  const std::size_t least = input.file.format == FileFormat::Ply ? 1 : 4;
  if (!serves(input.file.format, FormatUse::ReadPoints) || mesh.face_count() > 0 ||
      mesh.positions.size() < least)
    return std::nullopt;
  return PointInput{.name = input.name,
                    .cloud = planish::points_of(input.file, input.name),
                    .sha256 = input.sha256};
}

Mesher require_mesher() {
  auto program = find_mesher_program();
  if (!program)
    throw Error(ErrorCode::NoDevice,
                "points need the program planish-reconstruct, which is not installed (a build "
                "with CGAL makes it; it is found beside planish, on PATH or by "
                "PLANISH_RECONSTRUCT); a polygon mesh needs none");
  return mesher_process(std::move(*program));
}

namespace {

// Degrees are metres neither here nor there: beside heights they are a line.
std::string geographic_hint(const PointCloud& cloud) {
  constexpr double kLeastHeights = 100;  // times the width
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const glm::dvec3& point : cloud.points) {
    low = glm::min(low, cloud.origin + point);
    high = glm::max(high, cloud.origin + point);
  }
  const glm::dvec3 size = high - low;
  const bool may_be_degrees = low.x >= -180 && high.x <= 180 && low.y >= -90 && high.y <= 90;
  const bool are_flat = kLeastHeights * std::max(size.x, size.y) > size.z || size.z == 0;
  if (!may_be_degrees || are_flat) return {};
  return formatted(
      "; x from {} and y from {} look geographic, degrees of longitude and latitude: "
      "project them to metres first (\"pdal translate\" with filters.reprojection)",
      short_number(low.x), short_number(low.y));
}

}  // namespace

Reconstruction reconstruct_input(const PointInput& input, const Mesher& mesher,
                                 const ReconstructOptions& options) {
  for (const Warning& warning : input.cloud.warnings) options.callbacks.warn(warning);
  if (input.cloud.missing_count > 0)
    options.callbacks.warn(
        {.code = "missing-points",
         .message =
             input.name + ": " + counted(input.cloud.missing_count, "point") +
             (input.format == FileFormat::Ptx   ? " at the scanner's own place or not numbers, "
                                                  "where it saw nothing: left out"
              : input.format == FileFormat::Las ? " with the least 32-bit number for a coordinate, "
                                                  "which stands for none: left out"
              : input.cloud.missing_count == 1  ? " is not a number and left out"
                                                : " are not numbers and left out"),
         .count = input.cloud.missing_count});
  try {
    return reconstruct(input.cloud, mesher, options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnusableMesh) throw;
    throw Error(error.code(), input.name + ": " + error.what() + geographic_hint(input.cloud),
                error.element());
  }
}

PointFacts facts_of(const PointInput& input, const Reconstruction& result) {
  return {.points = std::ssize(input.cloud.points),
          .missing = input.cloud.missing_count,
          .used = std::ssize(result.used_points),
          .origin = input.cloud.origin,
          .mesh = result};
}

// Where points were moved.
std::string noise_line(const ReconstructionFigures& result) {
  if (result.smooth_rounds == 0) return {};
  std::string line = "  noise       ";
  if (result.noise >= 0)
    line += short_number(result.noise / result.diagonal) + " of the diagonal; ";
  return formatted("{}points moved onto local fits {}, mesh within {}; --smooth 0 leaves them\n",
                   line,
                   result.smooth_rounds == 1 ? "once" : formatted("{} times", result.smooth_rounds),
                   short_number(result.tolerance));
}

std::string points_text(const PointFacts& points) {
  const ReconstructionFigures& result = points.mesh;
  const MeshStatistics& facts = result.statistics;
  return formatted(
      "  points      {}, {} used, spacing {} of the diagonal\n{}  mesh        {}, {}, genus {}, "
      "{}; farthest point {}, rms {} of the diagonal\n",
      with_separators(points.points), with_separators(points.used),
      short_number(result.spacing / result.diagonal), noise_line(result),
      counted(facts.vertex_count, "vertex"), counted(facts.face_count, "face"), facts.genus,
      counted(facts.boundary_loop_count, "boundary loop"),
      short_number(result.distances.max / result.diagonal),
      short_number(result.distances.rms / result.diagonal));
}

}  // namespace planish
