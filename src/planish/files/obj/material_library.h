#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <map>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"

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

/// The materials of the files that an OBJ names, to be written again beside another.
class MaterialLibrary {
 public:
  MaterialLibrary() = default;
  /// Of the OBJ at `path`: all that `mtllib` lines in its first MiB name, relative to it. What is
  /// missing is a warning, "missing-materials".
  explicit MaterialLibrary(const std::filesystem::path& path);

  /// The statements of a material as they stand there, with names of textures relative to `folder`;
  /// empty: it is not known.
  [[nodiscard]] std::string statements(const std::string& material,
                                       const std::filesystem::path& folder) const;
  /// Those that are known, and what they say.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] std::vector<MaterialStatement> parsed(const std::string& material) const;
  [[nodiscard]] const std::vector<Warning>& warnings() const { return warnings_; }

 private:
  struct Material {
    std::filesystem::path folder;  ///< that names of textures are relative to
    std::vector<std::string> lines;
  };
  void read(const std::filesystem::path& obj, const std::string& name);

  std::map<std::string, Material> materials_;
  std::vector<Warning> warnings_;
};

}  // namespace planish
