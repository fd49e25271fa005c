#include "options/settings.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "options/nearest.h"
#include "options/refuse.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/mesh/detect_creases.h"
#include "planish/mesh/weld_vertices.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/make_ready.h"
#include "planish/pipeline/option_words.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

template <class Value>
using Word = OptionWord<Value>;

constexpr std::array kPrecisions{Word<PrecisionChoice>{"auto", PrecisionChoice::Auto},
                                 Word<PrecisionChoice>{"float", PrecisionChoice::Float},
                                 Word<PrecisionChoice>{"double", PrecisionChoice::Double}};
constexpr std::array kUpAxes{Word<UpAxis>{"y", UpAxis::Y}, Word<UpAxis>{"z", UpAxis::Z}};
constexpr std::array kRepairs{Word<RepairChoice>{"safe", RepairChoice::Safe},
                              Word<RepairChoice>{"none", RepairChoice::None}};
constexpr std::array kCreases{Word<bool>{"use", true}, Word<bool>{"ignore", false}};
constexpr std::array kInterpolations{
    Word<InterpolationChoice>{"auto", InterpolationChoice::Auto},
    Word<InterpolationChoice>{"progressive", InterpolationChoice::Progressive},
    Word<InterpolationChoice>{"fair", InterpolationChoice::Fair}};
constexpr std::array kCompressions{Word<GltfCompression>{"none", GltfCompression::None},
                                   Word<GltfCompression>{"quantize", GltfCompression::Quantize},
                                   Word<GltfCompression>{"meshopt", GltfCompression::Meshopt}};
constexpr std::array kPresets{Word<bool>{"paper", true}};

constexpr std::string_view kWeldWanted =
    "0, or a fraction of the bounding-box diagonal from 1e-12 to less than 0.1, is wanted, such as "
    "1e-6";
constexpr std::string_view kToleranceWanted =
    "a fraction of the bounding-box diagonal above 0 and up to 1 is wanted, such as 1e-6";

template <class Words>
auto parse(const Words& words, std::string_view value, std::string_view where) {
  std::vector<std::string_view> texts;
  std::string allowed;
  for (const auto& word : words) {
    if (word.text == value) return word.value;
    texts.push_back(word.text);
    allowed += (allowed.empty() ? "" : ", ") + std::string(word.text);
  }
  refuse(where, "\"" + visible(value) + "\" is not one of " + allowed + did_you_mean(value, texts));
}

void set_preset(Settings& settings, std::string_view value, std::string_view where) {
  parse(kPresets, value, where);
  settings.interpolation = InterpolationChoice::Progressive;
  settings.weights = Weights::Averaged;
  settings.solver = Solver::Plain;
}

// A list of words, each switching one on.
void set_attributes(Settings& settings, std::string_view value, std::string_view where) {
  constexpr std::array kAttributes{Word<bool FieldChoice::*>{"error", &FieldChoice::error},
                                   Word<bool FieldChoice::*>{"deviation", &FieldChoice::deviation},
                                   Word<bool FieldChoice::*>{"fold", &FieldChoice::fold},
                                   Word<bool FieldChoice::*>{"curvature", &FieldChoice::curvature}};
  settings.attributes = {};
  while (true) {
    const std::size_t comma = value.find(',');
    settings.attributes.*parse(kAttributes, value.substr(0, comma), where) = true;
    if (comma == std::string_view::npos) return;
    value.remove_prefix(comma + 1);
  }
}

