#include "planish/job/temporary_folders.h"

#include <dirent.h>
#include <fcntl.h>
#include <unistd.h>

#include <set>
#include <string_view>

namespace planish {
namespace {

struct Folders {
  std::mutex moving;
  std::mutex mutex;  // of all
  std::set<std::filesystem::path> all;
};

// Never destroyed: a thread that waits for signals outlives main().
Folders& folders() {
  static auto* const instance = new Folders;
  return *instance;
}

// By its name in an open folder.
void remove_at(int folder, const char* name) noexcept {
  if (::unlinkat(folder, name, 0) == 0) return;
  const int opened = ::openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (opened < 0) return;
  DIR* const entries = ::fdopendir(opened);
  if (entries == nullptr) {
    ::close(opened);
    return;
  }
  while (const dirent* const entry = ::readdir(entries)) {
    const std::string_view inside = entry->d_name;
    if (inside != "." && inside != "..") remove_at(opened, entry->d_name);
  }
  ::closedir(entries);
  ::unlinkat(folder, name, AT_REMOVEDIR);
}

}  // namespace

void remove_folder(const std::filesystem::path& folder) noexcept {
  remove_at(AT_FDCWD, folder.c_str());
}

void add_temporary_folder(const std::filesystem::path& folder) {
  const std::scoped_lock lock(folders().mutex);
  folders().all.insert(folder);
}

void forget_temporary_folder(const std::filesystem::path& folder) {
  const std::scoped_lock lock(folders().mutex);
  folders().all.erase(folder);
}

std::unique_lock<std::mutex> while_files_move() { return std::unique_lock(folders().moving); }

void remove_temporary_folders() {
  folders().mutex.lock();  // for good
  for (const auto& folder : folders().all) remove_folder(folder);
}

}  // namespace planish
