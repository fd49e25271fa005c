#include "job/input.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <future>
#include <string>

#include "options/nearest.h"
#include "output/digest.h"
#include "planish/core/error.h"
#include "planish/files/read_file.h"
#include "terminal/interrupt.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

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

FileFormat parse_mesh_format(std::string_view value, std::string_view where) {
  std::vector<std::string_view> names;
  for (const FormatInfo& info : formats()) {
    if (!info.read_mesh) continue;
    if (info.name == value) return info.format;
    names.push_back(info.name);
  }
  throw Error(ErrorCode::InvalidArgument, std::string(where) + ": \"" + plain_utf8(value) +
                                              "\" is not one of " + names_of(FormatUse::ReadMesh) +
                                              did_you_mean(value, names));
}

FileFormat input_format_of(const std::string& path, std::optional<FileFormat> format) {
  if (format) return *format;
  if (path == "-") {
    throw Error(ErrorCode::InvalidArgument,
                "stdin has no extension: name its format with --input-format");
  }
  const auto found = format_of(path);
  if (found && serves(*found, FormatUse::ReadMesh)) return *found;
  if (found) {
    throw Error(
        ErrorCode::InvalidArgument,
        path + ": is a point cloud, and a polygon mesh is wanted; planish reconstruct makes one");
  }
  throw Error(ErrorCode::InvalidArgument,
              path + ": the extension \"" + std::filesystem::path(path).extension().string() +
                  "\" names no format that is read (" + names_of(FormatUse::ReadMesh) +
                  "); name it with --input-format");
}

Input read_input(const std::string& path, std::optional<FileFormat> requested) {
  const FileFormat format = input_format_of(path, requested);
  Input input;
  if (path == "-") {
    const std::vector<std::byte> bytes = read_stdin();
    input.name = "stdin";
    input.sha256 = sha256(bytes);
    input.file = read_mesh(bytes, input.name, format);
    return input;
  }
  const RawVector<std::byte> bytes = read_file(path);
  input.name = path;
  // The digest takes as long as a reader: beside it.
  std::future<std::string> digest = std::async(std::launch::async, [&] { return sha256(bytes); });
  input.file = read_mesh(FileBytes{.bytes = bytes, .name = path, .path = path}, format);
  input.sha256 = digest.get();
  return input;
}

}  // namespace planish::command