constexpr std::array kWordSettings{
    WordSetting{"preset", "paper", "", "averaged weights and the plain iteration, as published",
                true, set_preset},
    WordSetting{"weights", "doo-sabin|averaged", "doo-sabin",
                "subdivision weights: Doo & Sabin 1978, or the paper's averages", true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.weights = parse_weights(value, where);
                }},
    WordSetting{
        "interpolation", "auto|progressive|fair", "auto",
        "progressive: as in the paper; fair: without folds on uneven meshes; auto: the better of "
        "both by measurement, fair for points, progressive for --cage",
        true,
        [](Settings& s, std::string_view value, std::string_view where) {
          s.interpolation = parse(kInterpolations, value, where);
        }},
    WordSetting{"solver", "chebyshev|plain|cg", "chebyshev",
                "chebyshev; plain as in the paper; cg for closed smooth meshes", true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.solver = parse(kSolverWords, value, where);
                }},
    WordSetting{"precision", "auto|float|double", "auto",
                "of the solve on the CPU; auto takes double for tolerances below 1e-8", true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.precision = parse(kPrecisions, value, where);
                }},
    WordSetting{"boundary", "edge|edge-and-corner", "edge",
                "open boundaries are smooth curves, or have corners where one face meets them",
                true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.boundary = parse_boundary(value, where);
                }},
    WordSetting{"creases", "use|ignore|normals|auto[:DEGREES]", "use",
                "sharp edges: tagged ones, none, split normals too, or turns above (30) too", true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.creases = parse_creases(value, where);
                }},
    WordSetting{"repair", "safe|none", "safe",
                "safe mends winding, non-manifold and degenerate parts, and cuts concave faces for "
                "fair surfaces; none leaves them and refuses what cannot be used",
                true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.repair = parse_repair(value, where);
                }},
    WordSetting{"scheme", "doo-sabin|catmull-clark|loop", "doo-sabin",
                "subdivision scheme; catmull-clark and loop as OpenSubdiv has them", true,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.scheme = parse_scheme(value, where);
                }},
    WordSetting{"up", "y|z", "y", "z turns a Z-up input upright for glTF, and is told to USD",
                false,
                [](Settings& s, std::string_view value, std::string_view where) {
                  s.up = parse(kUpAxes, value, where);
                }},
    WordSetting{"attributes", "error,deviation,fold,curvature", "",
                "figures of each vertex, written into glTF, PLY and USD", false, set_attributes},
    WordSetting{
        "compress", "none|quantize|meshopt", "none",
        "smaller glTF within the tolerance: quantize has 16-bit numbers, meshopt packs them "
        "too, for readers such as three.js and Babylon.js (Blender 3.4 has none)",
        false,
        [](Settings& s, std::string_view value, std::string_view where) {
          s.compression = parse(kCompressions, value, where);
        }},
    WordSetting{"device", "auto|cpu|vulkan|INDEX|NAME|UUID", "auto",
                "auto: a hardware Vulkan device, else the CPU; see planish devices", false,
                [](Settings& s, std::string_view value, std::string_view where) {
                  if (value.empty()) refuse(where, "is empty; planish devices lists what there is");
                  s.device = value;
                }},
};

double number_in(std::string_view text, std::string_view wanted, std::string_view where) {
  double value = 0;
  if (!parse_number(text, value))
    refuse(where, "\"" + visible(text) + "\" is no number; " + std::string(wanted));
  return value;
}

}  // namespace

FitOptions fit_options(const Settings& settings, InterpolationMethod method) {
  FitOptions options;
  options.method = method;
  options.polish_steps = settings.polish_steps;
  options.scheme = settings.scheme;
  options.weights = settings.weights;
  options.solver = settings.solver;
  options.tolerance = settings.tolerance;
  options.max_iterations = settings.max_iterations;
  options.sharp = settings.sharp();
  return options;
}

std::span<const WordSetting> word_settings() { return kWordSettings; }

Scheme parse_scheme(std::string_view value, std::string_view where) {
  return parse(kSchemeWords, value, where);
}

Weights parse_weights(std::string_view value, std::string_view where) {
  return parse(kWeightsWords, value, where);
}

InterpolationMethod parse_method(std::string_view value, std::string_view where) {
  return parse(kMethodWords, value, where);
}

BoundaryRule parse_boundary(std::string_view value, std::string_view where) {
  return parse(kBoundaryWords, value, where);
}

