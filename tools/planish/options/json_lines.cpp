#include "options/json_lines.h"

#include <vector>

namespace planish::command {
namespace {

// Walks over text that the parser has accepted.
class Walk {
 public:
  explicit Walk(std::string_view text) : text_(text) {}

  std::map<std::string, int> lines() {
    while (at_ < text_.size()) step();
    return std::move(lines_);
  }

 private:
  struct Level {
    bool is_list;
    std::string path;
    int index = 0;
    bool wants_key = true;
  };

  void step() {
    const char c = text_[at_];
    if (c == '\n') ++line_;
    if (c == '"') return take_text();
    if (c == '{' || c == '[') {
      note_entry();
      levels_.push_back({c == '[', path_});
    } else if (c == '}' || c == ']') {
      levels_.pop_back();
    } else if (c == ',') {
      if (levels_.back().is_list) ++levels_.back().index;
      levels_.back().wants_key = true;
    } else if (c == ':') {
      levels_.back().wants_key = false;
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '\n') {
      note_entry();
    }
    ++at_;
  }

  void take_text() {
    const std::size_t begin = at_ + 1;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_)
      if (text_[at_] == '\\') ++at_;
    const std::string_view content = text_.substr(begin, at_ - begin);
    ++at_;
    const bool is_key = !levels_.empty() && !levels_.back().is_list && levels_.back().wants_key;
    if (!is_key) return note_entry();
    const std::string& above = levels_.back().path;
    path_ = (above.empty() ? "" : above + ".") + std::string(content);
    lines_.emplace(path_, line_);
  }

  // A value in a list has a path of its own.
  void note_entry() {
    if (levels_.empty() || !levels_.back().is_list) return;
    path_ = levels_.back().path + "[" + std::to_string(levels_.back().index) + "]";
    lines_.emplace(path_, line_);
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::string path_;  // of the key or entry last met
  std::vector<Level> levels_;
  std::map<std::string, int> lines_;
};

}  // namespace

std::map<std::string, int> lines_of_json(std::string_view text) { return Walk(text).lines(); }

}  // namespace planish::command
