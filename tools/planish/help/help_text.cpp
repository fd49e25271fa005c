#include "help/help_text.h"
#include "planish/core/formatted.h"

#include <algorithm>
#include <sstream>

namespace planish::command {
namespace {

constexpr int kNarrowest = 40, kWidest = 100;
constexpr int kFlagColumn = 24;     // where the texts of flags begin
constexpr int kCommandColumn = 16;  // and those of commands

int sensible(int columns) { return std::clamp(columns, kNarrowest, kWidest); }

// "  -o, --output FILE       text", the text in a column of its own.
std::string entry(const std::string& head, const std::string& text, int column, int columns) {
  std::string line = "  " + head;
  const std::string indent(static_cast<std::size_t>(column), ' ');
  if (static_cast<int>(line.size()) + 2 > column) {
    line += "\n" + indent;
  } else {
    line.resize(static_cast<std::size_t>(column), ' ');
  }
  return line + wrapped(text, columns - column, column) + "\n";
}

std::string head_of(const HelpOption& option) {
  std::string head;
  for (const std::string& name : option.names) head += (head.empty() ? "" : ", ") + name;
  if (head.starts_with("--")) head = "    " + head;
  if (!option.value.empty() && option.names.front().starts_with('-')) head += " " + option.value;
  return head;
}

std::string entry_of(const HelpOption& option, int columns) {
  return entry(head_of(option), option.text, kFlagColumn, columns);
}

std::string arguments_text(const HelpPage& page, int columns) {
  std::string text;
  for (const HelpOption& argument : page.arguments)
    text += entry(argument.value, argument.text, kFlagColumn, columns);
  return text.empty() ? text : "\n" + text;
}

std::string examples_text(const HelpPage& page, std::size_t most) {
  if (page.text.examples.empty()) return {};
  std::string text = "\nExamples:\n";
  for (std::size_t i = 0; i < std::min(most, page.text.examples.size()); ++i)
    text += "  " + page.text.examples[i] + "\n";
  return text;
}

std::string head_text(const HelpPage& page, int columns) {
  return formatted("{}\n\nUsage: {}\n", wrapped(page.summary, columns, 0), page.usage());
}

std::string commands_text(const HelpPage& page, int columns) {
  std::string text = "\nCommands:\n";
  for (const HelpPage& command : page.commands)
    text += entry(command.name, command.summary, kCommandColumn, columns);
  return text;
}

}  // namespace

std::string wrapped(const std::string& text, int columns, int indent) {
  const auto width = static_cast<std::size_t>(std::max(columns, 16));
  std::istringstream words(text);
  std::string result, word;
  std::size_t used = 0;
  while (words >> word) {
    if (used > 0 && used + 1 + word.size() > width) {
      result += "\n" + std::string(static_cast<std::size_t>(indent), ' ');
      used = 0;
    }
    if (used > 0) {
      result += ' ';
      ++used;
    }
    result += word;
    used += word.size();
  }
  return result;
}

std::string short_help(const HelpPage& page, int columns) {
  columns = sensible(columns);
  std::string text = head_text(page, columns);
  if (!page.commands.empty()) text += commands_text(page, columns);
  text += arguments_text(page, columns);
  std::string flags;
  std::size_t left_out = 0;
  for (const HelpTopic& topic : page.topics) {
    for (const HelpOption& option : topic.options) {
      if (option.is_first) {
        flags += entry_of(option, columns);
      } else {
        ++left_out;
      }
    }
  }
  if (!flags.empty()) text += "\n" + flags;
  text += examples_text(page, 3);
  if (left_out > 0)
    text += formatted("\n{} --help has {} more flags, by topic.\n", page.full_name(), left_out);
  if (!page.commands.empty()) text += "\nplanish COMMAND -h says more of each.\n";
  return text;
}

std::string long_help(const HelpPage& page, int columns) {
  columns = sensible(columns);
  std::string text = head_text(page, columns);
  if (!page.commands.empty()) text += commands_text(page, columns);
  text += arguments_text(page, columns);
  for (const HelpTopic& topic : page.topics) {
    text += "\n" + topic.title + ":\n";
    for (const HelpOption& option : topic.options) text += entry_of(option, columns);
  }
  text += examples_text(page, page.text.examples.size());
  std::istringstream paragraphs(page.text.notes);
  for (std::string line; std::getline(paragraphs, line);)
    text += "\n" + wrapped(line, columns, 0) + "\n";
  return text;
}

std::string overview(const HelpPage& page, int columns) {
  columns = sensible(columns);
  std::string text = wrapped(page.summary, columns, 0) + "\n" + commands_text(page, columns);
  if (!page.text.examples.empty()) text += "\nTo begin with:  " + page.text.examples.front() + "\n";
  return text + "planish -h says more.\n";
}

}  // namespace planish::command
