#include "quality/choice_table.h"

#include <algorithm>
#include <cstdio>

#include "planish/backend/cpu_backend.h"
#include "planish/pipeline/fit_best.h"
#include "quality/tally.h"

namespace planish::quality {

namespace {

void print_quality(const SurfaceQuality& quality) {
  std::printf(" %.1e, %.2f |", quality.folded_area_elsewhere, quality.rms_normal_deviation);
}

}  // namespace

std::vector<std::string> print_choice_table(const std::vector<NamedCase>& cases) {
  std::printf(
      "| mesh (vertices) | progressive: folded, off its faces | fair | progressive: off the shape "
      "| fair | taken |\n|---|--:|--:|--:|--:|---|\n");
  const auto backend = make_cpu_backend({Precision::Double});
  std::vector<std::string> wrong;
  Tally tally;
  for (const NamedCase& named : cases) {
    const Case made = named.make();
    if (!made.truth && !made.has_smooth_source) continue;
    const BestFit best = fit_best(made.mesh, *backend, methods()[2].options);
    std::printf("| %s%s (%d) |", named.name.c_str(), made.is_held_out ? "*" : "",
                made.mesh.vertex_count());
    print_quality(*best.progressive);
    if (best.fair) {
      print_quality(*best.fair);
    } else {
      std::printf(" |");
    }
    const double progressive = measure(made, methods()[2]).rms_normal;
    const double fair = measure(made, methods()[4]).rms_normal;
    const bool is_fair = best.method == InterpolationMethod::Fair;
    const double taken = is_fair ? fair : progressive, better = std::min(fair, progressive);
    std::printf(" %.2f | %.2f | %s |\n", progressive, fair, is_fair ? "fair" : "progressive");
    std::fflush(stdout);
    tally.add(taken, better);
    if (is_farther_off(taken, better)) {
      char text[200];
      std::snprintf(text, sizeof text, "%s: normals off by %.2f degrees, the other's by %.2f",
                    named.name.c_str(), taken, better);
      wrong.emplace_back(text);
    }
  }
  std::printf(
      "\nthe better one, or one as good, of %d of %d; elsewhere farther off by a factor of %.2f at "
      "most\n",
      tally.right, tally.count, tally.excess);
  return wrong;
}

}  // namespace planish::quality
