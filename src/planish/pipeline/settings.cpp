#include "planish/pipeline/settings.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/mend/repair.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/option_table.h"
#include "planish/surface/bake_normals.h"

namespace planish {
namespace {

// The texts that it takes, as a regular expression.
constexpr std::string_view kCreasesPattern =
    "^(choose|use|ignore|normals|auto(:0*(180(\\.0+)?|(1[0-7][0-9]|[1-9]?[0-9])(\\.[0-9]+)?)(e-[0-"
    "9]+)?)?)"
    "$";

// Numbers of pixels are told from each other by parse_pixels().
constexpr std::string_view kPixelsPattern =
    "^[0-9.]+(e-?[0-9]+)?@[0-9.]+(e[0-9]+)?(,[0-9.]+(e-?[0-9]+)?@[0-9.]+(e[0-9]+)?)*$";
// So many corners 32-bit indices reach.
constexpr std::int64_t kMostFaces = 700'000'000;

// Digits, with a point or without, of 0 to 180; e-5 may follow, as it does in headers of cages.
// What kCreasesPattern takes: a regular expression cannot tell the size of other numbers.
bool parse_angle(std::string_view text, double& degrees) {
  constexpr std::string_view kDigits = "0123456789";
  const std::size_t exponent = std::min(text.find("e-"), text.size());
  const std::string_view mantissa = text.substr(0, exponent);
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  const auto is_digits = [&](std::string_view part) {
    return !part.empty() && part.find_first_not_of(kDigits) == std::string_view::npos;
  };
  return is_digits(mantissa.substr(0, point)) &&
         (point == mantissa.size() || is_digits(mantissa.substr(point + 1))) &&
         (exponent == text.size() || is_digits(text.substr(exponent + 2))) &&
         parse_number(mantissa, degrees) && degrees <= 180 && parse_number(text, degrees);
}

// "use", "ignore", "normals", "auto" or "auto:22.5". Throws Error{InvalidArgument}: `where`, the
// text and what is wanted.
CreaseChoice parse_creases(std::string_view text, std::string_view where) {
  constexpr std::array<std::string_view, 5> kKnown{"choose", "use", "ignore", "normals", "auto"};
  const std::string shown = in_double_quotes(text);
  const std::string no_choice = shown + " is not one of choose, use, ignore, normals, auto:DEGREES";
  double degrees = 0;
  if (text == "choose") return {.chooses = true};
  if (text == "use") return {};
  if (text == "ignore") return {.use_tags = false};
  if (text == "normals") return {.split_normals = true};
  if (text == "auto") return {.finds_features = true};
  if (parse_number(text, degrees))
    refuse(where, no_choice + "; did you mean auto:" + visible(text) + "?");
  if (!text.starts_with("auto:")) refuse(where, no_choice + did_you_mean(text, kKnown));
  const std::string_view angle = text.substr(5);
  if (!parse_angle(angle, degrees))
    refuse(where, in_double_quotes(angle) + " is no angle of 0 to 180 degrees such as 22.5");
  return {.dihedral_degrees = degrees};
}

}  // namespace

// The rows of option_table() about what is written.

namespace {

using Kind = OptionKind;
using Needs = OptionNeeds;
using Stage = OptionStage;
using Where = std::string_view;

constexpr std::array kUpWords{OptionWord<UpAxis>{"y", UpAxis::Y},
                              OptionWord<UpAxis>{"z", UpAxis::Z}};
constexpr std::array kAssetWords{OptionWord<AssetChoice>{"keep", AssetChoice::Keep},
                                 OptionWord<AssetChoice>{"merge", AssetChoice::Merge}};
constexpr std::array kCageWords{
    OptionWord<std::optional<Scheme>>{"surface", std::nullopt},
    OptionWord<std::optional<Scheme>>{"catmull-clark", Scheme::CatmullClark}};
constexpr std::array kLodWords{OptionWord<LodChoice>{"files", LodChoice::Files},
                               OptionWord<LodChoice>{"msft", LodChoice::Msft}};
constexpr std::array kReachWords{OptionWord<FileReach>{"beside", FileReach::Beside},
                                 OptionWord<FileReach>{"anywhere", FileReach::Anywhere}};
constexpr std::array kCompressionWords{
    OptionWord<GltfCompression>{"none", GltfCompression::None},
    OptionWord<GltfCompression>{"quantize", GltfCompression::Quantize},
    OptionWord<GltfCompression>{"meshopt", GltfCompression::Meshopt}};
constexpr std::array kFieldWords{
    OptionWord<bool FieldChoice::*>{"error", &FieldChoice::error},
    OptionWord<bool FieldChoice::*>{"deviation", &FieldChoice::deviation},
    OptionWord<bool FieldChoice::*>{"fold", &FieldChoice::fold},
    OptionWord<bool FieldChoice::*>{"curvature", &FieldChoice::curvature}};

constexpr std::string_view kTilesHaveLevels = "tiles have levels; take levels";

// A list of words, each switching one on.
FitOption attributes_option() {
  FitOption option{{.name = "attributes",
                    .stage = Stage::Output,
                    .kind = Kind::Words,
                    .example = "error,curvature",
                    .help = "write these figures of each vertex into glTF, PLY and USD",
                    .ranks = {"", "tiles of ranks carry no figures of vertices; leave it out"}},
                   [](FitSettings& settings, const OptionValue& value, Where) {
                     settings.attributes = {};
                     for (const std::int64_t index : value.wholes)
                       settings.attributes.*kFieldWords[static_cast<std::size_t>(index)].value =
                           true;
                   },
                   {}};
  for (const auto& word : kFieldWords) option.words.push_back(word.text);
  return option;
}

FitOption bake_option() {
  return {{.name = "bake",
           .stage = Stage::Output,
           .kind = Kind::Whole,
           .limits = {.least = kLeastBakeSize, .most = kMostBakeSize},
           .choices = "N",
           .example = "1024",
           .help = "glTF: keep the input's mesh and add normal textures of N x N texels, "
                   "so that it looks like the surface; needs texture coordinates",
           .ranks = {"", "ranks write 3D Tiles; planish fit bakes"}},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.bake = static_cast<int>(value.whole);
          },
          {}};
}

FitOption device_option() {
  return {{.name = "device",
           .stage = Stage::Output,
           .kind = Kind::Text,
           .choices = "auto|cpu|vulkan|INDEX|NAME|UUID",
           .initial = "auto",
           .help = "auto: the CPU; vulkan: the best Vulkan device; planish devices lists "
                   "them",
           .ranks = {"auto|cpu", "ranks work on the CPU; take cpu"}},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            if (value.text.empty()) refuse(where, "is empty; planish devices lists what there is");
            settings.device = value.text;
          },
          [](const FitSettings& settings) { return settings.device; }};
}

