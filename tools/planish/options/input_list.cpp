#include "options/input_list.h"

#include <algorithm>
#include <map>

#include "planish/core/error.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

namespace fs = std::filesystem;

std::string stem_of(const std::string& input) {
  return input == "-" ? "stdin" : fs::path(input).stem().string();
}

std::vector<std::string> files_in(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> paths;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    const auto format = format_of(entry->path());
    if (format && serves(*format, FormatUse::Read) && entry->is_regular_file(ignored))
      paths.push_back(entry->path().string());
  }
  if (error)
    throw Error(ErrorCode::UnreadableInput, visible(folder) + ": cannot read: " + error.message());
  if (paths.empty())
    throw Error(ErrorCode::UnreadableInput,
                formatted("{}: this folder holds no file that is read ({})", visible(folder),
                          extensions_of(FormatUse::Read)));
  std::ranges::sort(paths);
  return paths;
}

}  // namespace

InputList expand_inputs(const std::vector<std::string>& arguments) {
  InputList list;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (argument != "-" && fs::is_directory(argument, error)) {
      list.has_folder = true;
      const auto files = files_in(argument);
      list.paths.insert(list.paths.end(), files.begin(), files.end());
    } else {
      list.paths.push_back(argument);
    }
  }
  return list;
}

void require_distinct_stems(const std::vector<std::string>& paths) {
  std::map<std::string, std::string> by_stem;
  for (const std::string& path : paths) {
    const auto [known, is_new] = by_stem.emplace(stem_of(path), path);
    if (is_new) continue;
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("{} and {} would be written under one name, {}; fit one of them by itself",
                  visible(known->second), visible(path), visible(known->first)));
  }
}

bool names_folder(const std::string& path) {
  if (path.empty() || path == "-") return false;
  std::error_code error;
  return path.ends_with('/') || fs::is_directory(path, error);
}

std::string path_in_folder(const std::string& folder, const std::string& input, FileFormat format) {
  return (fs::path(folder) / (stem_of(input) + "." + std::string(name_of(format)))).string();
}

std::string output_beside(const std::string& input) {
  const std::string name = stem_of(input);
  return visible(name) +
         (fs::path(input).lexically_normal() == name + ".glb" ? "_surface.glb" : ".glb");
}

std::string job_name_of(const std::string& input) { return visible(stem_of(input)); }

}  // namespace planish::command
