#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/option.h"

namespace CLI {
class App;
}

namespace planish::command {

/// What flags of options were given as, by name of the option.
using OptionTexts = std::map<std::string_view, std::string>;

/// Adds the flag of an option, whose help ends with the default. `texts` has to outlive the
/// command.
void add_option_flag(CLI::App& command, OptionTexts& texts, const OptionInfo& option,
                     const char* group);

/// Sets what was given, in the order of the table. Throws as read_option().
template <class Target>
void apply_flags(const OptionTexts& texts, const std::vector<Option<Target>>& table,
                 Target& target) {
  read_options(table, texts, flag_of, target);
}

}  // namespace planish::command