CreaseChoice parse_creases(std::string_view value, std::string_view where) {
  if (value == "auto") return {true, CreaseDetectionOptions{}.dihedral_degrees};
  if (value == "normals") return {.split_normals = true};
  double angle = 0;
  if (parse_number(value, angle)) {
    refuse(where, "\"" + visible(value) +
                      "\" is not one of use, ignore, normals, auto:DEGREES; did you mean auto:" +
                      visible(value) + "?");
  }
  if (!value.starts_with("auto:")) {
    for (const auto& word : kCreases)
      if (word.text == value) return {word.value, std::nullopt};
    constexpr std::array<std::string_view, 4> kKnown{"use", "ignore", "normals", "auto"};
    refuse(where, "\"" + visible(value) + "\" is not one of use, ignore, normals, auto:DEGREES" +
                      did_you_mean(value, kKnown));
  }
  const std::string_view digits = value.substr(5);
  double degrees = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), degrees);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  if (!whole || !(degrees >= 0 && degrees <= 180)) {
    refuse(where, "\"" + visible(digits) + "\" is no angle of 0 to 180 degrees");
  }
  return {true, degrees};
}

RepairChoice parse_repair(std::string_view value, std::string_view where) {
  return parse(kRepairs, value, where);
}

void set_tolerance(Settings& settings, double value, std::string_view where) {
  if (!(value > 0 && value <= 1)) {
    refuse(where, short_number(value) + " is out of range; " + std::string(kToleranceWanted));
  }
  settings.tolerance = value;
}

void set_tolerance(Settings& settings, std::string_view text, std::string_view where) {
  set_tolerance(settings, number_in(text, kToleranceWanted, where), where);
}

void set_weld(Settings& settings, double value, std::string_view where) {
  if (!can_weld_within(value))
    refuse(where, short_number(value) + " is out of range; " + std::string(kWeldWanted));
  settings.weld = value;
}

void set_weld(Settings& settings, std::string_view text, std::string_view where) {
  set_weld(settings, number_in(text, kWeldWanted, where), where);
}

std::int64_t parse_whole(std::string_view text, std::string_view where) {
  std::int64_t value = 0;
  if (!parse_integer(text, value)) refuse(where, "\"" + visible(text) + "\" is no whole number");
  return value;
}

void set_max_iterations(Settings& settings, std::int64_t value, std::string_view where) {
  constexpr std::int64_t kMost = 1'000'000;  // no solve that converges at all needs as many
  if (value < 0 || value > kMost) {
    refuse(where, std::to_string(value) + " is out of range; 0 to 1000000 is wanted");
  }
  settings.max_iterations = static_cast<std::int32_t>(value);
}

void set_polish_steps(Settings& settings, std::int64_t value, std::string_view where) {
  constexpr std::int64_t kMost = 1'000;  // quality is settled by ten
  if (value < 0 || value > kMost) {
    refuse(where, std::to_string(value) + " is out of range; 0 to 1000 is wanted");
  }
  settings.polish_steps = static_cast<std::int32_t>(value);
}

void set_tile_vertices(Settings& settings, std::int64_t value, std::string_view where) {
  constexpr std::int64_t kMost = std::int64_t{1} << 24;  // what viewers load at once
  if (value < kLeastTileVertices || value > kMost) {
    refuse(where, std::to_string(value) + " is out of range; " +
                      std::to_string(kLeastTileVertices) + " to " + std::to_string(kMost) +
                      " is wanted");
  }
  settings.tile_vertices = value;
}

std::vector<int> checked_levels(std::span<const std::int64_t> values, std::string_view where) {
  std::vector<int> levels;
  for (const std::int64_t value : values) {
    if (value < 0 || value > kMaxLevel) {
      refuse(where, std::to_string(value) + " is out of range; levels are 0 to " +
                        std::to_string(kMaxLevel));
    }
    if (std::ranges::find(levels, value) != levels.end()) {
      refuse(where, "level " + std::to_string(value) + " is named twice");
    }
    levels.push_back(static_cast<int>(value));
  }
  if (levels.empty()) refuse(where, "no level is named; 2 is a good one");
  return levels;
}

