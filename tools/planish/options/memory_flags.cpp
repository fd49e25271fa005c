#include "options/memory_flags.h"
#include "planish/core/number_text.h"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "memory/large_arrays.h"
#include "options/size_value.h"
#include "planish/core/refuse.h"
#include "planish/job/text.h"
#include "planish/job/threads.h"

namespace planish::command {
namespace {

// What jobs take beside their large arrays, and the mesher of 100,000 points.
constexpr std::uint64_t kLeast = std::uint64_t{256} << 20, kMost = std::uint64_t{1} << 50;

// Of folders that will be made for the output, the one that is there.
std::filesystem::path folder_beside(const std::string& output) {
  std::filesystem::path folder =
      output == "-" ? std::filesystem::path() : std::filesystem::path(output).parent_path();
  std::error_code ignored;
  while (!folder.empty() && !std::filesystem::exists(folder, ignored))
    folder = folder.parent_path();
  return folder.empty() ? std::filesystem::path(".") : folder;
}

}  // namespace

void MemoryFlags::add_to(CLI::App& command) {
  // A thread keeps the budget.
  if (!kHasThreads) return;
  const auto group = "Memory";
  command
      .add_option("--memory", budget,
                  "most memory to take, mesher included: what is beyond lies in a temporary file "
                  "[no bound]")
      ->type_name("SIZE")
      ->group(group);
  command.add_option("--temporary", folder, "where that file lies [beside the output]")
      ->type_name("FOLDER")
      ->group(group);
}

void MemoryFlags::apply(const std::string& output) const {
  if (budget.empty()) {
    if (!folder.empty())
      refuse("--temporary", "is the folder of --memory SIZE, which is not given");
    return;
  }
  const std::uint64_t bytes = parse_size(budget, "--memory", kMost, "6G or 800M");
  if (bytes < kLeast)
    refuse("--memory", "{} are too little; the least that works is {}M", byte_size(bytes),
           kLeast >> 20);
  hold_arrays_within(bytes, folder.empty() ? folder_beside(output) : std::filesystem::path(folder));
}

}  // namespace planish::command
