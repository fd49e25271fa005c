#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json.h"

namespace planish::test {

/// A page's bytes, undone by other code than wrote them: as the viewer does it, in C++.
class PageReader {
 public:
  /// `head` and base64 as they stand in a page. `prefix`: "uv_" for the faces of the texture.
  PageReader(nlohmann::json head, std::string_view base64, const std::string& prefix = "");

  [[nodiscard]] const nlohmann::json& head() const { return head_; }
  [[nodiscard]] std::vector<std::int64_t> list(const std::string& name) const;
  /// All components of all vertices, in turn.
  [[nodiscard]] std::vector<std::int64_t> values(const std::string& name) const;

  /// Faces of every level, and what the vertices of each level from 1 on lie between.
  struct Level {
    std::vector<std::vector<std::int64_t>> faces, parents;
    std::int64_t count = 0;
  };
  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }

 private:
  [[nodiscard]] const nlohmann::json& section(const std::string& name) const;
  void split(std::vector<std::int64_t> cuts, bool triangles);

  nlohmann::json head_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Level> levels_;
};

/// What stands between the marks, from `from` on; empty where they do not stand.
[[nodiscard]] std::string between(std::string_view text, std::string_view begin,
                                  std::string_view end, std::size_t from = 0);

[[nodiscard]] std::vector<std::uint8_t> bytes_of_base64(std::string_view text);

}  // namespace planish::test