FitOption skirts_option() {
  return {
      {.name = "skirts",
       .stage = Stage::Output,
       .kind = Kind::Switch,
       .needs = Needs::Tiles,
       .initial = "false",
       .help = "3D Tiles: hide gaps between levels behind strips along the edges of "
               "tiles"},
      [](FitSettings& settings, const OptionValue& value, Where) { settings.skirts = value.is_on; },
      {}};
}

FitOption levels_option() {
  return {{.name = "levels",
           .stage = Stage::Fineness,
           .kind = Kind::Wholes,
           .needs = Needs::Fineness,
           .limits = {.least = 0, .most = kMaxLevel, .wanted = "levels are 0 to 6"},
           .choices = "auto|L[,L2,...]",
           .initial = "auto",
           .example = "3,1",
           .help = "quad splits, 0 to 6; auto: 2, dense meshes 1; several: NAME_LOD0.glb, "
                   "...; 3D Tiles: all from 1 to it",
           .entry = "level",
           .word = "auto"},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.levels_by_density = value.wholes.empty();
            settings.levels = {2};
            if (!settings.levels_by_density)
              settings.levels.assign(value.wholes.begin(), value.wholes.end());
          },
          {}};
}

FitOption chord_errors_option() {
  return {{.name = "chord_errors",
           .stage = Stage::Fineness,
           .kind = Kind::Numbers,
           .needs = Needs::Fineness,
           .limits = {.least = 0,
                      .most = 1,
                      .above_least = true,
                      .wanted = "parts of the diagonal above 0 to 1 are wanted, such as 0.001"},
           .choices = "E[,E2,...]",
           .example = "0.01,0.001",
           .help = "instead of levels: triangles within this distance of the surface, as a "
                   "fraction of the diagonal; several: NAME_LOD0.glb, ...",
           .flag = "--chord-error",
           .entry = "chord error",
           .ranks = {"", kTilesHaveLevels}},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.adaptive.chord_errors = value.numbers;
          },
          {}};
}

