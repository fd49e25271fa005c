#include "quality/wild_cases.h"

#include <utility>

#include "quality/foreign_shapes.h"
#include "quality/loft_shapes.h"
#include "quality/part_shapes.h"
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

}  // namespace planish::quality
