#include <array>
#include <cstddef>
#include <string>
#include <utility>

#include "planish/core/number_text.h"
#include "planish/core/refuse.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/pipeline/option_rows.h"
#include "planish/pipeline/option_words.h"
#include "planish/surface/bake_normals.h"

namespace planish {
namespace {

using Kind = OptionKind;
using Needs = OptionNeeds;
using Stage = OptionStage;
using Where = std::string_view;

constexpr std::array kUpWords{OptionWord<UpAxis>{"y", UpAxis::Y},
                              OptionWord<UpAxis>{"z", UpAxis::Z}};
constexpr std::array kAssetWords{OptionWord<AssetChoice>{"keep", AssetChoice::Keep},
                                 OptionWord<AssetChoice>{"merge", AssetChoice::Merge}};
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
                    .help = "figures of each vertex, written into glTF, PLY and USD",
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
  return {
      {.name = "bake",
       .stage = Stage::Output,
       .kind = Kind::Whole,
       .limits = {.least = kLeastBakeSize, .most = kMostBakeSize},
       .choices = "N",
       .example = "1024",
       .help = "glTF: the input's own mesh with normal textures of N x N texels, by its texture "
               "coordinates, with which it looks as the surface does",
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
           .help = "auto: the CPU; vulkan: the best Vulkan device; see planish devices",
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
       .help = "hide gaps between 3D Tiles of different levels behind strips along their edges"},
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
           .help = "quad splits, 0 to 6; several write NAME_LOD0.glb, ...; 3D Tiles have 1 to it; "
                   "auto: 2, dense meshes 1",
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
           .help = "instead of levels: triangles within so much of the surface, relative to the "
                   "diagonal; several write NAME_LOD0.glb, ...",
           .flag = "--chord-error",
           .entry = "chord error",
           .ranks = {"", kTilesHaveLevels}},
          [](FitSettings& settings, const OptionValue& value, Where) {
            settings.adaptive.chord_errors = value.numbers;
          },
          {}};
}

}  // namespace

std::vector<FitOption> file_options() {
  return {
      word_option({.name = "up",
                   .stage = Stage::Output,
                   .initial = "y",
                   .help = "z turns a Z-up input upright for glTF, and is told to USD"},
                  kUpWords, &FitSettings::up),
      attributes_option(),
      word_option({.name = "asset",
                   .stage = Stage::Output,
                   .initial = "keep",
                   .help = "a glTF that becomes a glTF: each mesh by itself, nodes, materials, "
                           "textures, skins and animations as they are; or the scene as one mesh"},
                  kAssetWords, &FitSettings::asset),
      word_option({.name = "lods",
                   .stage = Stage::Output,
                   .initial = "files",
                   .help = "several levels are a file each, or levels of detail of a glTF that "
                           "becomes a glTF, in one file (MSFT_lod)"},
                  kLodWords, &FitSettings::lods),
      word_option({.name = "textures",
                   .stage = Stage::Input,
                   .initial = "beside",
                   .help = "textures, materials and buffers that the input names: those in its "
                           "folder or below, or anywhere",
                   .ranks = {"beside", "ranks read no textures; take beside"}},
                  kReachWords, &FitSettings::textures),
      word_option({.name = "compress",
                   .stage = Stage::Output,
                   .initial = "none",
                   .help = "smaller glTF within the tolerance: quantize has 16-bit numbers, "
                           "meshopt packs them too, for readers such as three.js and Babylon.js "
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
                    .help = "about so many has each file of 3D Tiles"},
                   &FitSettings::tile_vertices),
      skirts_option(),
  };
}

std::vector<FitOption> step_options() {
  std::vector<FitOption> rows{
      word_option({.name = "step_unit",
                   .initial = "auto",
                   .help = "STEP: what the coordinates are in, which stay as they are; auto: "
                           "metres of a glTF, else mm"},
                  kStepUnitWords, &FitSettings::step, &StepSettings::unit),
      number_option({.name = "step_angle",
                     .limits = {.least = 0,
                                .most = kMostBrepAngle,
                                .above_least = true,
                                .wanted = "above 0 to 90 degrees are wanted"},
                     .choices = "DEGREES",
                     .initial = "0.25",
                     .help = "STEP: most degrees by which normals jump where faces meet"},
                    &FitSettings::step, &StepSettings::faces, &BrepOptions::angle),
      number_option({.name = "step_tolerance",
                     .limits = {.least = 0,
                                .most = 1,
                                .above_least = true,
                                .wanted = "a fraction of the bounding-box diagonal above 0 and up "
                                          "to 1 is wanted, such as 1e-6"},
                     .choices = "T",
                     .initial = "1e-6",
                     .help = "STEP: most that faces leave the surface, of the diagonal"},
                    &FitSettings::step, &StepSettings::faces, &BrepOptions::deviation),
      whole_option({.name = "step_face_size",
                    .limits = {.least = 1, .most = kMostFaceSize},
                    .choices = "N",
                    .initial = "16",
                    .help = "STEP: most quads along a face, of which one of the mesh has two; "
                            "programs measure long faces badly"},
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
  return {levels_option(), chord_errors_option(),
          number_option({.name = "angle",
                         .stage = Stage::Fineness,
                         .needs = Needs::Fineness,
                         .limits = {.least = 0,
                                    .most = 180,
                                    .above_least = true,
                                    .wanted = "above 0 to 180 degrees are wanted"},
                         .choices = "DEGREES",
                         .example = "10",
                         .help = "instead of levels, or besides --chord-error: most degrees that "
                                 "the surface turns beneath a triangle",
                         .ranks = {"", kTilesHaveLevels}},
                        &FitSettings::adaptive, &AdaptiveChoice::angle)};
}

}  // namespace planish
