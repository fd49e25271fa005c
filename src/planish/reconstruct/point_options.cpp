#include "planish/reconstruct/point_options.h"

#include <cstdint>
#include <limits>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"

namespace planish {
namespace {

using Kind = OptionKind;
using Where = std::string_view;

// "12,2"
void set_distance_rule(CleanOptions& clean, std::string_view text, Where where) {
  const std::size_t comma = text.find(',');
  std::int64_t count = 0;
  double factor = 0;
  const bool is_count = parse_integer(text.substr(0, comma), count);
  if (!is_count || count < 1 || count > 100)
    refuse(where, in_double_quotes(text.substr(0, comma)) + " is no whole number from 1 to 100");
  const std::string_view rest = text.substr(comma + 1);
  if (!parse_number(rest, factor) || factor < 0.1 || factor > 1e6)
    refuse(where, in_double_quotes(rest) + " is no number from 0.1 to 1e+06");
  clean.outliers = OutlierRule::Distance;
  clean.neighbour_count = static_cast<std::int32_t>(count);
  clean.factor = factor;
}

void set_outliers(ReconstructOptions& options, const OptionValue& value, Where where) {
  constexpr std::string_view kKnown[] = {"off", "auto"};
  if (value.text == "off" || value.text == "auto") {
    options.clean.outliers = value.text == "off" ? OutlierRule::Off : OutlierRule::Auto;
  } else if (value.text == "K,FACTOR") {
    refuse(where, "numbers are wanted for K and FACTOR, such as 12,2");
  } else if (value.text.find(',') == std::string_view::npos) {
    refuse(where, in_double_quotes(value.text) + " is not one of off, auto, K,FACTOR" +
                      did_you_mean(value.text, kKnown));
  } else {
    set_distance_rule(options.clean, value.text, where);
  }
}

void set_components(ReconstructOptions& options, const OptionValue& value, Where where) {
  using Keep = ComponentRule::Keep;
  std::int64_t least = 0;
  if (value.text == "auto") {
    options.components = {Keep::Auto, 0};
  } else if (value.text == "largest") {
    options.components = {Keep::Largest, 0};
  } else if (value.text == "all") {
    options.components = {Keep::All, 0};
  } else if (parse_integer(value.text, least) && least >= 1) {
    options.components = {Keep::AtLeast, least};
  } else {
    refuse(where, in_double_quotes(value.text) +
                      " is neither auto, largest, all nor a least number of faces");
  }
}

PointOption row(OptionInfo info,
                void (*set)(ReconstructOptions&, const OptionValue&, std::string_view)) {
  return {std::move(info), set, {}};
}

template <class Member>
PointOption number_row(OptionInfo info, Member ReconstructOptions::*member) {
  info.kind = Kind::Number;
  return {std::move(info),
          [member](ReconstructOptions& options, const OptionValue& value, Where) {
            options.*member = value.number;
          },
          {}};
}

std::vector<PointOption> make_point_table() {
  using Options = ReconstructOptions;
  std::vector<PointOption> table{
      number_row({.name = "tolerance_mesh",
                  .limits = {0, 1},
                  .choices = "T",
                  .initial = "1e-4",
                  .help = "largest distance of a point from the mesh, as a fraction of the "
                          "diagonal; 0 keeps all points"},
                 &Options::tolerance),
      whole_option({.name = "target_vertices",
                    .limits = {1, std::numeric_limits<std::int32_t>::max()},
                    .choices = "N",
                    .example = "18750",
                    .help = "stop simplifying at N vertices"},
                   &Options::target_vertices),
      row({.name = "spacing",
           .words = {"adaptive", "even"},
           .initial = "adaptive",
           .help = "adaptive: fewest vertices; even: edges of like length side by side, "
                   "fewer folds"},
          [](Options& options, const OptionValue& value, Where) {
            options.spacing = value.whole == 0 ? Spacing::Adaptive : Spacing::Even;
          }),
      row({.name = "outliers",
           .kind = Kind::Text,
           .choices = "off|auto|K,FACTOR",
           .initial = "auto",
           .example = "12,2",
           .help = "remove points whose mean distance to K neighbours is more than FACTOR "
                   "times the median; auto: 12,2, but not in sparse parts of the shape, "
                   "and points off the surface around them"},
          set_outliers),
      row({.name = "smooth",
           .kind = Kind::Whole,
           .limits = {0, 100},
           .choices = "N",
           .example = "2",
           .help = "move points onto local quadratic fits, N times [0, or 1 to 4 where the "
                   "noise exceeds 1e-4 of the diagonal]"},
          [](Options& options, const OptionValue& value, Where) {
            options.smooth_rounds = static_cast<std::int32_t>(value.whole);
          }),
      row({.name = "noise",
           .words = {"auto", "off"},
           .initial = "auto",
           .help = "measure the noise, and choose smoothing and tolerance by it"},
          [](Options& options, const OptionValue& value, Where) {
            options.measure_noise = value.whole == 0;
          }),
      whole_option({.name = "fill_holes",
                    .limits = {0, 1000},
                    .choices = "N",
                    .initial = "16",
                    .help = "close holes of up to N edges"},
                   &Options::longest_filled_loop),
      row({.name = "components",
           .kind = Kind::TextOrNumber,
           .choices = "auto|largest|all|MIN_FACES",
           .initial = "auto",
           .example = "all",
           .help = "parts to keep; auto: those with at least a fiftieth of the largest "
                   "part's faces"},
          set_components),
      number_row({.name = "min_angle",
                  .limits = {0, 45},
                  .choices = "DEGREES",
                  .example = "10",
                  .help = "smallest angle of the mesh's triangles after simplifying, 0 to 45"},
                 &Options::least_angle),
      whole_option({.name = "max_valence",
                    .limits = {6, 1000},
                    .choices = "N",
                    .example = "8",
                    .help = "most edges at a vertex after simplifying, 6 and more"},
                   &Options::max_valence)};
  for (PointOption& option : table) {
    option.stage = OptionStage::Points;
    option.needs = OptionNeeds::Points;
    option.ranks = {"", "it belongs to points; make a mesh of them by planish reconstruct first"};
  }
  return table;
}

}  // namespace

const std::vector<PointOption>& point_option_table() {
  static const std::vector<PointOption> table = make_point_table();
  return table;
}

}  // namespace planish
