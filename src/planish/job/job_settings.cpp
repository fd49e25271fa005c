#include "planish/job/job_settings.h"

#include <algorithm>
#include <array>

#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/option_words.h"
#include "planish/reconstruct/point_options.h"

namespace planish {

const OptionInfo* find_setting(std::string_view name) {
  if (const FitOption* const option = find_option(option_table(), name)) return option;
  return find_option(point_option_table(), name);
}

bool is_of_inputs(const OptionInfo& option) {
  constexpr std::array<std::string_view, 3> kOfAssets{"asset", "lods", "textures"};
  return option.stage == OptionStage::Points ||
         std::ranges::find(kOfAssets, option.name) != kOfAssets.end();
}

std::string flag_of_setting(std::string_view name) {
  const OptionInfo* const option = find_setting(name);
  return option == nullptr ? visible(name) : flag_of(*option);
}

void apply_settings(std::span<const NamedSetting> given, Settings& settings, SpellOption spell) {
  for (const auto& [name, text] : given)
    if (find_setting(name) == nullptr) refuse(spell(name), "there is no such option");
  const auto spell_row = [&](const OptionInfo& option) { return spell(option.name); };
  read_options<FitSettings>(option_table(), given, spell_row, settings);
  read_options(point_option_table(), given, spell_row, settings.points);
}

Settings settings_of(std::span<const NamedSetting> given, SpellOption spell) {
  Settings settings;
  apply_settings(given, settings, spell);
  check_consistent(settings, spell);
  return settings;
}

Settings settings_of(std::initializer_list<NamedSetting> given) {
  return settings_of(std::span(given.begin(), given.size()));
}

std::string_view name_of(Scheme scheme) { return word_of(kSchemeWords, scheme); }
std::string_view name_of(Weights weights) { return word_of(kWeightsWords, weights); }
std::string_view name_of(InterpolationMethod method) { return word_of(kMethodWords, method); }
std::string_view name_of(Solver solver) { return word_of(kSolverWords, solver); }
std::string_view name_of(BoundaryRule boundary) { return word_of(kBoundaryWords, boundary); }

std::string subdivision_text(Scheme scheme, Weights weights) {
  return scheme == Scheme::DooSabin ? std::string(name_of(weights)) + " weights"
                                    : std::string(name_of(scheme));
}

}  // namespace planish
