#include "options/arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "options/input_list.h"
#include "planish/core/nearest.h"
#include "planish/core/visible_text.h"
#include "planish/job/input_path.h"

namespace planish::command {
namespace {

namespace fs = std::filesystem;

Error usage_error(const std::string& message) { return Error(ErrorCode::InvalidArgument, message); }

std::string line_for(const std::string& input) {
  const fs::path path(input);
  if (path.extension() == ".json") return "planish run " + visible(input);
  return "planish fit " + visible(input) + " -o " + output_beside(input);
}

bool looks_like_a_file(const std::string& argument) {
  std::error_code ignored;
  const fs::path path(argument);
  return format_of(path) || path.extension() == ".json" || fs::is_regular_file(path, ignored) ||
         !conversion_to_readable(path).empty();
}

void check_flag_names(const CLI::App& command, const std::vector<std::string>& arguments) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  const std::vector<std::string_view> known(names.begin(), names.end());
  for (const std::string& argument : arguments) {
    if (argument == "--") return;
    if (!argument.starts_with("--")) continue;
    const std::string name = argument.substr(0, argument.find('='));
    if (std::ranges::find(known, name) == known.end()) {
      throw usage_error(visible(name) + " is no flag of planish " + command.get_name() +
                        did_you_mean(name, known));
    }
  }
}

// No file and no value is named so. What is left out would be missed late, if at all.
void refuse_empty(const std::vector<std::string>& arguments) {
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    if (!arguments[i].empty()) continue;
    const std::string& before = arguments[i - 1];
    throw usage_error((before.starts_with('-') && i > 1 ? visible(before) + ": what follows"
                                                        : std::string("an argument")) +
                      " is empty; is a variable not set?");
  }
}

}  // namespace

std::vector<std::string> with_reflexes_understood(std::vector<std::string> arguments) {
  if (arguments.size() < 2) return arguments;
  const std::string& first = arguments[1];
  if (first == "version" || first == "-V") arguments[1] = "--version";
  if (first != "help") return arguments;
  const bool about_a_command = arguments.size() > 2 && !arguments[2].starts_with('-');
  if (!about_a_command) return {arguments[0], "--help"};
  return {arguments[0], arguments[2], "--help"};
}

void check_names(const CLI::App& app, const std::vector<std::string>& arguments) {
  refuse_empty(arguments);
  const auto first =
      std::find_if(arguments.begin() + 1, arguments.end(),
                   [](const std::string& argument) { return !argument.starts_with('-'); });
  if (first == arguments.end()) return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) {
    if (command->get_name() == *first) {
      check_flag_names(*command, {first + 1, arguments.end()});
      return;
    }
    if (!command->get_description().empty()) names.push_back(command->get_name());
  }
  if (looks_like_a_file(*first))
    throw usage_error("\"" + visible(*first) +
                      "\" is a file and no command; did you mean: " + line_for(*first));
  const std::vector<std::string_view> known(names.begin(), names.end());
  throw usage_error("\"" + visible(*first) + "\" is no command" + did_you_mean(*first, known) +
                    " (planish -h lists them)");
}

Error parse_fault(const CLI::App& app, const HelpPage& page, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const auto extras = chosen.empty() ? app.remaining() : chosen.front()->remaining();
    message = extras.empty() ? message
              : extras.front().starts_with('-')
                  ? visible(extras.front()) + " is no flag of " + page.full_name()
                  : page.full_name() + " takes no further argument: " + visible(extras.front());
  } else if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    message =
        page.name.empty() ? "a command is missing" : page.full_name() + ": an argument is missing";
    message += "\n  Usage: " + page.usage();
    if (!page.text.examples.empty()) message += "\n  as in: " + page.text.examples.front();
  }
  return usage_error(message + "\n  " + page.full_name() + " --help shows what is possible");
}

}  // namespace planish::command
