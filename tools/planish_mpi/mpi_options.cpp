#include "mpi_options.h"

#include <algorithm>
#include <iterator>

#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish::command {
namespace {

// What is in no table of options: files, messages, and what ranks have besides.
constexpr std::string_view kTaken[] = {
    "input", "output",  "cage",           "report", "input_format", "force",
    "quiet", "verbose", "log_level",      "color",  "progress",     "help",
    "scene", "job",     "block_vertices", "resume", "watchdog",     "partition"};

struct Refused {
  std::string_view name, remedy;
};

constexpr std::string_view kNoPage = "planish on one machine writes pages; leave it out";

constexpr std::string_view kNoBudget =
    "each rank holds its part of the mesh; more ranks on more machines hold more";

constexpr Refused kRefused[] = {
    {"source", "the report compares with the input only; leave it out"},
    {"sample", "ranks take meshes; make one of points by planish reconstruct first"},
    {"moves", "ranks do not edit; take planish on one machine"},
    {"jobs", "one input at a time; mpirun -n says how many ranks work on it"},
    {"output_format", "surfaces are 3D Tiles, cages PLY; leave it out"},
    {"dry_run", "ranks make no forecast; take planish on one machine for it"},
    {"json", "each job of a scene names its own report; leave it out"},
    {"report_of_jobs", "each job of a scene names its own report; leave it out"},
    {"memory", kNoBudget},
    {"temporary", kNoBudget},
    {"page", kNoPage},
    {"page_limit", kNoPage},
    {"page_no_times", kNoPage},
};

// Flags are named by their long name: "chord_error" of the option chord_errors.
const OptionInfo* option_of(std::string_view name) {
  const auto is_it = [&](const OptionInfo& option) {
    std::string flag = flag_of(option).substr(2);
    std::ranges::replace(flag, '-', '_');
    return option.name == name || flag == name;
  };
  const auto fit = std::ranges::find_if(option_table(), is_it);
  if (fit != option_table().end()) return &*fit;
  const auto point = std::ranges::find_if(point_option_table(), is_it);
  return point == point_option_table().end() ? nullptr : &*point;
}

RankRule rule_of(std::string_view name) {
  if (const OptionInfo* option = option_of(name)) return option->ranks;
  if (std::ranges::find(kTaken, name) != std::end(kTaken)) return {};
  const auto refused = std::ranges::find(kRefused, name, &Refused::name);
  if (refused != std::end(kRefused)) return {"", refused->remedy};
  return {"", "take planish on one machine"};
}

bool takes(const RankRule& rule, std::string_view value) {
  if (rule.words == "*") return true;
  if (rule.words.starts_with('!')) return rule.words.substr(1) != value;
  for (std::string_view rest = rule.words; !rest.empty();) {
    const std::size_t end = std::min(rest.find('|'), rest.size());
    if (rest.substr(0, end) == value) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

[[noreturn]] void refuse_option(const GivenSetting& option, std::string_view remedy) {
  // A switch says nothing but its name.
  const bool is_switch = option.value.empty() || option.value == "true";
  refuse(option.where, (is_switch ? "" : visible(option.value) + " ") +
                           "is not available in planish-mpi: " + std::string(remedy));
}

}  // namespace

MpiOption mpi_option(std::string_view name) {
  const RankRule rule = rule_of(name);
  if (rule.words == "*") return MpiOption::Taken;
  return rule.words.empty() ? MpiOption::Refused : MpiOption::SomeWords;
}

std::string words_taken(std::string_view name) {
  const RankRule rule = rule_of(name);
  const bool is_list = rule.words != "*" && !rule.words.starts_with('!');
  return std::string(is_list ? rule.words : "");
}

void require_available(std::span<const GivenSetting> given, const FitSettings& settings) {
  for (std::size_t i = 0; i < given.size(); ++i) {
    const GivenSetting& one = given[i];
    const auto later = given.subspan(i + 1);
    if (std::ranges::find(later, one.name, &GivenSetting::name) != later.end()) continue;
    const OptionInfo* option = option_of(one.name);
    const bool is_fineness = option != nullptr && option->stage == OptionStage::Fineness;
    if (is_fineness && !settings.adaptive.any()) continue;
    const RankRule rule = rule_of(one.name);
    if (!takes(rule, one.value)) refuse_option(one, rule.remedy);
  }
}

}  // namespace planish::command