FitOption faces_option() {
  return {{.name = "faces",
           .stage = Stage::Fineness,
           .kind = Kind::Wholes,
           .needs = Needs::Fineness,
           .limits = {.least = 1, .most = kMostFaces},
           .choices = "N[,N2,...]",
           .example = "5000,500",
           .help = "instead of levels: at most so many triangles in a file, fewer than the input "
                   "has or more; several: NAME_LOD0.glb, ...",
           .entry = "number of faces",
           .ranks = {"", kTilesHaveLevels}},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.adaptive.faces = value.wholes;
          },
          {}};
}

FitOption edge_lengths_option() {
  return {{.name = "edge_lengths",
           .stage = Stage::Fineness,
           .kind = Kind::Numbers,
           .needs = Needs::Fineness,
           .limits = {.least = 0,
                      .most = std::numeric_limits<double>::max(),
                      .above_least = true,
                      .wanted = "lengths above 0 are wanted, in the input's unit, such as 0.1"},
           .choices = "LENGTH[,L2,...]",
           .example = "0.1",
           .help = "instead of levels: as many triangles as there would be of equal sides of this "
                   "length, in the input's unit",
           .flag = "--edge",
           .entry = "edge length",
           .ranks = {"", kTilesHaveLevels}},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.adaptive.edge_lengths = value.numbers;
          },
          {}};
}

// "1@1080,2@540".
std::vector<double> parse_pixels(std::string_view text, Where where) {
  std::vector<double> distances;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view one = text.substr(begin, end - begin);
    const std::size_t at = std::min(one.find('@'), one.size());
    double pixels = 0, view = 0;
    if (at == one.size() || !parse_number(one.substr(0, at), pixels) ||
        !parse_number(one.substr(at + 1), view) || !(pixels > 0) || !(view > pixels))
      refuse(where, in_double_quotes(one) +
                        " is not N@VIEW, pixels that the surface may be off by where "
                        "it fills a view of VIEW, such as 1@1080");
    distances.push_back(pixels / view);
    begin = end + 1;
  }
  return distances;
}

FitOption pixels_option() {
  return {{.name = "pixels",
           .stage = Stage::Fineness,
           .kind = Kind::Text,
           .needs = Needs::Fineness,
           .choices = "N@VIEW[,...]",
           .example = "1@1080,1@270",
           .help = "instead of levels: few triangles, off by at most N pixels where the surface "
                   "fills a view VIEW pixels high",
           .pattern = kPixelsPattern,
           .ranks = {"", kTilesHaveLevels}},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            settings.adaptive.distances = parse_pixels(value.text, where);
          },
          {}};
}

FitOption set_option_of_parts() {
  return {{.name = "set",
           .stage = Stage::Output,
           .kind = Kind::Text,
           .choices = "PART:OPTION=VALUE",
           .example = "mesh=Wheel:creases=use",
           .help = "glTF to glTF: an option for some meshes only: mesh=NAME, material=NAME or "
                   "node=NAME, * in it for any text; several times, or with ; between",
           .joiner = "; ",
           .ranks = {"", "ranks write 3D Tiles, which are one mesh"}},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            settings.parts = parse_part_settings(value.text, where);
          },
          {}};
}

