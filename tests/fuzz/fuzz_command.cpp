#include "fuzz/fuzz_command.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/fuzz_read.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "scene_file.h"

namespace planish::test {

namespace {

// What a browser makes of it; references are of one decimal number.
std::string without_references(std::string_view html) {
  std::string text;
  while (!html.empty()) {
    const bool is_reference = html.starts_with("&#");
    const std::size_t end = is_reference ? html.find(';') : 0;
    require(end != std::string_view::npos && html.front() != '<' && html.front() != '>' &&
            html.front() != '"' && html.front() != '\'' && html.front() != '`' &&
            (is_reference || html.front() != '&'));
    text += is_reference ? static_cast<char>(std::stoi(std::string(html.substr(2, end - 2))))
                         : html.front();
    html.remove_prefix(end + 1);
  }
  return text;
}

// What a shell makes of it.
std::string without_quotes(std::string_view word) {
  std::string text;
  bool is_quoted = false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (word[i] == '\'') {
      is_quoted = !is_quoted;
    } else if (word[i] == '\\' && !is_quoted) {
      require(++i < word.size());
      text += word[i];
    } else {
      require(is_quoted || std::string_view(" \t\n;&|<>()$`\"*?[]#~!{}\\").find(word[i]) ==
                               std::string_view::npos);
      text += word[i];
    }
  }
  require(!is_quoted);
  return text;
}

}  // namespace

void fuzz_read_scene(std::span<const std::byte> bytes, FileFormat) {
  try {
    for (const Job& job : command::parse_scene(text_of(bytes), "fuzz.json", "/folder"))
      require(!job.name.empty() && !job.input.empty());
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::InvalidArgument});
  }
}

void fuzz_read_cage(std::span<const std::byte> bytes, FileFormat format) {
  try {
    const MeshFile file = read_mesh(bytes, "fuzz", format);
    const CageHeader header = parse_cage_header(file.header, "fuzz");
    const auto written = [](const CageHeader& of) {
      const bool is_fair = of.settings.interpolation == InterpolationChoice::Fair;
      return cage_header_lines(
          of.settings, is_fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive,
          of.source, of.found.value_or(FoundCreases()));
    };
    const std::vector<std::string> lines = written(header);
    for (const std::string& line : lines) require(line.find('\n') == std::string::npos);
    require(written(parse_cage_header(lines, "fuzz")) == lines);
  } catch (const Error& error) {
    require_refusal(error, {ErrorCode::UnreadableInput});
  }
}

void fuzz_write_text(std::span<const std::byte> bytes, FileFormat) {
  const std::string_view text = text_of(bytes);
  const std::string message = visible(text), shown = visible_text(text);
  require(visible(message) == message);
  require(visible_text(shown) == shown);
  require(without_references(html_text(text)) == shown);
  std::string lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (begin > 0) lines += '\n';
    lines += visible_text(text.substr(begin, end - begin));
    begin = end + 1;
  }
  require(without_references(html_lines(text)) == lines);
  require(without_quotes(shell_word(text)) == text);
  const nlohmann::ordered_json given = {{std::string(text), {std::string(text), 1, nullptr}}};
  const nlohmann::ordered_json seen = visible_json(given);
  for (const nlohmann::ordered_json* value : {&given, &seen}) {
    const std::string script = script_json(*value);
    for (const char c : script) require(c >= ' ' && c <= '~' && c != '<' && c != '>' && c != '&');
    const nlohmann::ordered_json parsed = nlohmann::ordered_json::parse(script);
    if (value == &seen) require(parsed == seen);
  }
}

}  // namespace planish::test
