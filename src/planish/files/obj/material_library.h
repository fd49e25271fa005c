#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

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
