#include "help/command_page.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <sstream>

namespace planish::command {
namespace {

// "a|b|c" is a choice where every part is a word in small letters; "auto|INDEX" leaves "auto".
std::vector<std::string> choices_of(const std::string& value) {
  std::vector<std::string> choices;
  if (value.find('|') == std::string::npos) return choices;
  std::istringstream parts(value);
  for (std::string word; std::getline(parts, word, '|');) {
    if (const std::size_t optional = word.find('['); optional != std::string::npos)
      word.resize(optional);
    const bool is_word = !word.empty() && std::ranges::none_of(word, [](unsigned char c) {
      return std::isupper(c) != 0 || c == ',';
    });
    if (is_word) choices.push_back(word);
  }
  return choices;
}

HelpOption option_of(const CLI::Option& option, const CommandText& text) {
  HelpOption result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  if (option.get_items_expected_max() != 0) result.value = option.get_type_name();
  if (option.get_positional()) result.names = {result.value};
  result.choices = choices_of(result.value);
  result.text = option.get_description();
  const auto is_first = [&](const std::string& name) {
    return std::ranges::find(text.first_flags, name) != text.first_flags.end();
  };
  result.is_first = text.first_flags.empty() || std::ranges::any_of(result.names, is_first);
  result.takes_file = result.value == "FILE" || result.value == "DIR" || option.get_positional();
  return result;
}

HelpPage page_of(const CLI::App& command, const CommandTexts& texts) {
  HelpPage page;
  page.name = command.get_parent() == nullptr ? "" : command.get_name();
  page.summary = command.get_description();
  if (const auto text = texts.find(page.name); text != texts.end()) page.text = text->second;
  for (const CLI::Option* option : command.get_options()) {
    const HelpOption described = option_of(*option, page.text);
    if (option->get_positional()) {
      page.arguments.push_back(described);
      continue;
    }
    auto topic = std::ranges::find(page.topics, option->get_group(), &HelpTopic::title);
    if (topic == page.topics.end()) {
      page.topics.push_back({option->get_group(), {}});
      topic = page.topics.end() - 1;
    }
    topic->options.push_back(described);
  }
  return page;
}

}  // namespace

std::string HelpPage::usage() const {
  std::string line = full_name();
  if (!commands.empty()) return line + " COMMAND [FLAGS] ...";
  if (!topics.empty()) line += " [FLAGS]";
  for (const HelpOption& argument : arguments) line += " " + argument.value;
  return line;
}

HelpPage help_page(const CLI::App& app, const CommandTexts& texts) {
  HelpPage page = page_of(app, texts);
  for (const CLI::App* command : app.get_subcommands({})) {
    if (!command->get_description().empty()) page.commands.push_back(page_of(*command, texts));
  }
  return page;
}

}  // namespace planish::command
