#include "planish/pipeline/choice.h"

#include <algorithm>
#include <cmath>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/pipeline/option_words.h"

namespace planish {

namespace {

// How a surface is better than another, which `name` names.
std::string advantage(const Candidate& taken, const Candidate& other, const std::string& name) {
  if (!other.converged && taken.converged) return name + " misses the tolerance";
  if (other.folds() && other.folded_area > taken.folded_area) {
    const std::string folds =
        formatted("{} folds {} of the area", name, percent(other.folded_area));
    return taken.folds() ? formatted("{}, this {}", folds, percent(taken.folded_area)) : folds;
  }
  if (taken.bending <= kChoiceWeights.flat) return "all is flat";
  if (std::abs(other.cost() - taken.cost()) < kChoiceWeights.alike) return name + " bends as much";
  if (other.bending > taken.bending)
    return formatted("it bends {} less than {}", percent(1 - taken.bending / other.bending), name);
  return name + " bends hardly less";
}

// The best of those for which that holds; null: there is none.
template <class Holds>
const Candidate* best_where(const Choice& choice, const Holds& holds) {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : choice.candidates)
    if (holds(candidate) && (best == nullptr || candidate.cost() < best->cost())) best = &candidate;
  return best;
}

std::string faces_name(CandidateFaces faces) {
  switch (faces) {
    case CandidateFaces::Quads:
      return "that of quads";
    case CandidateFaces::Refined:
      return "that with added vertices";
    case CandidateFaces::Mixed:
      return "that of each part's own faces";
    case CandidateFaces::Given:
      break;
  }
  return "that of the triangles";
}

}  // namespace

double PartFigures::cost() const {
  const ChoiceWeights& weights = kChoiceWeights;
  double cost = std::log(bending + weights.flat);
  if (folded_area >= kSoundFoldedArea) cost += weights.folds * folded_area;
  cost += weights.doubt * doubt;
  if (is_by_lot) cost += weights.by_lot;
  return cost;
}

bool Candidate::folds() const { return folded_area >= kSoundFoldedArea; }

double Candidate::cost() const {
  double cost = converged ? 0 : kChoiceWeights.missed;
  for (const PartFigures& part : parts) cost += part.cost();
  return cost;
}

const Candidate* Choice::of(CandidateFaces faces, InterpolationMethod method) const {
  const auto found = std::ranges::find_if(candidates, [&](const Candidate& candidate) {
    return candidate.faces == faces && candidate.method == method;
  });
  return found == candidates.end() ? nullptr : &*found;
}

bool enter(Choice& choice, const Candidate& candidate) {
  const bool is_first = choice.candidates.empty();
  const bool is_better = is_first || candidate.cost() < choice.best().cost() - kChoiceWeights.alike;
  choice.candidates.push_back(candidate);
  if (is_better) choice.taken = choice.candidates.size() - 1;
  return is_better;
}

std::vector<CandidateFaces> best_faces(const Choice& choice) {
  std::vector<CandidateFaces> faces;
  for (std::size_t p = 0; p < choice.best().parts.size(); ++p) {
    const PartFigures* best = nullptr;
    for (const Candidate& candidate : choice.candidates) {
      const PartFigures& part = candidate.parts[p];
      if (candidate.converged &&
          (best == nullptr || part.cost() < best->cost() - kChoiceWeights.alike))
        best = &part;
    }
    faces.push_back(best == nullptr ? CandidateFaces::Given : best->faces);
  }
  return faces;
}

void explain(Choice& choice, std::int64_t added_vertices) {
  const Candidate& taken = choice.best();
  const std::string method(word_of(kMethodWords, taken.method));
  if (choice.reason.empty()) {
    // Vertices are added to the fair surface of the given faces.
    const bool is_derived =
        taken.faces == CandidateFaces::Refined || taken.faces == CandidateFaces::Mixed;
    const CandidateFaces faces = is_derived ? CandidateFaces::Given : taken.faces;
    const Candidate* const other = best_where(choice, [&](const Candidate& candidate) {
      return candidate.faces == faces && candidate.method != taken.method;
    });
    choice.reason = taken.alone.empty() ? method : method + ": " + taken.alone;
    if (other != nullptr && taken.alone.empty())
      choice.reason +=
          ": " + advantage(taken, *other, std::string(word_of(kMethodWords, other->method)));
  }
  if (!choice.faces_reason.empty()) return;
  const Candidate* const other = best_where(
      choice, [&](const Candidate& candidate) { return candidate.faces != taken.faces; });
  if (other == nullptr) return;
  const std::string why = advantage(taken, *other, faces_name(other->faces));
  switch (taken.faces) {
    case CandidateFaces::Given:
      choice.faces_reason = "triangles as they are: " + why;
      return;
    case CandidateFaces::Quads:
      choice.faces_reason =
          formatted("triangles joined to quads: {} (--quads off leaves them)", why);
      return;
    case CandidateFaces::Refined:
      choice.faces_reason =
          formatted("{} added between those of uneven triangles: {} (--refine off adds none)",
                    counted(added_vertices, "vertex"), why);
      return;
    case CandidateFaces::Mixed:
      choice.faces_reason = formatted(
          "each part with the faces that suit it: {} (--quads off "
          "--refine off leave them all)",
          why);
      return;
  }
}

}  // namespace planish
