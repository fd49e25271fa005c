#include "output/staged_files.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "terminal/interrupt.h"

namespace planish::command {
namespace fs = std::filesystem;

StagedFiles::~StagedFiles() {
  std::error_code ignored;
  for (const Folder& folder : folders_) {
    fs::remove_all(folder.temporary, ignored);
    forget_temporary_folder(folder.temporary);
  }
}

fs::path StagedFiles::stage(const fs::path& path) {
  const fs::path target = path.has_parent_path() ? path.parent_path() : fs::path(".");
  auto folder = std::ranges::find(folders_, target, &Folder::target);
  if (folder == folders_.end()) {
    std::error_code error;
    fs::create_directories(target, error);
    std::string name = (target / ".planish-XXXXXX").string();
    if (error || ::mkdtemp(name.data()) == nullptr) {
      throw Error(ErrorCode::UnwritableOutput,
                  visible(path) + ": cannot write into " + visible(target) + ": " +
                      (error ? error.message() : std::strerror(errno)));
    }
    folders_.push_back({target, name});
    add_temporary_folder(name);
    folder = folders_.end() - 1;
  }
  files_.push_back({folder->temporary / path.filename(), path});
  return files_.back().temporary;
}

void StagedFiles::commit() {
  const auto lock = while_files_move();
  check_interrupt();  // the last moment at which nothing has happened
  for (const File& file : files_) {
    std::error_code error;
    fs::rename(file.temporary, file.target, error);
    if (error) {
      throw Error(ErrorCode::UnwritableOutput,
                  visible(file.target) + ": cannot be put in place: " + error.message());
    }
  }
  files_.clear();
}

}  // namespace planish::command
