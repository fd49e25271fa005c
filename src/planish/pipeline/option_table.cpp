#include "planish/pipeline/option_table.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "planish/core/assert.h"
#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/mesh/weld_vertices.h"
#include "planish/pipeline/crease_text.h"
#include "planish/pipeline/make_ready.h"
#include "planish/pipeline/option_rows.h"
#include "planish/pipeline/option_words.h"

namespace planish {
namespace {

using Kind = OptionKind;
using Needs = OptionNeeds;
using Stage = OptionStage;
using Where = std::string_view;

constexpr std::array kPrecisionWords{
    OptionWord<PrecisionChoice>{"auto", PrecisionChoice::Auto},
    OptionWord<PrecisionChoice>{"float", PrecisionChoice::Float},
    OptionWord<PrecisionChoice>{"double", PrecisionChoice::Double}};
constexpr std::array kRepairWords{OptionWord<RepairChoice>{"safe", RepairChoice::Safe},
                                  OptionWord<RepairChoice>{"none", RepairChoice::None}};
constexpr std::array kInterpolationWords{
    OptionWord<InterpolationChoice>{"auto", InterpolationChoice::Auto},
    OptionWord<InterpolationChoice>{"progressive", InterpolationChoice::Progressive},
    OptionWord<InterpolationChoice>{"fair", InterpolationChoice::Fair}};

FitOption preset_option() {
  return {{.name = "preset",
           .kind = Kind::Word,
           .words = {"paper"},
           .help = "averaged weights and the plain iteration, as published"},
          [](FitSettings& settings, const OptionValue&, Where) {
            settings.interpolation = InterpolationChoice::Progressive;
            settings.weights = Weights::Averaged;
            settings.solver = Solver::Plain;
          },
          {}};
}

FitOption creases_option() {
  return {{.name = "creases",
           .stage = Stage::Shape,
           .kind = Kind::Text,
           .choices = "choose|use|ignore|normals|auto[:DEGREES]",
           .initial = "choose",
           .example = "auto:40",
           .help = "sharp edges: tagged or found ones, tagged, none; split normals, found ones or "
                   "turns above too",
           .pattern = kCreasesPattern,
           .ranks = {"choose|use|ignore",
                     "edges are not looked for over ranks; tag them in the file, and take use"}},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            settings.creases = parse_creases(value.text, where);
          },
          [](const FitSettings& settings) {
            const CreaseChoice& creases = settings.creases;
            if (creases.split_normals) return std::string("normals");
            if (creases.chooses) return std::string("choose");
            return creases_text(creases.use_tags, creases.finds_features, creases.dihedral_degrees);
          }};
}

FitOption within_option() {
  static constexpr std::string_view kWanted =
      "auto, 0, or a fraction of the bounding-box diagonal above the tolerance and less than 0.1 "
      "is "
      "wanted, such as 0.001";
  return {
      {.name = "within",
       .stage = Stage::Shape,
       .kind = Kind::TextOrNumber,
       .choices = "0|E|auto",
       .example = "0.001",
       .help = "leave vertices by up to this fraction of the diagonal to bend least; auto: by the "
               "noise that is measured",
       .ranks = {"!auto", "ranks do not measure noise; say how far, such as 0.001"}},
      [](FitSettings& settings, const OptionValue& value, Where where) {
        settings.within = {};
        if (value.text == "auto") {
          settings.within.is_measured = true;
          return;
        }
        double within = 0;
        if (!parse_number(value.text, within) || !(within >= 0 && within < kMostWithin))
          refuse(where, "\"" + visible(value.text) + "\" is neither; " + std::string(kWanted));
        settings.within.of_diagonal = within;
      },
      [](const FitSettings& settings) {
        if (settings.within.is_measured) return std::string("auto");
        return settings.within.of_diagonal ? shortest(*settings.within.of_diagonal) : std::string();
      }};
}

FitOption weld_option() {
  static constexpr std::string_view kWanted =
      "0, or a fraction of the bounding-box diagonal from 1e-12 to less than 0.1, is wanted, such "
      "as 1e-6";
  return {{.name = "weld",
           .stage = Stage::Shape,
           .kind = Kind::Number,
           .needs = Needs::Faces,
           .limits = {.least = 0, .most = 0.1, .below_most = true, .wanted = kWanted},
           .choices = "T",
           .example = "1e-6",
           .help = "meshes: make vertices one that lie within this fraction of the diagonal",
           .ranks = {"",
                     "nothing is welded over ranks; planish fit IN --weld T --max-iterations 0 "
                     "--cage WELDED.obj writes the welded mesh"}},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            if (!can_weld_within(value.number))
              refuse(where, shortest(value.number) + " is out of range; " + std::string(kWanted));
            settings.weld = value.number;
          },
          [](const FitSettings& settings) {
            return settings.weld ? shortest(*settings.weld) : std::string();
          }};
}

FitOption crease_edges_option() {
  return {{.name = "crease_edges",
           .kind = Kind::Edges,
           .example = "[[0, 1]]",
           .help = "sharp edges besides those that the file tags: pairs of its vertices, counted "
                   "from 0"},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.crease_edges.clear();
            for (std::size_t i = 0; i + 1 < value.wholes.size(); i += 2)
              settings.crease_edges.push_back({static_cast<std::int32_t>(value.wholes[i]),
                                               static_cast<std::int32_t>(value.wholes[i + 1])});
          },
          {}};
}

