#include "planish/files/mesh_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <utility>

#include "planish/core/error.h"
#include "planish/files/obj/read_obj.h"
#include "planish/files/off/read_off.h"
#include "planish/files/ply/read_ply.h"
#include "planish/files/stl/read_stl.h"
#include "planish/files/write_polygons.h"

namespace planish {
namespace {

constexpr std::array<std::pair<std::string_view, MeshFormat>, 6> kFormats = {{
    {"obj", MeshFormat::Obj},
    {"ply", MeshFormat::Ply},
    {"off", MeshFormat::Off},
    {"stl", MeshFormat::Stl},
    {"gltf", MeshFormat::Gltf},
    {"glb", MeshFormat::Glb},
}};

[[noreturn]] void fail_to_read(const std::filesystem::path& path, int error) {
  throw Error(ErrorCode::UnreadableInput, path.string() + ": cannot read: " + std::strerror(error));
}

struct Descriptor {
  int number;
  ~Descriptor() {
    if (number >= 0) ::close(number);
  }
};

}  // namespace

std::string_view name_of(MeshFormat format) {
  for (const auto& [name, value] : kFormats)
    if (value == format) return name;
  return "unknown";
}

std::optional<MeshFormat> format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [name, value] : kFormats)
    if (extension == "." + std::string(name)) return value;
  return std::nullopt;
}

MeshFile read_mesh(std::span<const std::byte> bytes, std::string_view name, MeshFormat format) {
  switch (format) {
    case MeshFormat::Obj:
      return read_obj(bytes, name);
    case MeshFormat::Ply:
      return read_ply(bytes, name);
    case MeshFormat::Off:
      return read_off(bytes, name);
    case MeshFormat::Stl:
      return read_stl(bytes, name);
    case MeshFormat::Gltf:
    case MeshFormat::Glb:
      break;
  }
  throw Error(ErrorCode::InvalidArgument,
              std::string(name) + ": glTF is read by read_gltf(), not by read_mesh()");
}

std::vector<std::byte> read_file(const std::filesystem::path& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.number < 0) fail_to_read(path, errno);
  struct stat status {};
  if (::fstat(file.number, &status) != 0) fail_to_read(path, errno);
  if (S_ISDIR(status.st_mode)) fail_to_read(path, EISDIR);
  // Pipes and /proc say 0 bytes, so that the size is only a first guess.
  constexpr std::size_t kPiece = std::size_t{1} << 16;
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size) + kPiece);
  std::size_t used = 0;
  for (;;) {
    if (used == bytes.size()) bytes.resize(2 * bytes.size());
    const ssize_t got = ::read(file.number, bytes.data() + used, bytes.size() - used);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail_to_read(path, errno);
    if (got == 0) break;
    used += static_cast<std::size_t>(got);
  }
  bytes.resize(used);
  return bytes;
}

void write_mesh(const std::filesystem::path& path, MeshFormat format, const PolygonMesh& mesh,
                const MeshWriteOptions& options) {
  write_polygons(path, format,
                 {.positions = mesh.positions,
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
                  .header = options.header});
}

}  // namespace planish
