#include "planish/files/input_files.h"

#include <sys/stat.h>

#include <cstddef>

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/read_file.h"
#include "planish/files/sniff_format.h"
#include "planish/files/tiles/write_tiles.h"

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
  fs::path place = fs::weakly_canonical(whole, error);
  return error ? whole.lexically_normal() : place;
}

std::optional<FileFormat> format_of_input(const fs::path& path, std::optional<FileFormat> format) {
  if (format) return format;
  if (const auto named = format_of(path); named && serves(*named, FormatUse::Read)) return named;
  constexpr std::uint64_t kHead = std::uint64_t{1} << 16;
  return sniff_format(read_named_start(path, path, FileReach::Anywhere, kHead).bytes);
}

}  // namespace

std::optional<InputFiles::Identity> InputFiles::identity_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return Identity{status.st_dev, status.st_ino};
}

void InputFiles::add(const fs::path& input, std::optional<FileFormat> format, FileReach reach) {
  inputs_.push_back({input, format, reach});
  places_.emplace(place_of(input), input);
}

void InputFiles::look_into_inputs() const {
  for (; looked_into_ < inputs_.size(); ++looked_into_) {
    const Input& input = inputs_[looked_into_];
    if (const auto own = identity_of(input.path)) readers_.emplace(*own, input.path);
    const auto format = format_of_input(input.path, input.format);
    if (!format || info_of(*format).named_files == nullptr) continue;
    for (const fs::path& file : info_of(*format).named_files(input.path, input.reach))
      if (const auto named = identity_of(file)) readers_.emplace(*named, input.path);
  }
}

std::string InputFiles::objection(const fs::path& output) const {
  if (places_.contains(place_of(output)))
    return visible(output) + " is the input itself" + kOtherName;
  return objection_there(output);
}

std::string InputFiles::objection_there(const fs::path& output) const {
  const auto there = identity_of(output);
  if (!there) return {};
  look_into_inputs();
  const auto reader = readers_.find(*there);
  if (reader == readers_.end()) return {};
  if (identity_of(reader->second) == there)
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

}  // namespace planish
