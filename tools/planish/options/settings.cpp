#include "options/settings.h"

#include "planish/pipeline/option_words.h"

namespace planish::command {

std::string_view name_of(Scheme scheme) { return word_of(kSchemeWords, scheme); }
std::string_view name_of(Weights weights) { return word_of(kWeightsWords, weights); }
std::string_view name_of(InterpolationMethod method) { return word_of(kMethodWords, method); }
std::string_view name_of(Solver solver) { return word_of(kSolverWords, solver); }
std::string_view name_of(BoundaryRule boundary) { return word_of(kBoundaryWords, boundary); }

std::string subdivision_text(Scheme scheme, Weights weights) {
  return scheme == Scheme::DooSabin ? std::string(name_of(weights)) + " weights"
                                    : std::string(name_of(scheme));
}

}  // namespace planish::command
