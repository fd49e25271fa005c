#include "help/command_page.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <sstream>

namespace planish::command {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

// A word in small letters; "N", "K,FACTOR" and "L[,L2,...]" are none.
bool is_word(const std::string& text) {
  return !text.empty() && std::ranges::none_of(text, [](unsigned char c) {
    return std::isupper(c) != 0 || c == ',' || c == '[' || c == ' ';
  });
}

// Of "a|b|c", "a,b,c", whose words may stand together, and "a"; "auto[:N]|INDEX" leaves "auto".
void take_choices(HelpOption& option) {
  const std::vector<std::string> several = split(option.value, ',');
  option.takes_several = several.size() > 1 && std::ranges::all_of(several, is_word);
  for (const std::string& part : option.takes_several ? several : split(option.value, '|')) {
    const std::string word = part.substr(0, part.find('['));
    if (is_word(word)) option.choices.push_back(word);
  }
}

HelpOption option_of(const CLI::Option& option, const CommandText& text) {
  HelpOption result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  if (option.get_items_expected_max() != 0) result.value = option.get_type_name();
  if (option.get_positional()) result.names = {result.value};
  take_choices(result);
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
  const CLI::App* parent = command.get_parent();
  page.program = parent == nullptr ? command.get_name() : parent->get_name();
  if (parent != nullptr) page.name = command.get_name();
  page.summary = command.get_description();
  if (const auto text = texts.find(page.name); text != texts.end()) page.text = text->second;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;  // hidden
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
