#include "planish/job/input.h"

#include <unistd.h>

#include <future>
#include <span>
#include <string>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/core/nearest.h"
#include "planish/core/stop.h"
#include "planish/core/visible_text.h"
#include "planish/files/read_file.h"
#include "planish/files/sniff_format.h"
#include "planish/job/digest.h"
#include "planish/job/text.h"
#include "planish/job/threads.h"

namespace planish {
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
    file.bytes = read_stream(STDIN_FILENO, file.name);
  } else {
    file.path = path;
    file.bytes = read_file(path, share_of(callbacks, 0, kFileLoaded));
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

}  // namespace planish
