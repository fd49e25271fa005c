#include "large_arrays.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <thread>

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
  std::string folder;
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

// A file that has no name, so that nothing is left of it.
int open_nameless(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  // Some file systems have no such files.
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return file;
  std::string name = folder + "/.planish-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

void* map_in_file(const std::string& folder, std::size_t bytes) {
  const auto refuse = [&](int reason) { throw NoRoomForArray(folder.c_str(), bytes, reason); };
  const int file = open_nameless(folder);
  if (file < 0) refuse(errno);
  // A page without room on the disk would end the process when it is written to.
  const int failed = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
  void* const array = failed != 0
                          ? MAP_FAILED
                          : ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  const int reason = failed != 0 ? failed : errno;
  ::close(file);
  if (array == MAP_FAILED) refuse(reason);
  return array;
}

void* map_in_memory(std::size_t bytes) {
  void* const array =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (array == MAP_FAILED) throw std::bad_alloc();
  return array;
}

std::uint64_t resident_bytes() {
  static const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  unsigned long long all = 0, resident = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%llu %llu", &all, &resident) != 2) resident = 0;
    std::fclose(file);
  }
  return page * resident;
}

// Their content stays in the file, or on its way there.
void let_pages_go(Counted& all) {
  const std::lock_guard lock(all.mutex);
  for (const auto& [array, about] : all.arrays)
    if (about.is_in_file) ::madvise(array, about.bytes, MADV_DONTNEED);
}

[[noreturn]] void keep_within(Counted& all) {
  while (true) {
    std::this_thread::sleep_for(kLook);
    const std::uint64_t slack = std::max(all.budget / kSlackPart, kLeastSlack);
    if (resident_bytes() + all.of_others + slack > all.budget) let_pages_go(all);
  }
}

}  // namespace

NoRoomForArray::NoRoomForArray(const char* folder, std::size_t bytes, int reason) noexcept {
  std::snprintf(message_, sizeof message_,
                "--temporary: %.300s: cannot take room for %zu bytes: %s; name a folder with more",
                folder, bytes, std::strerror(reason));
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
  all->folder = folder.string();
  all->budget = bytes;
  const int file = open_nameless(all->folder);
  if (file < 0)
    throw Error(ErrorCode::UnwritableOutput, formatted("--temporary: {}: cannot create a file: {}",
                                                       visible(folder), std::strerror(errno)));
  ::close(file);
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
    array = about.is_in_file ? map_in_file(all->folder, bytes) : map_in_memory(bytes);
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
  // Mappings begin where pages do.
  if (all == nullptr || reinterpret_cast<std::uintptr_t>(array) % 4096 != 0) return false;
  std::map<void*, Array>::node_type taken;  // outlives the lock
  {
    const std::lock_guard lock(all->mutex);
    taken = all->arrays.extract(array);
    if (taken.empty()) return false;
    if (!taken.mapped().is_in_file) all->held -= taken.mapped().bytes;
  }
  ::munmap(array, taken.mapped().bytes);
  return true;
}

}  // namespace planish::command