// Of files in general, and of glTF.
std::vector<FitOption> file_options() {
  return {
      word_option({.name = "up",
                   .stage = Stage::Output,
                   .initial = "y",
                   .help = "up axis of the input; z: rotated to Y-up in glTF, recorded in USD"},
                  kUpWords, &FitSettings::up),
      attributes_option(),
      word_option({.name = "cage_scheme",
                   .stage = Stage::Output,
                   .initial = "surface",
                   .help = "--cage: control points of the surface; or a Catmull-Clark cage with "
                           "creases through the same points, which engines, Blender and USD draw",
                   .ranks = {"surface",
                             "ranks write cages of their surface; planish fit writes "
                             "others"}},
                  kCageWords, &FitSettings::cage_scheme),
      word_option({.name = "asset",
                   .stage = Stage::Output,
                   .initial = "keep",
                   .help = "glTF to glTF: keep: fit each mesh, keep nodes, materials, textures, "
                           "skins and animations; merge: the whole scene as one mesh"},
                  kAssetWords, &FitSettings::asset),
      word_option({.name = "lods",
                   .stage = Stage::Output,
                   .initial = "files",
                   .help = "several levels: a file each, or, glTF to glTF, levels of detail in one "
                           "file (MSFT_lod)"},
                  kLodWords, &FitSettings::lods),
      set_option_of_parts(),
      word_option({.name = "textures",
                   .stage = Stage::Input,
                   .initial = "beside",
                   .help = "files that the input may name (textures, materials, buffers): in its "
                           "folder or below, or anywhere",
                   .ranks = {"beside", "ranks read no textures; take beside"}},
                  kReachWords, &FitSettings::textures),
      word_option({.name = "compress",
                   .stage = Stage::Output,
                   .initial = "none",
                   .help = "make glTF smaller, within the tolerance; quantize: 16-bit numbers; "
                           "meshopt: packed as well, for readers such as three.js and Babylon.js "
                           "(Blender 3.4 has none)",
                   .ranks = {"none", "tiles of ranks are not compressed; take none"}},
                  kCompressionWords, &FitSettings::compression),
      bake_option(),
      device_option(),
  };
}

std::vector<FitOption> tile_options() {
  return {
      whole_option({.name = "tile_vertices",
                    .stage = Stage::Output,
                    .needs = Needs::Tiles,
                    .limits = {kLeastTileVertices, 1 << 24},  // what viewers load at once
                    .choices = "N",
                    .initial = "262144",
                    .help = "3D Tiles: about N vertices a file"},
                   &FitSettings::tile_vertices),
      skirts_option(),
  };
}

FitOption analytic_tolerance_option() {
  return {{.name = "step_analytic_tolerance",
           .stage = Stage::Output,
           .kind = Kind::TextOrNumber,
           .choices = "auto|T",
           .initial = "auto",
           .example = "1e-4",
           .help = "STEP: largest distance of vertices from such a surface, as a fraction of the "
                   "diagonal; auto: 1.5e-6, or five deviations of the measured noise"},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            settings.step.analytic_tolerance = {};
            if (value.text == "auto") return;
            double tolerance = 0;
            if (!parse_number(value.text, tolerance) ||
                !(tolerance > 0 && tolerance <= kMostAnalyticTolerance))
              refuse(where, in_double_quotes(value.text) +
                                " is neither; auto, or a fraction of the bounding-box diagonal "
                                "above 0 and up to 0.1 is wanted, such as 1e-4");
            settings.step.analytic_tolerance = tolerance;
          },
          [](const FitSettings& settings) {
            const std::optional<double>& tolerance = settings.step.analytic_tolerance;
            return tolerance ? shortest(*tolerance) : std::string("auto");
          }};
}

