#pragma once

#include <filesystem>
#include <vector>

namespace planish::command {

/// Files that appear together: each is written into a hidden folder beside its place, commit()
/// moves all of them. Without commit the folders vanish with everything in them.
class StagedFiles {
 public:
  StagedFiles() = default;
  ~StagedFiles();
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;

  /// Where to write what shall become `path`. Makes missing folders.
  /// Throws Error{UnwritableOutput}.
  [[nodiscard]] std::filesystem::path stage(const std::filesystem::path& path);

  /// Moves every file that was staged to its place. Throws Error{UnwritableOutput}.
  void commit();

 private:
  struct Folder {
    std::filesystem::path target, temporary;
  };
  struct File {
    std::filesystem::path temporary, target;
  };
  std::vector<Folder> folders_;
  std::vector<File> files_;
};

}  // namespace planish::command
