#include "options/option_flags.h"

#include <CLI/CLI.hpp>

namespace planish::command {

void add_option_flag(CLI::App& command, OptionTexts& texts, const OptionInfo& option,
                     const char* group) {
  const std::string_view name = option.name;
  if (option.kind == OptionKind::Switch) {
    command
        .add_flag_callback(
            flag_of(option), [&texts, name] { texts[name] = "true"; }, help_of(option))
        ->group(group);
    return;
  }
  command
      .add_option_function<std::string>(
          flag_of(option), [&texts, name](const std::string& text) { texts[name] = text; },
          help_of(option))
      ->type_name(choices_of(option))
      ->group(group);
}

}  // namespace planish::command
