#include "planish/job/staged_files.h"

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/platform/files.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/read_file.h"

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

}  // namespace

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
  for (const auto& folder : folders().all) platform::remove_folder(folder);
}

namespace fs = std::filesystem;

namespace {

void rename(const fs::path& from, const fs::path& to, bool replaces, const fs::path& target) {
  const std::error_code error = platform::rename_file(from, to, replaces);
  if (!error) return;
  const bool has_come = error == std::errc::file_exists || error == std::errc::directory_not_empty;
  throw Error(ErrorCode::UnwritableOutput,
              has_come ? visible(to) + " exists by now; --force overwrites it"
                       : visible(target) + ": cannot be put in place: " + error.message());
}

fs::path staged_folder(const fs::path& temporary, const fs::path& beside) {
  return temporary.parent_path() / beside.filename();
}

void take_back(const fs::path& from, const fs::path& to) {
  [[maybe_unused]] const std::error_code ignored = platform::rename_file(from, to, true);
}

}  // namespace

StagedFiles::~StagedFiles() {
  for (const Folder& folder : folders_) {
    platform::remove_folder(folder.temporary);
    forget_temporary_folder(folder.temporary);
  }
}

fs::path StagedFiles::stage(const fs::path& path) {
  const fs::path target = path.has_parent_path() ? path.parent_path() : fs::path(".");
  auto folder = std::ranges::find(folders_, target, &Folder::target);
  if (folder == folders_.end()) {
    std::error_code error;
    fs::create_directories(target, error);
    fs::path name;
    if (!error) name = platform::make_temporary_folder(target, error);
    if (error) {
      throw Error(ErrorCode::UnwritableOutput,
                  formatted("{}: cannot write into {}: {}", visible(path), visible(target),
                            error.message()));
    }
    try {
      folders_.push_back({target, name});
    } catch (...) {
      platform::remove_folder(name);
      throw;
    }
    folder = folders_.end() - 1;
    add_temporary_folder(name);
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
  check_stop();  // the last moment at which nothing has happened
  std::size_t moved = 0;
  try {
    for (; moved < files_.size(); ++moved) move(files_[moved]);
  } catch (const Error&) {
    // What was replaced is gone; what was not can be as if nothing had happened.
    while (!overwrites_ && moved-- > 0) take_back(files_[moved].target, files_[moved].temporary);
    throw;
  }
  files_.clear();
  std::error_code ignored;  // what stays is in nobody's way
  for (const fs::path& path : remains_) fs::remove(path, ignored);
  remains_.clear();
}

void StagedFiles::move(const File& file) const {
  if (!file.beside.empty()) {
    if (overwrites_) put_away(file);
    // No folder that holds anything is replaced by another one.
    rename(staged_folder(file.temporary, file.beside), file.beside, true, file.target);
  }
  try {
    rename(file.temporary, file.target, overwrites_, file.target);
  } catch (const Error&) {
    if (!file.beside.empty()) take_back(file.beside, staged_folder(file.temporary, file.beside));
    throw;
  }
}

// A document that stands there goes first, then its folder; they are removed with the hidden
// folder.
void StagedFiles::put_away(const File& file) const {
  // The names may be as long as names can be, so that nothing can be added to them.
  const fs::path folder = file.temporary.parent_path();
  int number = 0;
  std::error_code ignored;
  for (const fs::path& old : {file.target, file.beside}) {
    if (!fs::exists(fs::symlink_status(old, ignored))) continue;
    fs::path away;
    do {
      away = folder / (formatted(".replaced-{}", number++));
    } while (fs::exists(fs::symlink_status(away, ignored)));
    rename(old, away, true, file.target);
  }
}

namespace {

// Documents of ours are far smaller.
constexpr std::uintmax_t kMostDocumentBytes = std::uintmax_t{1} << 26;

// How many buffers a document names that are named as its own would be.
std::size_t own_buffers(const fs::path& document) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(document, error)) ||
      fs::file_size(document, error) > kMostDocumentBytes || error)
    return 0;
  const RawVector<std::byte> text = read_named(document, document, FileReach::Anywhere).bytes;
  const auto* const letters = reinterpret_cast<const char*>(text.data());
  const nlohmann::json json = nlohmann::json::parse(letters, letters + text.size(), nullptr, false);
  if (!json.is_object() || !json.contains("buffers") || !json["buffers"].is_array()) return 0;
  std::size_t count = 0;
  for (const nlohmann::json& buffer : json["buffers"]) {
    const std::string name = encode_uri(utf8(gltf_buffer_path(document, count).filename()));
    if (!buffer.is_object() || buffer.value("uri", nlohmann::json()) != name) break;
    ++count;
  }
  return count;
}

}  // namespace

void stage_further_buffers(const PlannedOutput& planned, const fs::path& written,
                           StagedFiles& staged) {
  std::size_t count = 1;
  for (; fs::exists(gltf_buffer_path(written, count)); ++count) {
    const fs::path buffer = gltf_buffer_path(planned.path, count);
    (void)staged.stage(buffer);
  }
  if (!staged.overwrites()) return;
  for (const std::size_t end = own_buffers(planned.path); count < end; ++count)
    staged.remove_later(gltf_buffer_path(planned.path, count));
}

}  // namespace planish
