#pragma once

#include <fstream>
#include <map>
#include <string>

namespace planish {

/// Copies a form, line by line, to a stub; a line of `marks` ("    @FIT_KEYWORDS@") becomes the
/// lines that it stands for. False where a file fails.
[[nodiscard]] inline bool write_stub(const std::string& form, const std::string& stub,
                                     const std::map<std::string, std::string>& marks) {
  std::ifstream from(form);
  std::ofstream to(stub);
  for (std::string line; std::getline(from, line);) {
    const auto mark = marks.find(line);
    to << (mark == marks.end() ? line + "\n" : mark->second);
  }
  to.close();
  return from.eof() && to;
}

}  // namespace planish
