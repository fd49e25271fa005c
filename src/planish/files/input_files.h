#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planish/files/formats.h"

namespace planish {

/// What a piece of work reads: its inputs, and the files that these name (buffers, images,
/// materials, textures). No output may take the place of one of them, by whatever name: files are
/// told apart by the system's numbers for them, behind links.
class InputFiles {
 public:
  /// An input, there or not yet. `format`: empty: by the extension, or else the content. `reach`:
  /// of what it names.
  void add(const std::filesystem::path& input, std::optional<FileFormat> format = {},
           FileReach reach = FileReach::Beside);

  /// Why nothing may be written to `output`: "b.bin is read with the input a.gltf; ..."; empty: it
  /// may. Costs next to nothing where no file is there.
  [[nodiscard]] std::string objection(const std::filesystem::path& output) const;
  /// The same of all files that an output of a format writes or removes: its own, those beside it
  /// (.bin, .mtl), the folder of its tiles.
  [[nodiscard]] std::string objection(const std::filesystem::path& output, FileFormat format) const;
  /// The same of a folder that gives way with all that is in it.
  [[nodiscard]] std::string objection_in(const std::filesystem::path& folder) const;

 private:
  using Identity = std::pair<std::uint64_t, std::uint64_t>;  // device and file
  struct Input {
    std::filesystem::path path;
    std::optional<FileFormat> format;
    FileReach reach;
  };
  [[nodiscard]] static std::optional<Identity> identity_of(const std::filesystem::path& path);
  void look_into_inputs() const;
  // Of a file that is there.
  [[nodiscard]] std::string objection_there(const std::filesystem::path& output) const;

  std::vector<Input> inputs_;
  std::map<std::filesystem::path, std::filesystem::path> places_;  // of inputs, links resolved
  // Which input reads a file. Inputs are looked into when it is first asked what they name.
  mutable std::map<Identity, std::filesystem::path> readers_;
  mutable std::size_t looked_into_ = 0;
};

/// Throws Error{InvalidArgument} where there is an objection to an output of that format.
void require_apart(const InputFiles& inputs, const std::filesystem::path& output,
                   FileFormat format);
/// The same for one input that was read.
void require_apart(const std::filesystem::path& input, const std::filesystem::path& output,
                   FileFormat format);

}  // namespace planish
