#include "options/point_settings.h"

#include <algorithm>
#include <array>
#include <vector>

#include "options/nearest.h"
#include "options/refuse.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

std::string shown(std::string_view value) { return "\"" + visible(value) + "\""; }

std::size_t choose(std::string_view value, std::string_view where,
                   const std::vector<std::string_view>& words) {
  const auto found = std::ranges::find(words, value);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  std::string allowed;
  for (const std::string_view word : words)
    allowed += (allowed.empty() ? "" : ", ") + std::string(word);
  refuse(where, shown(value) + " is not one of " + allowed + did_you_mean(value, words));
}

std::int64_t whole(std::string_view value, std::string_view where, std::int64_t least,
                   std::int64_t most) {
  std::int64_t number = 0;
  if (!parse_integer(value, number) || number < least || number > most)
    refuse(where, shown(value) + " is no whole number from " + std::to_string(least) + " to " +
                      std::to_string(most));
  return number;
}

double real(std::string_view value, std::string_view where, double least, double most) {
  double number = 0;
  if (!parse_number(value, number) || number < least || number > most)
    refuse(where, shown(value) + " is no number from " + short_number(least) + " to " +
                      short_number(most));
  return number;
}

void set_outliers(ReconstructOptions& options, std::string_view value, std::string_view where) {
  const std::size_t comma = value.find(',');
  if (comma == std::string_view::npos) {
    const std::size_t word = choose(value, where, {"off", "auto", "K,FACTOR"});
    if (word == 2) refuse(where, "numbers are wanted for K and FACTOR, such as 12,2");
    options.clean.outliers = word == 0 ? OutlierRule::Off : OutlierRule::Auto;
    return;
  }
  options.clean.outliers = OutlierRule::Distance;
  options.clean.neighbour_count =
      static_cast<std::int32_t>(whole(value.substr(0, comma), where, 1, 100));
  options.clean.factor = real(value.substr(comma + 1), where, 0.1, 1e6);
}

void set_components(ReconstructOptions& options, std::string_view value, std::string_view where) {
  using Keep = ComponentRule::Keep;
  if (value == "largest") {
    options.components = {Keep::Largest, 0};
  } else if (value == "all") {
    options.components = {Keep::All, 0};
  } else {
    std::int64_t least = 0;
    if (!parse_integer(value, least) || least < 1)
      refuse(where, shown(value) + " is neither largest, all nor a least number of faces");
    options.components = {Keep::AtLeast, least};
  }
}

using View = std::string_view;

constexpr std::array kSettings{
    PointSetting{"tolerance_mesh", "T", "1e-4",
                 "farthest that a point may lie from the mesh, of the diagonal; 0 keeps all points",
                 true,
                 [](ReconstructOptions& o, View value, View where) {
                   o.tolerance = real(value, where, 0, 1);
                 }},
    PointSetting{"target_vertices", "N", "", "stop simplifying at so many vertices", true,
                 [](ReconstructOptions& o, View value, View where) {
                   o.target_vertices = whole(value, where, 1, INT32_MAX);
                 }},
    PointSetting{"spacing", "adaptive|even", "adaptive",
                 "adaptive: fewest vertices; even: neighbouring edges of like length, fewer folds",
                 false,
                 [](ReconstructOptions& o, View value, View where) {
                   o.spacing = choose(value, where, {"adaptive", "even"}) == 0 ? Spacing::Adaptive
                                                                               : Spacing::Even;
                 }},
    PointSetting{
        "outliers", "off|auto|K,FACTOR", "auto",
        "remove points whose mean distance to K neighbours exceeds FACTOR medians; auto is "
        "12,2 unless the cloud is uneven",
        false, set_outliers},
    PointSetting{"smooth", "N", "0", "move points onto local quadratic fits, N times", true,
                 [](ReconstructOptions& o, View value, View where) {
                   o.smooth_rounds = static_cast<std::int32_t>(whole(value, where, 0, 100));
                 }},
    PointSetting{"noise", "auto|off", "auto", "measure noise, and warn where smoothing would help",
                 false,
                 [](ReconstructOptions& o, View value, View where) {
                   o.measure_noise = choose(value, where, {"auto", "off"}) == 0;
                 }},
    PointSetting{"fill_holes", "N", "16", "longest boundary loop that is closed, in edges", true,
                 [](ReconstructOptions& o, View value, View where) {
                   o.longest_filled_loop = static_cast<std::int32_t>(whole(value, where, 0, 1000));
                 }},
    PointSetting{"components", "largest|all|MIN_FACES", "largest", "which parts to keep", true,
                 set_components},
    PointSetting{"quads", "on|off", "on", "join triangles to quads", false,
                 [](ReconstructOptions& o, View value, View where) {
                   o.pair_quads = choose(value, where, {"on", "off"}) == 0;
                 }},
    PointSetting{"min_angle", "DEGREES", "", "of the simplified mesh's triangles, 0 to 45", true,
                 [](ReconstructOptions& o, View value, View where) {
                   o.least_angle = real(value, where, 0, 45);
                 }},
    PointSetting{"max_valence", "N", "", "of the simplified mesh's vertices, 6 and more", true,
                 [](ReconstructOptions& o, View value, View where) {
                   o.max_valence = static_cast<std::int32_t>(whole(value, where, 6, 1000));
                 }},
};

}  // namespace

std::span<const PointSetting> point_settings() { return kSettings; }

std::string flag_of(std::string_view setting) {
  std::string flag = "--" + std::string(setting);
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

}  // namespace planish::command
