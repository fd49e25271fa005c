#include "edit_script.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"

namespace planish::viewer {
namespace {

constexpr int kMostScriptFrames = 10000, kMostScriptSteps = 100000;

// The words of a line, from the second on, as what a step wants.
class ScriptWords {
 public:
  ScriptWords(const std::string& line, std::string where) : where_(std::move(where)) {
    std::istringstream stream(line);
    for (std::string word; stream >> word;) words_.push_back(word);
  }
  [[nodiscard]] const std::string& where() const { return where_; }
  [[nodiscard]] bool done() const { return next_ == words_.size(); }
  [[nodiscard]] bool take(std::string_view word) {
    if (done() || words_[next_] != word) return false;
    ++next_;
    return true;
  }
  std::string word(const char* wanted) {
    if (done()) refuse(where_, std::string(wanted) + " is wanted");
    return words_[next_++];
  }
  double number(const char* wanted) {
    const std::string text = word(wanted);
    double value = 0;
    if (!parse_number(text, value)) refuse(where_, "{} is wanted, not '{}'", wanted, text);
    return value;
  }
  std::int32_t count(const char* wanted, std::int32_t least, std::int32_t most) {
    const double value = number(wanted);
    if (value != std::floor(value) || value < least || value > most)
      refuse(where_, "{} from {} to {} is wanted, not {}", wanted, least, most, words_[next_ - 1]);
    return static_cast<std::int32_t>(value);
  }
  std::int32_t count_or_one(const char* wanted, std::int32_t most) {
    return done() ? 1 : count(wanted, 1, most);
  }
  std::int32_t vertex() { return count("a vertex", 0, INT32_MAX); }
  glm::vec2 pixel() {
    const double x = number("a pixel's x");
    return {x, number("a pixel's y")};
  }
  // What is left of the line: names may have spaces.
  std::string path() {
    std::string text = word("a file");
    while (!done()) text += " " + words_[next_++];
    return text;
  }
  void end() const {
    if (!done()) refuse(where_, "'" + words_[next_] + "' is too much");
  }

 private:
  std::string where_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

SavedPart saved_part(ScriptWords& words) {
  if (words.take("mesh")) return SavedPart::Mesh;
  if (words.take("cage")) return SavedPart::Cage;
  if (words.take("surface")) return SavedPart::Surface;
  refuse(words.where(), "mesh, cage or surface is wanted, then a file");
}

decltype(ScriptStep::what) step_of(ScriptWords& words) {
  if (words.take("pick")) {
    steps::Pick step{words.pixel()};
    step.adds = words.take("add");
    return step;
  }
  if (words.take("vertices")) {
    steps::Select step;
    do step.vertices.push_back(words.vertex());
    while (!words.done());
    return step;
  }
  if (words.take("radius")) return steps::Radius{words.number("a length")};
  if (words.take("move")) {
    steps::Move step;
    for (int k = 0; k < 3; ++k) step.way[k] = words.number("a way of three numbers");
    step.frames = words.count_or_one("a number of frames", kMostScriptFrames);
    return step;
  }
  if (words.take("drag")) {
    steps::Drag step{words.pixel(), {}};
    step.to = words.pixel();
    step.frames = words.count_or_one("a number of frames", kMostScriptFrames);
    return step;
  }
  if (words.take("crease")) {
    if (words.take("at")) return steps::CreaseAt{words.pixel()};
    const std::int32_t v0 = words.vertex();
    return steps::Crease{v0, words.vertex()};
  }
  if (words.take("corner")) return steps::Corner{words.vertex()};
  if (words.take("undo"))
    return steps::Undo{words.count_or_one("a number of steps", kMostScriptSteps)};
  if (words.take("redo"))
    return steps::Redo{words.count_or_one("a number of steps", kMostScriptSteps)};
  if (words.take("frames")) return steps::Frames{words.count("how many", 1, kMostScriptFrames)};
  if (words.take("picture")) return steps::Picture{words.path()};
  if (words.take("save")) {
    const SavedPart part = saved_part(words);
    return steps::Save{part, words.path()};
  }
  refuse(words.where(),
         "'" + words.word("a step") + "' is no step; planish-viewer --help lists them");
}

}  // namespace

std::vector<ScriptStep> parse_script(std::string_view text, const std::string& name) {
  std::vector<ScriptStep> result;
  std::istringstream stream{std::string(text)};
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    ScriptWords words(line, formatted("{}:{}", name, number));
    ScriptStep step{words.where(), step_of(words)};
    words.end();
    result.push_back(std::move(step));
  }
  if (result.empty()) refuse(name, "has no step; planish-viewer --help lists them");
  return result;
}

std::vector<ScriptStep> read_script(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file.is_open() || file.bad())
    throw Error(ErrorCode::UnreadableInput, path + ": cannot be read");
  return parse_script(text, path);
}

}  // namespace planish::viewer
