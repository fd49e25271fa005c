#include "planish/files/mesh_file.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/read_file.h"
#include "planish/files/shared/text_lines.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/files/write_polygons.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

// More bytes than a surface has that 32-bit indices reach.
constexpr std::size_t kMostGltfBuffers = 128;
constexpr const char* kOtherName = "; choose another name";

// Where a path leads, by whatever links, there or not.
fs::path place_of(const fs::path& path) {
  std::error_code error;
  const fs::path whole = fs::absolute(path, error);
  const fs::path place = fs::weakly_canonical(whole, error);
  return platform::comparable(error ? whole.lexically_normal() : place);
}

std::optional<FileFormat> format_of_input(const fs::path& path, std::optional<FileFormat> format) {
  if (format) return format;
  if (const auto named = format_of(path); named && serves(*named, FormatUse::Read)) return named;
  constexpr std::uint64_t kHead = std::uint64_t{1} << 16;
  return sniff_format(read_named_start(path, path, FileReach::Anywhere, kHead).bytes);
}

}  // namespace

void InputFiles::add(const fs::path& input, std::optional<FileFormat> format, FileReach reach) {
  inputs_.push_back({input, format, reach});
  places_.emplace(place_of(input), input);
}

void InputFiles::look_into_inputs() const {
  for (; looked_into_ < inputs_.size(); ++looked_into_) {
    const Input& input = inputs_[looked_into_];
    if (const auto own = platform::identity_of(input.path)) readers_.emplace(*own, input.path);
    const auto format = format_of_input(input.path, input.format);
    if (!format || info_of(*format).named_files == nullptr) continue;
    for (const fs::path& file : info_of(*format).named_files(input.path, input.reach))
      if (const auto named = platform::identity_of(file)) readers_.emplace(*named, input.path);
  }
}

std::string InputFiles::objection(const fs::path& output) const {
  if (places_.contains(place_of(output)))
    return visible(output) + " is the input itself" + kOtherName;
  return objection_there(output);
}

std::string InputFiles::objection_there(const fs::path& output) const {
  const auto there = platform::identity_of(output);
  if (!there) return {};
  look_into_inputs();
  const auto reader = readers_.find(*there);
  if (reader == readers_.end()) return {};
  if (platform::identity_of(reader->second) == there)
    return formatted("{} is the input itself, {}{}", visible(output), visible(reader->second),
                     kOtherName);
  return formatted("{} is read with the input {}{}", visible(output), visible(reader->second),
                   kOtherName);
}

std::string InputFiles::objection(const fs::path& output, FileFormat format) const {
  if (std::string own = objection(output); !own.empty()) return own;
  std::vector<fs::path> others;
  if (const fs::path companion = companion_of(output, format); !companion.empty())
    others.push_back(companion);
  if (format == FileFormat::Gltf)
    for (std::size_t i = 1; i < kMostGltfBuffers; ++i)
      others.push_back(gltf_buffer_path(output, i));
  for (const fs::path& other : others)
    if (const std::string why = objection_there(other); !why.empty())
      return formatted("{} has a file beside it: {}", visible(output), why);
  return info_of(format).is_tiles ? objection_in(tile_folder(output)) : std::string();
}

std::string InputFiles::objection_in(const fs::path& folder) const {
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error))
    if (std::string why = objection_there(entry->path()); !why.empty()) return why;
  // Inputs that are not there yet.
  const fs::path whole = place_of(folder);
  for (const auto& [place, input] : places_)
    if (place.parent_path() == whole)
      return formatted("{}, the folder of the tiles, has the input {} in it{}", visible(folder),
                       visible(input), kOtherName);
  return {};
}

void require_apart(const InputFiles& inputs, const fs::path& output, FileFormat format) {
  if (const std::string why = inputs.objection(output, format); !why.empty())
    throw Error(ErrorCode::InvalidArgument, why);
}

void require_apart(const fs::path& input, const fs::path& output, FileFormat format) {
  if (input.empty()) return;
  InputFiles inputs;
  inputs.add(input);
  require_apart(inputs, output, format);
}

