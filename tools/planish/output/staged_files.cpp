#include "output/staged_files.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "planish/core/output_file.h"
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

fs::path StagedFiles::stage_with_folder(const fs::path& document, const fs::path& folder) {
  fs::path staged = stage(document);
  files_.back().beside = folder;
  return staged;
}

void StagedFiles::write(const fs::path& path, std::string_view text) {
  const fs::path staged = stage(path);
  naming_targets([&] {
    OutputFile file(staged);
    file.write(text);
    file.commit();
  });
}

std::string StagedFiles::with_targets(std::string message) const {
  for (const Folder& folder : folders_) {
    const std::string hidden = visible(folder.temporary / "");
    const std::string shown = folder.target == "." ? std::string() : visible(folder.target / "");
    for (std::size_t at = message.find(hidden); at != std::string::npos;
         at = message.find(hidden, at))
      message.replace(at, hidden.size(), shown);
  }
  return message;
}

void StagedFiles::commit() {
  const auto lock = while_files_move();
  check_interrupt();  // the last moment at which nothing has happened
  for (const File& file : files_) move(file);
  files_.clear();
  std::error_code ignored;  // what stays is in nobody's way
  for (const fs::path& path : remains_) fs::remove(path, ignored);
  remains_.clear();
}

// A document that stands there goes first, then its folder; they are removed with the hidden
// folder.
void StagedFiles::move(const File& file) {
  std::error_code error;
  const auto rename = [&](const fs::path& from, const fs::path& to) {
    fs::rename(from, to, error);
    if (error) {
      throw Error(ErrorCode::UnwritableOutput,
                  visible(file.target) + ": cannot be put in place: " + error.message());
    }
  };
  if (!file.beside.empty()) {
    // The names may be as long as names can be, so that nothing can be added to them.
    const fs::path folder = file.temporary.parent_path();
    int number = 0;
    const auto put_away = [&](const fs::path& old) {
      if (!fs::exists(fs::symlink_status(old, error))) return;
      fs::path away;
      do {
        away = folder / (".replaced-" + std::to_string(number++));
      } while (fs::exists(fs::symlink_status(away, error)));
      rename(old, away);
    };
    put_away(file.target);
    put_away(file.beside);
    rename(file.temporary.parent_path() / file.beside.filename(), file.beside);
  }
  rename(file.temporary, file.target);
}

}  // namespace planish::command
