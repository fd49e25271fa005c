#include <algorithm>
#include <cstdio>
#include <utility>

#include "planish/mend/faults.h"
#include "planish/mend/repair.h"
#include "planish/mesh/check.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/quality_sum.h"
#include "quality/part_maker.h"
#include "quality/tables.h"
#include "quality/wild_shapes.h"

namespace planish::quality {
namespace {

// A kind, and its two members.
struct Kind {
  const char* name;
  std::function<PolygonMesh()> make, make_held_out;
};

std::vector<Kind> organic_kinds() {
  return {
      {"holed sphere, coarse", [] { return holed_sphere(1, 3, 1); },
       [] { return holed_sphere(1, 2, 101); }},
      {"holed sphere", [] { return holed_sphere(2, 5, 2); },
       [] { return holed_sphere(2, 7, 102); }},
      {"zigzag tube, 8", [] { return zigzag_tube(8, 4, 3); },
       [] { return zigzag_tube(10, 3, 103); }},
      {"zigzag tube, 16", [] { return zigzag_tube(16, 6, 4); },
       [] { return zigzag_tube(24, 5, 104); }},
      {"holed disc", [] { return holed_disc(12, 4, 5); }, [] { return holed_disc(17, 6, 105); }},
      {"needle sheet", [] { return needle_sheet(8, 6); }, [] { return needle_sheet(13, 106); }},
      {"star", [] { return spiked_star(7); }, [] { return spiked_star(107); }},
      {"animal, 150", [] { return low_poly_animal(150, 8); },
       [] { return low_poly_animal(170, 108); }},
      {"animal, 400", [] { return low_poly_animal(400, 9); },
       [] { return low_poly_animal(350, 109); }},
      {"decimated head", [] { return decimated_head(1, 0.05); },
       [] { return decimated_head(2.5, 0.05); }},
      {"needle disc", [] { return needle_disc(40, 10); }, [] { return needle_disc(61, 110); }},
      {"spindle", [] { return needle_spindle(40, 5, 6); },
       [] { return needle_spindle(64, 4, 10); }},
      {"needle sphere", [] { return needle_spindle(100, 5, 0); },
       [] { return needle_spindle(140, 7, 0); }},
      {"folded sphere", [] { return folded_sphere(4, 11); }, [] { return folded_sphere(7, 111); }},
      {"three sheets", [] { return three_sheets(6, 12); }, [] { return three_sheets(10, 112); }},
      {"torn sheet", [] { return torn_sheet(20, 3, 16); }, [] { return torn_sheet(14, 4, 116); }},
      {"flat loft", [] { return flat_loft(24, 17); }, [] { return flat_loft(29, 117); }},
  };
}

std::vector<Kind> foreign_kinds() {
  return {
      {"crossing parts", [] { return crossing_parts(40, 18); },
       [] { return crossing_parts(97, 118); }},
      {"touching tori", [] { return touching_tori(24, 2, 19); },
       [] { return touching_tori(17, 3, 119); }},
      {"loose sheets", [] { return loose_sheets(800, 20); },
       [] { return loose_sheets(1500, 120); }},
      {"pinched polygons", [] { return pinched_polygons(60, 21); },
       [] { return pinched_polygons(150, 121); }},
      {"holed scan", [] { return holed_scan(1500, 22); }, [] { return holed_scan(2500, 122); }},
  };
}

std::vector<Kind> part_kinds() {
  return {
      {"uneven box", [] { return uneven_box(5, 13, false); },
       [] { return uneven_box(8, 113, false); }},
      {"uneven box, triangles", [] { return uneven_box(5, 14, true); },
       [] { return uneven_box(7, 114, true); }},
      {"L part", [] { return l_part({16}); },
       [] {
         return l_part({26, 1.5});
       }},
      {"drilled plate", [] { return drilled_plate({16}, 3); },
       [] {
         return drilled_plate({24, 0.8}, 5);
       }},
      {"gear", [] { return gear({24}, 14); },
       [] {
         return gear({40, 2}, 23);
       }},
      {"rod",
       [] {
         return rod({48, 10});
       },
       [] {
         return rod({72, 30});
       }},
      {"pipe",
       [] {
         return pipe({32, 6});
       },
       [] {
         return pipe({50, 2.5});
       }},
      {"mitred pipe", [] { return mitred_pipe(40, 20, 15); },
       [] { return mitred_pipe(28, 12, 115); }},
      {"L part, decimated", [] { return simplified(l_part({32}), 2e-3); },
       [] {
         return simplified(l_part({48, 1.3}), 3e-3);
       }},
      {"plate, decimated", [] { return simplified(drilled_plate({32}, 4), 2e-3); },
       [] { return simplified(drilled_plate({40}, 3), 3e-3); }},
      {"gear, decimated", [] { return simplified(gear({48}, 16), 3e-3); },
       [] {
         return simplified(gear({60, 1.5}, 19), 5e-3);
       }},
      {"pipe, decimated",
       [] {
         return simplified(pipe({64, 3}), 2e-3);
       },
       [] {
         return simplified(pipe({90, 5}), 1e-3);
       }},
  };
}

}  // namespace

std::vector<NamedCase> wild_cases() {
  std::vector<NamedCase> cases;
  const auto add = [&](const std::string& name, bool is_held_out,
                       const std::function<PolygonMesh()>& make) {
    cases.push_back({name, [=] {
                       Case made{name, make(), {}};
                       made.is_held_out = is_held_out;
                       return made;
                     }});
  };
  for (const auto& kinds : {organic_kinds(), foreign_kinds(), part_kinds()}) {
    for (const Kind& kind : kinds) {
      add(kind.name, false, kind.make);
      add(std::string(kind.name) + ", held out", true, kind.make_held_out);
    }
  }
  return cases;
}

namespace {

constexpr double kFoldedPart = 1e-5;
constexpr int kLevels = 3;

struct WildFigures {
  double folded_elsewhere = 0, folded = 0, rms = 0;
};

WildFigures measure_wild(const PolygonMesh& mesh, const Fit& fitted, Backend& backend) {
  WildFigures figures;
  for (int level = 1; level <= kLevels; ++level) {
    EvaluateOptions at;
    at.level = level;
    at.rest_positions = mesh.positions;
    const SurfaceQuality quality = surface_quality(evaluate(mesh, fitted, backend, at), mesh);
    figures.folded_elsewhere = std::max(figures.folded_elsewhere, quality.folded_area_elsewhere);
    figures.folded = std::max(figures.folded, quality.folded_area);
    if (level == 2) figures.rms = quality.rms_normal_deviation;
  }
  return figures;
}

WildFigures of_method(const PolygonMesh& mesh, InterpolationMethod method, Backend& backend) {
  FitOptions options;
  options.method = method;
  return measure_wild(mesh, fit(mesh, backend, options), backend);
}

WildFigures with_creases(PolygonMesh mesh, Backend& backend) {
  const FoundCreases found = add_features(mesh, prepare_mesh(mesh, "mesh"));
  const CreasedFit creased = fit_with_found_creases(mesh, found, backend, {});
  return measure_wild(mesh, creased.fit, backend);
}

WildFigures chosen(const PolygonMesh& mesh, Backend& backend) {
  MeshFitOptions options;
  options.refine = RefineChoice::Off;
  const FittedMesh best = fit_mesh(mesh, "mesh", backend, options);
  return measure_wild(best.mesh, best.fit, backend);
}

void print_cell(const WildFigures& figures) {
  if (figures.folded_elsewhere > 0) {
    std::printf(" %.1e, %.2f |", figures.folded_elsewhere, figures.rms);
  } else {
    std::printf(" 0, %.2f |", figures.rms);
  }
}

}  // namespace

std::vector<std::string> print_wild_table(const std::vector<NamedCase>& cases) {
  std::printf(
      "| mesh (vertices; share of its area beside folded edges) | progressive | fair | fair, "
      "creases found | auto |\n|---|--:|--:|--:|--:|\n");
  const auto backend = make_cpu_backend({Precision::Double});
  std::vector<std::string> folded;
  for (const NamedCase& named : cases) {
    const PolygonMesh mesh = with_convex_faces(named.make().mesh).mesh;
    require_usable(mesh, named.name);
    std::printf("| %s (%d; %.2g) |", named.name.c_str(), mesh.vertex_count(),
                folded_edges(mesh).area);
    print_cell(of_method(mesh, InterpolationMethod::Progressive, *backend));
    const PolygonMesh with_cusps = with_cusp_corners(mesh);
    const WildFigures fair = of_method(with_cusps, InterpolationMethod::Fair, *backend);
    const WildFigures creased = with_creases(with_cusps, *backend);
    const WildFigures taken = chosen(mesh, *backend);
    for (const WildFigures& figures : {fair, creased, taken}) print_cell(figures);
    std::printf("\n");
    std::fflush(stdout);
    for (const auto& [figures, how] :
         {std::pair(fair, ""), {creased, " with creases found"}, {taken, " by auto"}}) {
      if (figures.folded_elsewhere > kFoldedPart) folded.push_back(named.name + how + " folds");
    }
    if (creased.folded_elsewhere > fair.folded_elsewhere)
      folded.push_back(named.name + " folds more with creases found than without");
  }
  return folded;
}

}  // namespace planish::quality
