#include "mpi_options.h"

#include <algorithm>
#include <array>

#include "options/point_settings.h"
#include "options/refuse.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

// With blanks around each.
constexpr std::string_view kTaken =
    " input output cage report levels tile_vertices skirts tolerance max_iterations polish "
    "input_format force quiet verbose log_level color progress preset weights interpolation "
    "boundary up crease_edges corner_vertices help scene job block_vertices resume watchdog "
    "partition ";

struct Rule {
  std::string_view name;
  std::string_view words;  // that are taken, with blanks around each; empty: none
  std::string_view remedy;
};

constexpr std::string_view kNoPage = "planish on one machine writes pages; leave it out";
constexpr std::string_view kNoFineness = "tiles have levels; take levels";

constexpr std::array kRules{
    Rule{"solver", " chebyshev plain ", "take chebyshev or plain"},
    Rule{"precision", " auto double ", "ranks solve in double precision; take double"},
    Rule{"creases", " use ignore ",
         "edges are not looked for over ranks; tag them in the file, and take use"},
    Rule{"repair", " none ",
         "nothing is mended over ranks; planish fit IN --max-iterations 0 --cage MENDED.obj writes "
         "the mended mesh"},
    Rule{"scheme", " doo-sabin ", "take doo-sabin"},
    Rule{"device", " auto cpu ", "ranks work on the CPU; take cpu"},
    Rule{"compress", " none ", "tiles of ranks are not compressed; take none"},
    Rule{"attributes", "", "tiles of ranks carry no figures of vertices; leave it out"},
    Rule{"weld", "",
         "nothing is welded over ranks; planish fit IN --weld T --max-iterations 0 --cage "
         "WELDED.obj "
         "writes the welded mesh"},
    Rule{"chord_error", "", kNoFineness},
    Rule{"chord_errors", "", kNoFineness},
    Rule{"angle", "", kNoFineness},
    Rule{"source", "", "the report compares with the input only; leave it out"},
    Rule{"sample", "", "ranks take meshes; make one of points by planish reconstruct first"},
    Rule{"jobs", "", "one input at a time; mpirun -n says how many ranks work on it"},
    Rule{"output_format", "", "surfaces are 3D Tiles, cages PLY; leave it out"},
    Rule{"dry_run", "", "ranks make no forecast; take planish on one machine for it"},
    Rule{"json", "", "each job of a scene names its own report; leave it out"},
    Rule{"report_of_jobs", "", "each job of a scene names its own report; leave it out"},
    Rule{"page", "", kNoPage},
    Rule{"page_limit", "", kNoPage},
    Rule{"page_no_times", "", kNoPage},
};

constexpr std::string_view kOfPoints =
    "it belongs to points; make a mesh of them by planish reconstruct first";

bool has_word(std::string_view words, std::string_view word) {
  return words.find(" " + std::string(word) + " ") != std::string_view::npos;
}

const Rule* rule_of(std::string_view name) {
  const auto rule = std::ranges::find(kRules, name, &Rule::name);
  return rule == kRules.end() ? nullptr : &*rule;
}

bool is_of_points(std::string_view name) {
  return std::ranges::find(point_settings(), name, &PointSetting::name) != point_settings().end();
}

[[noreturn]] void refuse_option(const GivenSetting& option, std::string_view remedy) {
  // A switch says nothing but its name.
  const bool is_switch = option.value.empty() || option.value == "true";
  refuse(option.where, (is_switch ? "" : visible(option.value) + " ") +
                           "is not available in planish-mpi: " + std::string(remedy));
}

}  // namespace

MpiOption mpi_option(std::string_view name) {
  if (has_word(kTaken, name)) return MpiOption::Taken;
  const Rule* rule = rule_of(name);
  return rule != nullptr && !rule->words.empty() ? MpiOption::SomeWords : MpiOption::Refused;
}

std::string words_taken(std::string_view name) {
  const Rule* rule = rule_of(name);
  if (rule == nullptr || rule->words.empty()) return {};
  std::string words(rule->words.substr(1, rule->words.size() - 2));
  std::ranges::replace(words, ' ', '|');
  return words;
}

void require_available(std::span<const GivenSetting> given, const Settings& settings) {
  for (std::size_t i = 0; i < given.size(); ++i) {
    const GivenSetting& option = given[i];
    const auto later = given.subspan(i + 1);
    if (has_word(kTaken, option.name)) continue;
    if (std::ranges::find(later, option.name, &GivenSetting::name) != later.end()) continue;
    const Rule* rule = rule_of(option.name);
    if (rule != nullptr && rule->remedy == kNoFineness && !settings.adaptive.any()) continue;
    if (rule != nullptr && has_word(rule->words, option.value)) continue;
    if (rule != nullptr) refuse_option(option, rule->remedy);
    refuse_option(option, is_of_points(option.name) ? kOfPoints : "take planish on one machine");
  }
}

}  // namespace planish::command
