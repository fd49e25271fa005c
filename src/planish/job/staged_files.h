#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/error.h"
#include "planish/job/output_plan.h"

namespace planish {

/// A hidden folder of files that are not in place yet, in the list of the process.
void add_temporary_folder(const std::filesystem::path& folder);
void forget_temporary_folder(const std::filesystem::path& folder);

/// Held while files are put in place, so that all of them are there or none.
[[nodiscard]] std::unique_lock<std::mutex> while_files_move();

/// Removes all folders of the list, and lets nobody add one any more: for who ends the process
/// while jobs are under way, which must hold while_files_move().
void remove_temporary_folders();

/// Files that appear together: each is written into a hidden folder beside its place, commit()
/// moves all of them. Without commit the folders vanish with everything in them.
class StagedFiles {
 public:
  /// Without `overwrites` what stands at a file's place when commit() comes to it stays.
  explicit StagedFiles(bool overwrites) : overwrites_(overwrites) {}
  ~StagedFiles();
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;

  /// Where to write what shall become `path`. Makes missing folders.
  /// Throws Error{UnwritableOutput}.
  [[nodiscard]] std::filesystem::path stage(const std::filesystem::path& path);

  [[nodiscard]] bool overwrites() const { return overwrites_; }

  /// The same for a document and a folder beside it that it names: a document is in place only
  /// while its folder is, whatever ends the process. A folder that stands there is replaced whole;
  /// without `overwrites` only one that is empty is.
  [[nodiscard]] std::filesystem::path stage_with_folder(const std::filesystem::path& document,
                                                        const std::filesystem::path& folder);

  /// Writes what shall become `path`. Throws as above.
  void write(const std::filesystem::path& path, std::string_view text);

  /// What `work` returns. Errors of files that are staged by then name what shall become of them:
  /// nobody has asked for the hidden folder.
  template <class Work>
  auto naming_targets(const Work& work) {
    try {
      return work();
    } catch (const Error& error) {
      throw Error(error.code(), with_targets(error.what()), error.element());
    }
  }

  /// A file beside one that was staged, which goes when that has come: what an earlier one needed.
  void remove_later(const std::filesystem::path& path) { remains_.push_back(path); }

  /// Moves every file that was staged to its place. Throws Error{UnwritableOutput}; without
  /// `overwrites` those that were moved by then are taken back.
  void commit();

 private:
  struct Folder {
    std::filesystem::path target, temporary;
  };
  struct File {
    std::filesystem::path temporary, target;
    std::filesystem::path beside;  // a folder that goes with it; empty: none
  };
  void move(const File& file) const;
  void put_away(const File& file) const;
  [[nodiscard]] std::string with_targets(std::string message) const;

  bool overwrites_;
  std::vector<Folder> folders_;
  std::vector<File> files_;
  std::vector<std::filesystem::path> remains_;
};

/// Stages the buffers behind the first of a .gltf that stands in `written`. With --force, those
/// that the document in its place names beyond them, and that are named as its buffers are, go with
/// it: nobody else's. Throws Error{UnwritableOutput} where one exists and may not be replaced.
void stage_further_buffers(const PlannedOutput& planned, const std::filesystem::path& written,
                           StagedFiles& staged);

}  // namespace planish
