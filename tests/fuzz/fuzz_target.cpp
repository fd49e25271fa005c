// The libFuzzer program of all targets: by the name fuzz_NAME, which libFuzzer gives the processes
// that it starts, it fuzzes NAME. By any other it makes these links beside itself.
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/fuzz_read.h"
#include "fuzz/fuzz_targets.h"

namespace {

namespace fs = std::filesystem;
using planish::test::FuzzTarget;

FuzzTarget chosen;

void make_links(const std::vector<FuzzTarget>& targets) {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  for (const FuzzTarget& target : targets) {
    const fs::path link = program.parent_path() / ("fuzz_" + target.name);
    fs::remove(link);
    fs::create_symlink(program.filename(), link);
  }
}

}  // namespace

// Nearly every input ends with an exception, for each of which the address sanitizer walks over all
// its copies of stacks. ctest replays the corpus with them.
extern "C" const char* __asan_default_options() {
  return "detect_stack_use_after_return=0:malloc_context_size=4";
}

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  const std::vector<FuzzTarget> targets = planish::test::fuzz_targets();
  const std::string name = fs::path((*arguments)[0]).filename();
  const auto found = std::ranges::find_if(
      targets, [&](const FuzzTarget& target) { return "fuzz_" + target.name == name; });
  if (found == targets.end()) {
    make_links(targets);
    std::exit(0);
  }
  chosen = *found;
  // With -runs=0 a corpus is replayed.
  const std::span<char* const> given(*arguments, static_cast<std::size_t>(*count));
  if (std::ranges::find(given, std::string_view("-runs=0")) == given.end())
    planish::test::ask_all_of_one_in(4);
  // In memory: a disk waits for each of the small files that a target writes.
  if (fs::is_directory("/dev/shm")) ::setenv("TMPDIR", "/dev/shm", /*replace=*/0);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // What takes several threads would not go the same way twice.
  static const oneapi::tbb::global_control one_thread(
      oneapi::tbb::global_control::max_allowed_parallelism, 1);
  chosen.read(std::as_bytes(std::span(data, size)), chosen.format);
  return 0;
}