std::vector<FitOption> step_options() {
  std::vector<FitOption> rows{
      word_option({.name = "step_unit",
                   .initial = "auto",
                   .help = "STEP: unit of the coordinates, which are not changed; auto: m for "
                           "glTF, else mm"},
                  kStepUnitWords, &FitSettings::step, &StepSettings::unit),
      word_option({.name = "step_analytic",
                   .initial = "auto",
                   .help = "STEP: what lies on planes, cylinders, cones, spheres and tori gets "
                           "such faces; off: all faces are splines through every vertex"},
                  kAnalyticWords, &FitSettings::step, &StepSettings::analytic),
      analytic_tolerance_option(),
      number_option({.name = "step_angle",
                     .limits = {.least = 0,
                                .most = kMostBrepAngle,
                                .above_least = true,
                                .wanted = "above 0 to 90 degrees are wanted"},
                     .choices = "DEGREES",
                     .initial = "0.25",
                     .help = "STEP: largest angle between the normals of two faces that meet"},
                    &FitSettings::step, &StepSettings::faces, &BrepOptions::angle),
      number_option(
          {.name = "step_tolerance",
           .limits = {.least = 0,
                      .most = 1,
                      .above_least = true,
                      .wanted = "a fraction of the bounding-box diagonal above 0 and up "
                                "to 1 is wanted, such as 1e-6"},
           .choices = "T",
           .initial = "1e-6",
           .help = "STEP: largest distance of the faces from the surface, as a fraction of "
                   "the diagonal"},
          &FitSettings::step, &StepSettings::faces, &BrepOptions::deviation),
      whole_option({.name = "step_face_size",
                    .limits = {.least = 1, .most = kMostFaceSize},
                    .choices = "N",
                    .initial = "16",
                    .help = "STEP: most quads along a face (a face of the mesh has two); programs "
                            "measure long faces badly"},
                   &FitSettings::step, &StepSettings::faces, &BrepOptions::face_size),
  };
  for (FitOption& row : rows) {
    row.stage = Stage::Output;
    row.needs = Needs::Step;
    row.ranks = {"", "ranks write 3D Tiles; planish fit writes STEP"};
  }
  return rows;
}

