#include "job/input.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "options/nearest.h"
#include "output/digest.h"
#include "planish/core/error.h"
#include "planish/files/gltf/read_gltf.h"
#include "terminal/interrupt.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

constexpr std::array kFormats{MeshFormat::Obj, MeshFormat::Ply,  MeshFormat::Off,
                              MeshFormat::Stl, MeshFormat::Gltf, MeshFormat::Glb};
constexpr std::array<std::string_view, 3> kPointFormats{".xyz", ".pts", ".pcd"};

std::vector<std::byte> read_stdin() {
  constexpr std::size_t kChunk = 1 << 20;
  std::vector<std::byte> bytes;
  std::size_t size = 0;
  while (true) {
    check_interrupt();
    bytes.resize(size + kChunk);
    const ssize_t count = ::read(STDIN_FILENO, bytes.data() + size, kChunk);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      throw Error(ErrorCode::UnreadableInput, std::string("stdin: ") + std::strerror(errno));
    }
    size += static_cast<std::size_t>(count);
    if (count == 0) break;
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

MeshFormat parse_mesh_format(std::string_view value, std::string_view where) {
  std::vector<std::string_view> names;
  for (const MeshFormat format : kFormats) {
    if (name_of(format) == value) return format;
    names.push_back(name_of(format));
  }
  throw Error(ErrorCode::InvalidArgument, std::string(where) + ": \"" + plain_utf8(value) +
                                              "\" is not one of obj, ply, off, stl, gltf, glb" +
                                              did_you_mean(value, names));
}

MeshFormat input_format_of(const std::string& path, std::optional<MeshFormat> format) {
  if (format) return *format;
  if (path == "-") {
    throw Error(ErrorCode::InvalidArgument,
                "stdin has no extension: name its format with --input-format");
  }
  if (const auto found = format_of(path)) return *found;
  const std::string extension = std::filesystem::path(path).extension().string();
  if (std::ranges::find(kPointFormats, extension) != kPointFormats.end()) {
    throw Error(
        ErrorCode::InvalidArgument,
        path + ": is a point cloud, and a polygon mesh is wanted; planish reconstruct makes one");
  }
  throw Error(ErrorCode::InvalidArgument,
              path + ": the extension \"" + extension +
                  "\" names no format that is read (obj, ply, off, stl, gltf, glb); name it with "
                  "--input-format");
}

Input read_input(const std::string& path, std::optional<MeshFormat> requested) {
  const MeshFormat format = input_format_of(path, requested);
  Input input;
  input.name = path == "-" ? "stdin" : path;
  const std::vector<std::byte> bytes = path == "-" ? read_stdin() : read_file(path);
  input.sha256 = sha256(bytes);
  if (format == MeshFormat::Glb || (format == MeshFormat::Gltf && path == "-")) {
    input.file = read_gltf(bytes, input.name);
  } else if (format == MeshFormat::Gltf) {
    input.file = read_gltf(path);  // it finds its buffers beside it
  } else {
    input.file = read_mesh(bytes, input.name, format);
  }
  input.file.format = format;
  return input;
}

}  // namespace planish::command