FitOption corner_vertices_option() {
  return {{.name = "corner_vertices",
           .kind = Kind::Vertices,
           .example = "[0]",
           .help = "sharp vertices besides those that the file tags, counted from 0"},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.corner_vertices.clear();
            for (const std::int64_t vertex : value.wholes)
              settings.corner_vertices.push_back({static_cast<std::int32_t>(vertex)});
          },
          {}};
}

void append(std::vector<FitOption>& table, std::vector<FitOption> rows) {
  std::ranges::move(rows, std::back_inserter(table));
}

std::vector<FitOption> make_table() {
  std::vector<FitOption> table{
      preset_option(),
      word_option({.name = "scheme",
                   .stage = Stage::Shape,
                   .initial = "doo-sabin",
                   .help = "subdivision scheme; catmull-clark and loop as OpenSubdiv has them",
                   .ranks = {"doo-sabin", "take doo-sabin"}},
                  kSchemeWords, &FitSettings::scheme),
      word_option({.name = "interpolation",
                   .stage = Stage::Shape,
                   .initial = "auto",
                   .help = "progressive: as in the paper; fair: without folds on uneven meshes; "
                           "auto: the better of both by measurement, fair for points, progressive "
                           "for --cage",
                   .keyword = "method"},
                  kInterpolationWords, &FitSettings::interpolation),
      word_option({.name = "weights",
                   .stage = Stage::Shape,
                   .initial = "doo-sabin",
                   .help = "subdivision weights: Doo & Sabin 1978, or the paper's averages"},
                  kWeightsWords, &FitSettings::weights),
      word_option({.name = "solver",
                   .needs = Needs::Progressive,
                   .initial = "chebyshev",
                   .help = "chebyshev; plain as in the paper; cg for closed smooth meshes",
                   .ranks = {"chebyshev|plain", "take chebyshev or plain"}},
                  kSolverWords, &FitSettings::solver),
      word_option({.name = "precision",
                   .needs = Needs::Progressive,
                   .initial = "auto",
                   .help = "of the solve on the CPU; auto takes double for tolerances below 1e-8",
                   .ranks = {"auto|double", "ranks solve in double precision; take double"}},
                  kPrecisionWords, &FitSettings::precision),
      word_option({.name = "boundary",
                   .stage = Stage::Shape,
                   .initial = "edge",
                   .help = "open boundaries are smooth curves, or have corners where one face "
                           "meets them"},
                  kBoundaryWords, &FitSettings::boundary),
      creases_option(),
      word_option({.name = "repair",
                   .stage = Stage::Shape,
                   .initial = "safe",
                   .help = "safe mends winding, non-manifold and degenerate parts, and cuts "
                           "concave faces for fair surfaces; none leaves them and refuses what "
                           "cannot be used",
                   .ranks = {"none",
                             "nothing is mended over ranks; planish fit IN --max-iterations 0 "
                             "--cage MENDED.obj writes the mended mesh"}},
                  kRepairWords, &FitSettings::repair),
      word_option({.name = "quads",
                   .stage = Stage::Shape,
                   .initial = "auto",
                   .help = "join triangles to quads; auto: where that is better",
                   .ranks = {"auto|off",
                             "nothing is joined over ranks; planish fit IN --quads on "
                             "--max-iterations 0 --cage QUADS.obj writes the mesh of quads"}},
                  kQuadWords, &FitSettings::quads),
      word_option({.name = "refine",
                   .stage = Stage::Shape,
                   .initial = "auto",
                   .help = "add vertices between those of uneven triangles, on a smooth guess of "
                           "the surface; auto: where it bends less for them",
                   .ranks = {"auto|off", "no vertices are added over ranks"}},
                  kRefineWords, &FitSettings::refine),
  };
  append(table, file_options());
  append(
      table,
      {
          number_option({.name = "tolerance",
                         .limits = {.least = 0,
                                    .most = 1,
                                    .above_least = true,
                                    .wanted = "a fraction of the bounding-box diagonal above 0 and "
                                              "up to 1 is wanted, such as 1e-6"},
                         .choices = "T",
                         .initial = "1e-6",
                         .help = "largest vertex error, of the bounding box's diagonal"},
                        &FitSettings::tolerance),
          whole_option({.name = "max_iterations",
                        .needs = Needs::Progressive,
                        .limits = {0, 1'000'000},  // no solve that converges at all needs as many
                        .choices = "N",
                        .initial = "200",
                        .help = "give up after so many"},
                       &FitSettings::max_iterations),
          whole_option({.name = "polish",
                        .needs = Needs::Fair,
                        .limits = {0, 1'000},  // quality is settled by ten
                        .choices = "N",
                        .initial = "8",
                        .help = "steps that even out the curvature of a fair surface"},
                       &FitSettings::polish_steps),
          within_option(),
          weld_option(),
      });
  append(table, tile_options());
  append(table, step_options());
  append(table, {crease_edges_option(), corner_vertices_option()});
  append(table, fineness_options());
  return table;
}

}  // namespace

const std::vector<FitOption>& option_table() {
  static const std::vector<FitOption> table = make_table();
  return table;
}

const FitOption& fit_option(std::string_view name) {
  const FitOption* option = find_option(option_table(), name);
  PLANISH_ASSERT(option != nullptr);
  return *option;
}

std::string option_text(const FitSettings& settings, std::string_view name) {
  return fit_option(name).get(settings);
}

std::string flag_of_option(std::string_view name) { return flag_of(fit_option(name)); }

}  // namespace planish
