#include "options/strict_json.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "planish/core/formatted.h"
#include "planish/core/json.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

// Refuses what the parser itself lets pass: deep nesting, which is copied and taken down
// recursively later, and keys that stand twice, of which the first would be ignored.
class StrictParse {
 public:
  explicit StrictParse(std::string name) : name_(std::move(name)) {}

  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    constexpr int kDeepest = 16;  // a scene needs 5
    if (depth > kDeepest) refuse(name_, "is nested too deeply to be a scene");
    if (event == Json::parse_event_t::object_start) keys_.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_.pop_back();
    if (event == Json::parse_event_t::key) {
      const std::string& key = parsed.get_ref<const std::string&>();
      if (!keys_.back().insert(key).second) {
        refuse(name_, "the key \"" + visible(key) + "\" stands twice in an object");
      }
    }
    return true;
  }

 private:
  std::string name_;
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
};

[[noreturn]] void refuse_at(std::size_t byte, std::string_view text, const std::string& name) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = std::ranges::count(before, '\n') + 1;
  refuse(formatted("{}:{}", name, line), "no valid JSON here");
}

}  // namespace

Json parse_json(std::string_view text, const std::string& name) {
  StrictParse strict(name);
  const auto check = [&](int depth, Json::parse_event_t event, Json& parsed) {
    return strict(depth, event, parsed);
  };
  // The parser takes a zero byte for the end, and looks at nothing behind it.
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)
    refuse_at(zero, text, name);
  try {
    return Json::parse(text, check);
  } catch (const Json::parse_error& error) {
    refuse_at(error.byte, text, name);
  } catch (const Json::exception& error) {
    refuse(name, std::string("no valid JSON: ") + error.what());
  }
}

}  // namespace planish::command