namespace {

// What a failed reader of `format` says, with what the content looks like.
std::string with_sniffed(const Error& error, std::span<const std::byte> bytes, FileFormat format) {
  const std::optional<FileFormat> sniffed = sniff_format(bytes);
  const auto is_number = [](FileFormat of) {  // numbers alone speak for nothing
    return of == FileFormat::Xyz || of == FileFormat::Pts || of == FileFormat::Ptx;
  };
  const bool is_other = sniffed && *sniffed != format && !is_number(*sniffed) &&
                        !(info_of(*sniffed).is_gltf && info_of(format).is_gltf);
  if (!is_other) return error.what();
  return formatted("{}; its content looks like {} (.{}): rename it, or name that as its format",
                   error.what(), info_of(*sniffed).title, info_of(*sniffed).name);
}

// What read(file) finds in the file's text, which has its warnings in front; the bytes read are
// told. Throws Error{UnreadableInput} for what stands in the place of a file, and says what the
// content looks like where it cannot be read as `format`.
template <class Found>
Found read_counted(const FileBytes& file, FileFormat format, const Callbacks& callbacks,
                   Found (*read)(const FileBytes&)) {
  if (const std::string_view foreign = foreign_content(file.bytes); !foreign.empty())
    throw Error(ErrorCode::UnreadableInput, formatted("{}: {}", file.name, foreign));
  TextFile text = text_file(file, format);
  ReadProgress progress(callbacks, text.file.bytes.size());
  text.file.progress = &progress;
  Found found;
  try {
    found = read(text.file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;
    throw Error(error.code(), with_sniffed(error, file.bytes, format), error.element());
  }
  found.warnings.insert(found.warnings.begin(), text.warnings.begin(), text.warnings.end());
  progress.finish();
  return found;
}

}  // namespace

MeshFile read_mesh(const FileBytes& file, FileFormat format, const Callbacks& callbacks) {
  const FormatInfo& info = info_of(format);
  if (!info.read_mesh && !info.read_points)
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} is written, not read", file.name, info.name));
  if (!info.read_mesh) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} holds points, and a polygon mesh is wanted; read_points() and "
                          "reconstruct() make one of them",
                          file.name, info.name));
  }
  return read_counted(file, format, callbacks, info.read_mesh);
}

MeshFile read_mesh(std::span<const std::byte> bytes, std::string_view name, FileFormat format) {
  return read_mesh(FileBytes{.bytes = bytes, .name = name, .path = {}}, format);
}

MeshFile read_mesh(const std::filesystem::path& path, const MeshReadOptions& options) {
  const auto format = options.format ? options.format : format_of(path);
  if (!format) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: the extension \"{}\" names no format of meshes that is read ({})",
                          visible(path), visible(path.extension()), names_of(FormatUse::ReadMesh)));
  }
  const RawVector<std::byte> bytes = read_file(path, share_of(options.callbacks, 0, kFileLoaded));
  const std::string name = visible(path);
  return read_mesh(FileBytes{.bytes = bytes,
                             .name = name,
                             .path = path,
                             .split_normals_crease = options.split_normals_crease,
                             .is_strict = options.is_strict,
                             .reach = options.reach},
                   *format, share_of(options.callbacks, kFileLoaded, 1));
}

void write_mesh(const std::filesystem::path& path, FileFormat format, const PolygonMesh& mesh,
                const MeshWriteOptions& options) {
  if (options.inputs != nullptr) require_apart(*options.inputs, path, format);
  std::vector<NamedField> fields;
  for (const VertexAttribute& attribute : mesh.attributes)
    fields.push_back({attribute.name, attribute.values, attribute.width});
  const PolygonView view{.positions = mesh.positions,
                         .normals = {},
                         .face_offsets = mesh.face_offsets,
                         .face_vertices = mesh.face_vertices,
                         .creases = mesh.creases,
                         .corners = mesh.corners,
                         .uvs = mesh.uvs,
                         .face_uvs = mesh.face_uvs,
                         .colors = mesh.colors,
                         .groups = mesh.groups,
                         .face_groups = mesh.face_groups,
                         .hole_faces = mesh.hole_faces,
                         .fields = fields,
                         .subdivision = options.subdivision,
                         .is_z_up = options.is_z_up,
                         .header = options.header};
  write_polygons(path, format, view, {}, options.materials);
}

PointCloud read_points(const FileBytes& file, FileFormat format, const Callbacks& callbacks) {
  const FormatInfo& info = info_of(format);
  if (!info.read_points) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} holds no points by themselves", file.name, info.name));
  }
  PointCloud cloud = read_counted(file, format, callbacks, info.read_points);
  recentre(cloud);
  return cloud;
}

PointCloud points_of(const MeshFile& file, std::string_view name) {
  PointCloud cloud = cloud_of(file.mesh.positions, name);
  cloud.missing_count = file.missing_count;
  cloud.normals = file.normals;
  cloud.colors = file.mesh.colors;
  cloud.attributes = file.mesh.attributes;
  return cloud;
}

PointCloud read_points(std::span<const std::byte> bytes, std::string_view name, FileFormat format) {
  return read_points(FileBytes{.bytes = bytes, .name = name, .path = {}}, format);
}

PointCloud read_points(const std::filesystem::path& path, const Callbacks& callbacks) {
  const auto format = format_of(path);
  if (!format || !serves(*format, FormatUse::ReadPoints)) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: the extension names no format of points ({})", visible(path),
                          names_of(FormatUse::ReadPoints)));
  }
  const RawVector<std::byte> bytes = read_file(path, share_of(callbacks, 0, kFileLoaded));
  const std::string name = visible(path);
  return read_points(FileBytes{.bytes = bytes, .name = name, .path = path}, *format,
                     share_of(callbacks, kFileLoaded, 1));
}

}  // namespace planish
