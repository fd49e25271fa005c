#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/formats.h"
#include "planish/files/shared/ordered_stream.h"
#include "planish/files/write_polygons.h"

namespace planish {

/// A texture of a material, and where its image goes: u * size + offset.
struct MaterialTexture {
  std::filesystem::path path;
  glm::dvec2 size{1.0}, offset{0.0};  ///< -s and -o
  double scale = 1;                   ///< -bm
  bool clamps = false;                ///< -clamp on
};

/// A line of a material: its keyword in small letters, with numbers or a texture.
struct MaterialStatement {
  std::string keyword;
  std::vector<double> numbers;
  MaterialTexture texture;
};

struct NamedFile;

/// The materials of the files that an OBJ names, or of a glTF (materials.h), to be written
/// beside another.
class MaterialLibrary {
 public:
  MaterialLibrary() = default;
  /// Of the OBJ at `path`: all that `mtllib` lines in its first MiB name, relative to it. What is
  /// missing, or read_named() does not give, is a warning, "missing-materials".
  explicit MaterialLibrary(const std::filesystem::path& path, FileReach reach = FileReach::Beside);
  /// The same of an OBJ in memory, which has a path.
  explicit MaterialLibrary(const FileBytes& obj);

  /// A material of `lines`, with names of textures relative to `folder`; the first of a name
  /// counts.
  void add(const std::string& name, const std::filesystem::path& folder,
           std::vector<std::string> lines);
  void add_warning(Warning warning) { warnings_.push_back(std::move(warning)); }

  /// The statements of a material as they stand there, with names of textures relative to `folder`;
  /// empty: it is not known.
  [[nodiscard]] std::string statements(const std::string& material,
                                       const std::filesystem::path& folder) const;
  /// Those that are known, and what they say.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] std::vector<MaterialStatement> parsed(const std::string& material) const;
  [[nodiscard]] const std::vector<Warning>& warnings() const { return warnings_; }

  /// The OBJ, and how far its textures may lie, for read_named(); empty: of none.
  [[nodiscard]] const std::filesystem::path& obj() const { return obj_; }
  [[nodiscard]] FileReach reach() const { return reach_; }
  /// All that the OBJ names, and what these files name, there or not.
  [[nodiscard]] std::vector<std::filesystem::path> named_files() const;

 private:
  struct Material {
    std::filesystem::path folder;  ///< that names of textures are relative to
    std::vector<std::string> lines;
  };
  void read_libraries(std::string_view text);
  void read_line(std::string_view line);
  void read(const std::filesystem::path& path, const NamedFile& file);

  std::filesystem::path obj_;
  FileReach reach_ = FileReach::Beside;
  std::vector<std::filesystem::path> files_;  // that it names
  std::map<std::string, Material> materials_;
  std::vector<Warning> warnings_;
};

class OutputFile;

/// A name as a line of OBJ or MTL can hold it, with a blank in front: control characters, `#`
/// before a word and `\` at the end become `_`.
[[nodiscard]] std::string obj_line_name(const std::string& name);

/// Writes the materials as the library has them; the others each with a colour of its own, by which
/// a viewer shows what belongs together. The file is the caller's to commit. Throws
/// Error{UnwritableOutput}.
void write_mtl(OutputFile& file, std::span<const std::string> materials,
               const GivenMaterials& given = {});

/// The line of an OBJ file that names them.
void write_mtllib(FileBuffer& out, const std::string& file_name);

}  // namespace planish
