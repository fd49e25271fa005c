#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/brep/write_step.h"
#include "planish/core/option.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/choice.h"
#include "planish/pipeline/settings.h"
#include "planish/pipeline/write_fitted_step.h"
#include "planish/primal/scheme.h"
#include "planish/quads/pair_triangles.h"
#include "planish/refine/refine_mesh.h"
#include "planish/solve/progressive.h"

namespace planish {

/// A value with its stable name, as flags, reports, files and bindings have it.
template <class Value>
struct OptionWord {
  std::string_view text;
  Value value;
};

inline constexpr std::array kSchemeWords{OptionWord<Scheme>{"doo-sabin", Scheme::DooSabin},
                                         OptionWord<Scheme>{"catmull-clark", Scheme::CatmullClark},
                                         OptionWord<Scheme>{"loop", Scheme::Loop}};
inline constexpr std::array kWeightsWords{OptionWord<Weights>{"doo-sabin", Weights::DooSabin},
                                          OptionWord<Weights>{"averaged", Weights::Averaged}};
inline constexpr std::array kMethodWords{
    OptionWord<InterpolationMethod>{"progressive", InterpolationMethod::Progressive},
    OptionWord<InterpolationMethod>{"fair", InterpolationMethod::Fair}};
inline constexpr std::array kFacesWords{
    OptionWord<CandidateFaces>{"given", CandidateFaces::Given},
    OptionWord<CandidateFaces>{"quads", CandidateFaces::Quads},
    OptionWord<CandidateFaces>{"refined", CandidateFaces::Refined},
    OptionWord<CandidateFaces>{"mixed", CandidateFaces::Mixed}};
inline constexpr std::array kSolverWords{OptionWord<Solver>{"chebyshev", Solver::Chebyshev},
                                         OptionWord<Solver>{"plain", Solver::Plain},
                                         OptionWord<Solver>{"cg", Solver::ConjugateGradients}};
inline constexpr std::array kBoundaryWords{
    OptionWord<BoundaryRule>{"edge", BoundaryRule::Edge},
    OptionWord<BoundaryRule>{"edge-and-corner", BoundaryRule::EdgeAndCorner}};
inline constexpr std::array kRefineWords{OptionWord<RefineChoice>{"auto", RefineChoice::Auto},
                                         OptionWord<RefineChoice>{"on", RefineChoice::On},
                                         OptionWord<RefineChoice>{"off", RefineChoice::Off}};
inline constexpr std::array kQuadWords{OptionWord<QuadChoice>{"auto", QuadChoice::Auto},
                                       OptionWord<QuadChoice>{"on", QuadChoice::On},
                                       OptionWord<QuadChoice>{"off", QuadChoice::Off}};

inline constexpr std::array kAnalyticWords{OptionWord<AnalyticChoice>{"auto", AnalyticChoice::Auto},
                                           OptionWord<AnalyticChoice>{"off", AnalyticChoice::Off}};

inline constexpr std::array kStepUnitWords{
    OptionWord<StepUnit>{"mm", StepUnit::Millimetre},
    OptionWord<StepUnit>{"cm", StepUnit::Centimetre}, OptionWord<StepUnit>{"m", StepUnit::Metre},
    OptionWord<StepUnit>{"in", StepUnit::Inch}, OptionWord<StepUnit>{"auto", StepUnit::OfInput}};

/// The name of a value of the table.
template <class Words, class Value>
[[nodiscard]] std::string_view word_of(const Words& words, Value value) {
  return std::ranges::find(words, value, &Words::value_type::value)->text;
}

/// The value of that name; empty where there is none.
template <class Words>
[[nodiscard]] auto value_of(const Words& words, std::string_view text)
    -> std::optional<decltype(words.front().value)> {
  const auto found = std::ranges::find(words, text, &Words::value_type::text);
  if (found == words.end()) return std::nullopt;
  return found->value;
}

/// "doo-sabin, averaged": what may be given.
template <class Words>
[[nodiscard]] std::string texts_of(const Words& words) {
  std::string all;
  for (const auto& word : words) all += (all.empty() ? "" : ", ") + std::string(word.text);
  return all;
}

using FitOption = Option<FitSettings>;

/// Everything that can be set for a mesh, one row each, in the order in which it has to be set: a
/// preset first, so that others override it. A new option is a member of FitSettings, a row here
/// and what it does.
[[nodiscard]] const std::vector<FitOption>& option_table();

/// The row of that name, which has to exist.
[[nodiscard]] const FitOption& fit_option(std::string_view name);

/// What an option of that name is set to, as it may be given.
[[nodiscard]] std::string option_text(const FitSettings& settings, std::string_view name);

}  // namespace planish