std::vector<double> checked_chord_errors(std::span<const double> values, std::string_view where) {
  std::vector<double> errors;
  for (const double value : values) {
    if (!(value > 0 && value <= 1)) {
      refuse(where, short_number(value) +
                        " is out of range; parts of the diagonal above 0 to 1 are wanted, such as "
                        "0.001");
    }
    if (std::ranges::find(errors, value) != errors.end())
      refuse(where, short_number(value) + " is named twice");
    errors.push_back(value);
  }
  if (errors.empty()) refuse(where, "no chord error is named; 0.001 is a good one");
  return errors;
}

double checked_angle(double value, std::string_view where) {
  if (value > 0 && value <= 180) return value;
  refuse(where, short_number(value) + " is out of range; above 0 to 180 degrees are wanted");
}

std::vector<double> parse_numbers(std::string_view text, std::string_view where) {
  std::vector<double> values;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    double value = 0;
    if (!parse_number(text.substr(at, end - at), value))
      refuse(where, "\"" + visible(text) + "\" is no number or list such as 0.01,0.001");
    values.push_back(value);
    at = end + 1;
  }
  return values;
}

void check_consistent(const Settings& settings) {
  if (settings.device == "vulkan" && settings.precision != PrecisionChoice::Auto) {
    refuse("--precision", std::string(word_of(kPrecisions, settings.precision)) +
                              " is for the CPU backend; leave it out with --device vulkan, or take "
                              "--device cpu");
  }
  if (settings.adaptive.any() && settings.attributes.any()) {
    refuse("--attributes",
           "fields are made on levels; take --levels instead of --chord-error and --angle");
  }
  if (settings.scheme == Scheme::DooSabin) return;
  if (settings.adaptive.any()) {
    refuse(settings.adaptive.chord_errors.empty() ? "--angle" : "--chord-error",
           std::string(name_of(settings.scheme)) +
               " surfaces come in levels; take --levels, or --scheme doo-sabin");
  }
  const std::string scheme(name_of(settings.scheme));
  if (settings.weights != Weights::DooSabin) {
    refuse("--weights", std::string(name_of(settings.weights)) +
                            " belongs to --scheme doo-sabin; leave it and --preset paper out with "
                            "--scheme " +
                            scheme);
  }
  if (settings.interpolation == InterpolationChoice::Fair) {
    refuse("--interpolation", "fair builds control points of Doo-Sabin's level 1, which " + scheme +
                                  " does not have; take progressive, or --scheme doo-sabin");
  }
}

std::string subdivision_text(Scheme scheme, Weights weights) {
  return scheme == Scheme::DooSabin ? std::string(name_of(weights)) + " weights"
                                    : std::string(name_of(scheme));
}

Precision solve_precision(const Settings& settings) {
  switch (settings.precision) {
    case PrecisionChoice::Float:
      return Precision::Float;
    case PrecisionChoice::Double:
      return Precision::Double;
    case PrecisionChoice::Auto:
      break;
  }
  return precision_for(settings.tolerance);
}

std::string_view name_of(Scheme scheme) { return word_of(kSchemeWords, scheme); }
std::string_view name_of(Weights weights) { return word_of(kWeightsWords, weights); }
std::string_view name_of(InterpolationMethod method) { return word_of(kMethodWords, method); }
std::string_view name_of(Solver solver) { return word_of(kSolverWords, solver); }
std::string_view name_of(BoundaryRule boundary) { return word_of(kBoundaryWords, boundary); }
std::string_view name_of(RepairChoice repair) { return word_of(kRepairs, repair); }
std::string_view name_of(GltfCompression compression) {
  return word_of(kCompressions, compression);
}

std::string name_of(const CreaseChoice& creases) {
  if (creases.split_normals) return "normals";
  return creases_text(creases.use_tags, creases.dihedral_degrees);
}

}  // namespace planish::command
