#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace planish::test {

/// Names and bytes of all files below a folder, by name.
[[nodiscard]] inline std::vector<std::pair<std::string, std::string>> files_below(
    const std::filesystem::path& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files.emplace_back(std::filesystem::relative(entry.path(), folder).string(),
                       std::string{std::istreambuf_iterator<char>(file), {}});
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace planish::test
