#include "large_arrays.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include "planish/core/platform/files.h"
#include "planish/core/platform/machine.h"
#include "planish/core/words.h"
#include "planish/job/input.h"
#include "planish/reconstruct/mesher_process.h"
#include "planish/surface/memory_need.h"

namespace planish::command {
namespace {

// Of the budget, what may lie in arrays of memory that cannot leave it.
constexpr std::uint64_t kHeldPart = 4;
// What is held is looked at so often. Threads take tens of megabytes of pages meanwhile, so that
// the process is kept below the budget by a tenth of it, and by no less than this.
constexpr auto kLook = std::chrono::milliseconds(1);
constexpr std::uint64_t kSlackPart = 10, kLeastSlack = std::uint64_t{64} << 20;

struct Array {
  std::size_t bytes;
  bool is_in_file;
};

struct Counted {
  std::filesystem::path folder;
  std::string folder_name;
  std::uint64_t budget = 0;
  std::atomic<std::uint64_t> of_others = 0;
  std::mutex mutex;  // of what follows
  std::uint64_t held = 0;
  // Nothing is deleted under the lock, for that would ask for it: a node or a name may begin where
  // a page does, too, and a hash table would give its places back as it grows.
  std::map<void*, Array> arrays;
};
// Set once; used until the process has ended.
std::atomic<Counted*> current = nullptr;

void* map_in_file(const Counted& all, std::size_t bytes) {
  std::error_code error;
  const platform::File file = platform::open_nameless(all.folder, error);
  void* const array = error ? nullptr : platform::map_file(file.number(), bytes, error);
  if (array == nullptr) throw NoRoomForArray(all.folder_name.c_str(), bytes, error);
  return array;
}

void* map_in_memory(std::size_t bytes) {
  void* const array = platform::map_memory(bytes);
  if (array == nullptr) throw std::bad_alloc();
  return array;
}

void let_pages_go(Counted& all) {
  const std::lock_guard lock(all.mutex);
  for (const auto& [array, about] : all.arrays)
    if (about.is_in_file) platform::let_pages_go(array, about.bytes);
}

[[noreturn]] void keep_within(Counted& all) {
  while (true) {
    std::this_thread::sleep_for(kLook);
    const std::uint64_t slack = std::max(all.budget / kSlackPart, kLeastSlack);
    if (platform::resident_memory() + all.of_others + slack > all.budget) let_pages_go(all);
  }
}

}  // namespace

NoRoomForArray::NoRoomForArray(const char* folder, std::size_t bytes,
                               const std::error_code& reason) noexcept {
  std::snprintf(message_, sizeof message_,
                "--temporary: %.300s: cannot take room for %zu bytes: %s; name a folder with more",
                folder, bytes, std::strerror(reason.value()));
}

Failure job_failure() noexcept {
  try {
    throw;
  } catch (const NoRoomForArray& disk) {
    return {ErrorCode::OutOfMemory, disk.what()};
  } catch (...) {
    return current_failure(
        "out of memory; a lower --levels or a smaller mesh needs less, --memory SIZE puts what is "
        "beyond that into a temporary file");
  }
}

std::optional<ArrayBudget> array_budget() {
  const Counted* const all = current;
  if (all == nullptr) return std::nullopt;
  std::error_code failed;
  const auto disk = std::filesystem::space(all->folder, failed);
  return ArrayBudget{
      .bytes = all->budget, .folder = all->folder, .free_bytes = failed ? 0 : disk.available};
}

void hold_arrays_within(std::uint64_t bytes, const std::filesystem::path& folder) {
  auto* all = new Counted;
  all->folder = folder;
  all->folder_name = utf8(folder);
  all->budget = bytes;
  std::error_code error;
  (void)platform::open_nameless(folder, error);
  if (error)
    throw Error(ErrorCode::UnwritableOutput, formatted("--temporary: {}: cannot create a file: {}",
                                                       visible(folder), error.message()));
  current = all;
  set_memory_elsewhere(array_budget()->free_bytes);
  std::thread([all] { keep_within(*all); }).detach();
}

MemoryOfOthers::MemoryOfOthers(std::uint64_t bytes) : bytes_(bytes) {
  if (Counted* const all = current) all->of_others += bytes_;
}

MemoryOfOthers::~MemoryOfOthers() {
  if (Counted* const all = current) all->of_others -= bytes_;
}

Mesher require_counted_mesher() {
  return
      [mesher = require_mesher()](std::span<const glm::dvec3> points, const Callbacks& callbacks) {
        const MemoryOfOthers of_mesher(kMesherPointBytes * points.size());
        return mesher(points, callbacks);
      };
}

void* take_large_array(std::size_t bytes) {
  Counted* const all = current;
  if (all == nullptr) return nullptr;
  std::map<void*, Array> made;
  Array& about = made[nullptr] = {.bytes = bytes, .is_in_file = false};
  {
    const std::lock_guard lock(all->mutex);
    about.is_in_file = all->held + bytes > all->budget / kHeldPart;
    if (!about.is_in_file) all->held += bytes;
  }
  void* array = nullptr;
  try {
    array = about.is_in_file ? map_in_file(*all, bytes) : map_in_memory(bytes);
  } catch (...) {
    const std::lock_guard lock(all->mutex);
    if (!about.is_in_file) all->held -= bytes;
    throw;
  }
  auto node = made.extract(made.begin());
  node.key() = array;
  const std::lock_guard lock(all->mutex);
  all->arrays.insert(std::move(node));
  return array;
}

bool give_back_array(void* array) noexcept {
  Counted* const all = current;
  if (all == nullptr || reinterpret_cast<std::uintptr_t>(array) % platform::kLeastPage != 0)
    return false;
  std::map<void*, Array>::node_type taken;  // outlives the lock
  {
    const std::lock_guard lock(all->mutex);
    taken = all->arrays.extract(array);
    if (taken.empty()) return false;
    if (!taken.mapped().is_in_file) all->held -= taken.mapped().bytes;
  }
  platform::unmap(array, taken.mapped().bytes);
  return true;
}

}  // namespace planish::command
