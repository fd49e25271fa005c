#include "planish/job/job_settings.h"

#include "planish/core/refuse.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/option_words.h"
#include "planish/reconstruct/point_options.h"

namespace planish {

namespace {

template <class Target>
void apply_rows(const std::vector<Option<Target>>& table, std::span<const NamedSetting> given,
                SpellOption spell, Target& target) {
  for (const Option<Target>& option : table)
    for (const auto& [name, text] : given)
      if (name == option.name) read_option(option, target, text, spell(name));
}

}  // namespace

const OptionInfo* find_setting(std::string_view name) {
  for (const FitOption& option : option_table())
    if (option.name == name) return &option;
  for (const PointOption& option : point_option_table())
    if (option.name == name) return &option;
  return nullptr;
}

void apply_settings(std::span<const NamedSetting> given, Settings& settings, SpellOption spell) {
  for (const auto& [name, text] : given)
    if (find_setting(name) == nullptr) refuse(spell(name), "there is no such option");
  apply_rows<FitSettings>(option_table(), given, spell, settings);
  apply_rows(point_option_table(), given, spell, settings.points);
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
