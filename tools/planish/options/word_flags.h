#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <string_view>

#include "options/point_settings.h"

namespace planish::command {

/// What flags of settings were given as, by name of the setting.
using SettingWords = std::map<std::string_view, std::string>;

/// Adds the flag of a WordSetting or PointSetting, whose help ends with the default.
template <class Setting>
void add_word_flag(CLI::App& command, SettingWords& words, const Setting& setting,
                   const char* group) {
  std::string help(setting.help);
  if (!setting.initial.empty()) help += " [" + std::string(setting.initial) + "]";
  command.add_option(flag_of(setting.name), words[setting.name], help)
      ->type_name(std::string(setting.choices))
      ->group(group);
}

/// Sets what was given, in the order of the settings. Throws as their set().
template <class Settings, class Target>
void apply_words(const SettingWords& words, const Settings& settings, Target& target) {
  for (const auto& setting : settings) {
    const auto given = words.find(setting.name);
    if (given != words.end() && !given->second.empty())
      setting.set(target, given->second, flag_of(setting.name));
  }
}

}  // namespace planish::command