std::vector<FitOption> fineness_options() {
  return {levels_option(),
          chord_errors_option(),
          number_option(
              {.name = "angle",
               .stage = Stage::Fineness,
               .needs = Needs::Fineness,
               .limits = {.least = 0,
                          .most = 180,
                          .above_least = true,
                          .wanted = "above 0 to 180 degrees are wanted"},
               .choices = "DEGREES",
               .example = "10",
               .help = "triangles beneath which the surface turns by at most DEGREES, instead "
                       "of levels or besides --chord-error",
               .ranks = {"", kTilesHaveLevels}},
              &FitSettings::adaptive, &AdaptiveChoice::angle),
          faces_option(),
          edge_lengths_option(),
          pixels_option()};
}

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
           .help = "paper: the published method: averaged weights and the plain iteration"},
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
           .help = "choose: tagged edges, else those that are found; use: tagged; ignore: "
                   "none; normals: split normals too; auto: also found edges, or turns "
                   "above DEGREES",
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
  return {{.name = "within",
           .stage = Stage::Shape,
           .kind = Kind::TextOrNumber,
           .choices = "0|E|auto",
           .example = "0.001",
           .help = "leave the vertices by up to this fraction of the diagonal, to bend "
                   "less; auto: by the measured noise",
           .ranks = {"!auto", "ranks do not measure noise; say how far, such as 0.001"}},
          [](FitSettings& settings, const OptionValue& value, Where where) {
            settings.within = {};
            if (value.text == "auto") {
              settings.within.is_measured = true;
              return;
            }
            double within = 0;
            if (!parse_number(value.text, within) || !(within >= 0 && within < kMostWithin))
              refuse(where, in_double_quotes(value.text) + " is neither; " + std::string(kWanted));
            settings.within.of_diagonal = within;
          },
          [](const FitSettings& settings) {
            if (settings.within.is_measured) return std::string("auto");
            return settings.within.of_diagonal ? shortest(*settings.within.of_diagonal)
                                               : std::string();
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
           .help = "merge vertices within this fraction of the diagonal",
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
                   .help = "subdivision scheme; catmull-clark and loop are OpenSubdiv's",
                   .ranks = {"doo-sabin", "take doo-sabin"}},
                  kSchemeWords, &FitSettings::scheme),
      word_option({.name = "interpolation",
                   .stage = Stage::Shape,
                   .initial = "auto",
                   .help = "progressive: the paper's; fair: for uneven meshes, on which that one "
                           "folds; auto: the better of both (points: fair; with --cage: "
                           "progressive)",
                   .keyword = "method"},
                  kInterpolationWords, &FitSettings::interpolation),
      word_option({.name = "weights",
                   .stage = Stage::Shape,
                   .initial = "doo-sabin",
                   .help = "Doo & Sabin's weights of 1978, or the paper's averages"},
                  kWeightsWords, &FitSettings::weights),
      word_option({.name = "solver",
                   .needs = Needs::Progressive,
                   .initial = "chebyshev",
                   .help = "chebyshev: fastest; plain: the paper's iteration; cg: conjugate "
                           "gradients, for closed smooth meshes",
                   .ranks = {"chebyshev|plain", "take chebyshev or plain"}},
                  kSolverWords, &FitSettings::solver),
      word_option({.name = "precision",
                   .needs = Needs::Progressive,
                   .initial = "auto",
                   .help = "numbers of the solve on the CPU; auto: double for tolerances below "
                           "1e-8, else float",
                   .ranks = {"auto|double", "ranks solve in double precision; take double"}},
                  kPrecisionWords, &FitSettings::precision),
      word_option({.name = "boundary",
                   .stage = Stage::Shape,
                   .initial = "edge",
                   .help = "open boundaries are smooth curves; edge-and-corner: with corners where "
                           "one face meets them"},
                  kBoundaryWords, &FitSettings::boundary),
      creases_option(),
      word_option({.name = "repair",
                   .stage = Stage::Shape,
                   .initial = "safe",
                   .help = "safe: mend winding, non-manifold and degenerate parts, cut concave "
                           "faces; none: refuse what cannot be used",
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
                   .help = "add vertices between uneven triangles; auto: where the surface bends "
                           "less for it",
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
                         .help = "largest error at a vertex, of the diagonal"},
                        &FitSettings::tolerance),
          whole_option({.name = "max_iterations",
                        .needs = Needs::Progressive,
                        .limits = {0, 1'000'000},  // no solve that converges at all needs as many
                        .choices = "N",
                        .initial = "200",
                        .help = "stop after N iterations, converged or not"},
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

std::vector<std::string_view> AdaptiveChoice::kinds() const {
  std::vector<std::string_view> given;
  if (!chord_errors.empty()) given.emplace_back("chord_errors");
  if (chord_errors.empty() && angle > 0) given.emplace_back("angle");
  if (!faces.empty()) given.emplace_back("faces");
  if (!edge_lengths.empty()) given.emplace_back("edge_lengths");
  if (!distances.empty()) given.emplace_back("pixels");
  return given;
}

std::size_t AdaptiveChoice::count() const {
  return std::max(targets().size(),
                  chord_errors.empty() && angle > 0 ? std::size_t{1} : chord_errors.size());
}

std::vector<DecimationTarget> AdaptiveChoice::targets() const {
  std::vector<DecimationTarget> all;
  for (const std::int64_t count : faces) all.push_back({.triangles = count});
  for (const double length : edge_lengths) all.push_back({.edge_length = length});
  for (const double distance : distances) all.push_back({.distance = distance});
  return all;
}

MeshFitOptions mesh_fit_options(const FitSettings& settings) {
  MeshFitOptions options;
  if (settings.interpolation == InterpolationChoice::Progressive)
    options.method = InterpolationMethod::Progressive;
  if (settings.interpolation == InterpolationChoice::Fair)
    options.method = InterpolationMethod::Fair;
  options.repairs = settings.repair == RepairChoice::Safe;
  options.finds_features = settings.creases.finds_features;
  options.crease_degrees = settings.creases.dihedral_degrees;
  options.chooses_creases = settings.creases.chooses;
  options.quads = settings.quads;
  options.refine = settings.refine;
  // The mesh under a baked map is the input's.
  if (settings.bake > 0 && settings.refine == RefineChoice::Auto)
    options.refine = RefineChoice::Off;
  options.weld = settings.weld;
  options.fit.scheme = settings.scheme;
  options.fit.weights = settings.weights;
  options.fit.solver = settings.solver;
  options.fit.tolerance = settings.tolerance;
  options.fit.max_iterations = settings.max_iterations;
  options.fit.polish_steps = settings.polish_steps;
  options.fit.sharp = {settings.boundary, settings.creases.use_tags};
  options.fit.within = settings.within.of_diagonal.value_or(0.0);
  if (settings.within.is_measured) options.fit.within.reset();
  return options;
}

FitOptions fit_options(const FitSettings& settings, InterpolationMethod method) {
  FitOptions options = mesh_fit_options(settings).fit;
  options.method = method;
  options.sharp = settings.sharp();
  return options;
}

VerifyOptions verify_options(const FitSettings& settings) {
  if (settings.within.is_measured)
    refuse("within", "\"auto\" does not say how far; take what the fit allowed");
  VerifyOptions options;
  options.fit = mesh_fit_options(settings);
  options.tolerance = std::max(settings.tolerance, settings.within.of_diagonal.value_or(0.0));
  return options;
}

Precision solve_precision(const FitSettings& settings) {
  if (settings.precision == PrecisionChoice::Float) return Precision::Float;
  if (settings.precision == PrecisionChoice::Double) return Precision::Double;
  return precision_for(settings.tolerance);
}

void check_consistent(const FitSettings& settings, SpellOption spell) {
  if (settings.device == "vulkan" && settings.precision != PrecisionChoice::Auto) {
    refuse(spell("precision"),
           "{} is for the CPU backend; leave it out with {} vulkan, or take {} cpu",
           option_text(settings, "precision"), spell("device"), spell("device"));
  }
  if (settings.within.of_diagonal.value_or(0) > 0 &&
      *settings.within.of_diagonal <= settings.tolerance) {
    refuse(spell("within"), option_text(settings, "within") + " is not above " +
                                spell("tolerance") + " " + option_text(settings, "tolerance") +
                                ", within which the surface passes the vertices anyway");
  }
  const std::vector<std::string_view> kinds = settings.adaptive.kinds();
  if (kinds.size() > 1) {
    refuse(spell(kinds[0]), "a surface has that or {}, not both; leave one of them out",
           spell(kinds[1]));
  }
  if (!kinds.empty() && settings.attributes.any()) {
    refuse(spell("attributes"), "fields are made on levels; take {} instead of {}", spell("levels"),
           spell(kinds[0]));
  }
  if (settings.bake > 0 && settings.refine == RefineChoice::On) {
    refuse(spell("refine"), "a baked map is of the input's own vertices; leave it or {} out",
           spell("bake"));
  }
  if (settings.bake > 0 && !kinds.empty())
    refuse(spell("bake"), "a baked map is of level 0; leave {} out", spell(kinds[0]));
  if (settings.scheme == Scheme::DooSabin) return;
  const std::string scheme = option_text(settings, "scheme");
  const std::string doo_sabin = spell("scheme") + " doo-sabin";
  if (settings.scheme == Scheme::Loop && settings.quads == QuadChoice::On) {
    refuse(spell("quads"), "loop surfaces are of triangles; take off, or " + doo_sabin);
  }
  if (!kinds.empty()) {
    refuse(spell(kinds[0]),
           scheme + " surfaces come in levels; take " + spell("levels") + ", or " + doo_sabin);
  }
  if (settings.weights != Weights::DooSabin) {
    refuse(spell("weights"), "{} belongs to {}; leave it and {} paper out with {} {}",
           option_text(settings, "weights"), doo_sabin, spell("preset"), spell("scheme"), scheme);
  }
  if (settings.interpolation == InterpolationChoice::Fair) {
    refuse(spell("interpolation"),
           "fair builds control points of Doo-Sabin's level 1, "
           "which {} does not have; take progressive, or {}",
           scheme, doo_sabin);
  }
}

void settle(FitSettings& settings, const FittedMesh& fitted) {
  settings.scheme = fitted.options.scheme;
  settings.weights = fitted.options.weights;
  settings.creases.chooses = false;
  settings.creases.finds_features = fitted.finds_features;
  settings.creases.dihedral_degrees = fitted.crease_degrees;
  settings.quads = fitted.pairs_triangles ? QuadChoice::On : QuadChoice::Off;
  settings.refine = fitted.added_vertices.empty() ? RefineChoice::Off : RefineChoice::On;
  if (fitted.fit.within) settings.within = {.of_diagonal = fitted.fit.within->within};
}

}  // namespace planish
