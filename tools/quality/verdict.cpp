#include "quality/verdict.h"

#include <cstdio>

#include "planish/core/assert.h"
#include "planish/mesh/statistics.h"

namespace planish::quality {

namespace {

constexpr double kFoldedArea = 1e-5;
constexpr double kScanShare = 0.5;
constexpr double kInterpolation = 1e-6;
// Equal to the two digits that the table shows.
constexpr double kEqual = 1.02;

}  // namespace

std::string shortfall(const Case& what, const char* figure, double value, double limit) {
  char text[200];
  std::snprintf(text, sizeof text, "%s: %s %.3g, aim %.3g", what.name.c_str(), figure, value,
                limit);
  return text;
}

std::vector<std::string> shortfalls(const Case& what, const std::vector<Figures>& figures) {
  PLANISH_ASSERT(figures.size() == methods().size());
  const Figures& progressive = figures[2];
  const Figures& fair = figures.back();
  std::vector<std::string> lines;
  const auto require = [&](const char* figure, double value, double limit) {
    if (!(value <= limit)) lines.push_back(shortfall(what, figure, value, limit));
  };
  if (statistics(what.mesh).boundary_loop_count == 0) {
    require("folded area", fair.folded_area, kFoldedArea);
  }
  require("rms normal deviation", fair.rms_normal,
          progressive.rms_normal * (what.is_scan ? kScanShare : kEqual));
  require("interpolation error", fair.interpolation_error, kInterpolation);
  return lines;
}

}  // namespace planish::quality
