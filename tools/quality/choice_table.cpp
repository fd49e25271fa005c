#include "quality/choice_table.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "planish/backend/cpu_backend.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/option_words.h"
#include "quality/tally.h"

namespace planish::quality {

namespace {

// Of a surface of those faces and that method.
double normals_off(const Case& made, const Candidate& candidate, Backend& backend) {
  MeshFitOptions options;
  options.method = candidate.method;
  options.finds_features = true;
  options.quads = candidate.faces == CandidateFaces::Quads ? QuadChoice::On : QuadChoice::Off;
  options.refine =
      candidate.faces == CandidateFaces::Refined ? RefineChoice::On : RefineChoice::Off;
  return measure(made, fit_mesh(made.mesh, made.name, backend, options), backend).rms_normal;
}

}  // namespace

std::vector<std::string> print_choice_table(const std::vector<NamedCase>& cases) {
  std::printf(
      "| mesh (vertices) | surfaces: folded, bending, cost; normals off the shape | taken |\n"
      "|---|---|---|\n");
  const auto backend = make_cpu_backend({Precision::Double});
  std::vector<std::string> wrong;
  Tally tally;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    if (!made.truth && !made.has_smooth_source) continue;
    const FittedMesh fitted = fit_mesh(made.mesh, made.name, *backend, {});
    const Choice& choice = *fitted.choice;
    std::printf("| %s%s (%d) |", named.name.c_str(), made.is_held_out ? "*" : "",
                made.mesh.vertex_count());
    double taken = 0, better = std::numeric_limits<double>::infinity();
    std::string name;
    for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
      const Candidate& candidate = choice.candidates[i];
      const std::string what = std::string(word_of(kFacesWords, candidate.faces)) + " " +
                               std::string(word_of(kMethodWords, candidate.method));
      const double off = normals_off(made, candidate, *backend);
      std::printf("%s %s: ", i > 0 ? "<br>" : "", what.c_str());
      if (candidate.is_measured())
        std::printf("%.1e, %.4g, %.2f; ", candidate.folded_area, candidate.bending,
                    candidate.cost());
      std::printf("%.2f", off);
      better = std::min(better, off);
      if (i == choice.taken) taken = off, name = what;
    }
    std::printf(" | %s |\n", name.c_str());
    std::fflush(stdout);
    tally.add(taken, better);
    if (is_farther_off(taken, better)) {
      char text[200];
      std::snprintf(text, sizeof text, "%s: normals off by %.2f degrees, another's by %.2f",
                    named.name.c_str(), taken, better);
      wrong.emplace_back(text);
    }
  }
  std::printf(
      "\nthe best one, or one as good, of %d of %d; elsewhere farther off by a factor of %.2f at "
      "most\n",
      tally.right, tally.count, tally.excess);
  return wrong;
}

}  // namespace planish::quality
