#include "planish/job/page/page_plot.h"
#include "planish/core/counted.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/job/page/page_text.h"
#include "planish/job/text.h"

namespace planish {
namespace {

using Json = nlohmann::ordered_json;

// The plot's box in the units of its view box.
constexpr double kWidth = 460, kHeight = 230, kLeft = 58, kRight = 12, kTop = 10, kBottom = 36;
constexpr double kBarHeight = 22;

std::string at(double coordinate) {
  std::string text = fixed(coordinate, 1);
  if (text.ends_with(".0")) text.resize(text.size() - 2);
  return text;
}

// From iterations and errors to places.
struct Axes {
  int low = 0, high = 1;  // powers of ten
  double last = 1;        // iteration

  [[nodiscard]] double x(double iteration) const {
    return kLeft + (kWidth - kLeft - kRight) * iteration / last;
  }
  [[nodiscard]] double y(double error) const {
    const double power = std::log10(std::max(error, std::pow(10.0, low)));
    return kTop + (kHeight - kTop - kBottom) * (high - power) / (high - low);
  }
};

Axes axes_for(const Json& history, double tolerance) {
  double least = tolerance, most = tolerance;
  for (const Json& entry : history) {
    for (const char* key : {"max", "rms"}) {
      if (!entry[key].is_number() || entry[key].get<double>() <= 0) continue;
      least = std::min(least, entry[key].get<double>());
      most = std::max(most, entry[key].get<double>());
    }
  }
  Axes axes;
  axes.low = static_cast<int>(std::floor(std::log10(least)));
  axes.high = std::max(axes.low + 1, static_cast<int>(std::ceil(std::log10(most))));
  axes.last = std::max(1.0, static_cast<double>(history.size()) - 1);
  return axes;
}

// As figure() writes small numbers: 1e-06.
std::string power_text(int power) {
  const std::string digits = std::to_string(std::abs(power));
  return std::string("1e") + (power < 0 ? "-" : "+") + (digits.size() < 2 ? "0" : "") + digits;
}

std::string grid(const Axes& axes) {
  std::string svg;
  const int step = (axes.high - axes.low + 7) / 8;
  for (int power = axes.low; power <= axes.high; power += step) {
    const double y = axes.y(std::pow(10.0, power));
    svg += "<line class=\"grid\" x1=\"" + at(kLeft) + "\" x2=\"" + at(kWidth - kRight) +
           "\" y1=\"" + at(y) + "\" y2=\"" + at(y) + "\"/><text x=\"" + at(kLeft - 6) + "\" y=\"" +
           at(y + 4) + "\" text-anchor=\"end\">" + power_text(power) + "</text>";
  }
  const int last = static_cast<int>(axes.last);
  for (int i = 0; i <= last; i += (last + 9) / 10) {
    svg += formatted("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", at(axes.x(i)),
                     at(kHeight - kBottom + 16), i);
  }
  return formatted("{}<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">iteration</text>", svg,
                   at((kLeft + kWidth - kRight) / 2), at(kHeight - 4));
}

std::string tolerance_line(const Axes& axes, double tolerance) {
  const double y = axes.y(tolerance);
  return "<line class=\"tolerance\" x1=\"" + at(kLeft) + "\" x2=\"" + at(kWidth - kRight) +
         "\" y1=\"" + at(y) + "\" y2=\"" + at(y) + "\"/><text class=\"tolerance\" x=\"" +
         at(kLeft + 4) + "\" y=\"" + at(y - 5) + "\">tolerance " + html_text(figure(tolerance)) +
         "</text>";
}

// Marks differ by shape as well as by colour: discs for the largest, squares for rms.
std::string mark(const char* key, double x, double y) {
  if (std::string_view(key) == "max")
    return formatted("<circle class=\"max\" cx=\"{}\" cy=\"{}\" r=\"3.5\">", at(x), at(y));
  return formatted("<rect class=\"rms\" x=\"{}\" y=\"{}\" width=\"6\" height=\"6\">", at(x - 3),
                   at(y - 3));
}

std::string curve(const Json& history, const char* key, const Axes& axes) {
  std::string line, marks;
  for (std::size_t i = 0; i < history.size(); ++i) {
    if (!history[i][key].is_number()) continue;
    const double x = axes.x(static_cast<double>(i)), y = axes.y(history[i][key].get<double>());
    line += (line.empty() ? "" : " ") + at(x) + "," + at(y);
    marks +=
        formatted("{}<title>iteration {}: {} {}</title></{}", mark(key, x, y), i, key,
                  figure(history[i][key]), std::string_view(key) == "max" ? "circle>" : "rect>");
  }
  return formatted("<polyline class=\"{}\" points=\"{}\"/>{}", key, line, marks);
}

std::string table(const Json& history) {
  std::string html =
      "<details><summary>As a table</summary><table><thead><tr><th scope=\"col\">iteration"
      "<th scope=\"col\">max<th scope=\"col\">rms<tbody>";
  for (std::size_t i = 0; i < history.size(); ++i) {
    html += formatted("<tr><td>{}<td>{}<td>{}", i, figure(history[i]["max"]),
                      figure(history[i]["rms"]));
  }
  return html + "</table></details>";
}

}  // namespace

std::string convergence_plot(const Json& solve, const std::string& id) {
  const Json& history = solve["history"];
  const double tolerance = solve["tolerance"].get<double>();
  const Axes axes = axes_for(history, tolerance);
  std::string svg = formatted(
      "<svg class=\"plot\" viewBox=\"0 0 460 230\" role=\"img\" aria-labelledby=\"{}t {}d\"><title "
      "id=\"{}t\">Error by iteration</title><desc id=\"{}d\">From {} to {} of the diagonal in {}; "
      "the tolerance is {}.</desc>",
      id, id, id, id, figure(history.front()["max"]), figure(history.back()["max"]),
      counted(std::ssize(history) - 1, "iteration"), figure(tolerance));
  svg += grid(axes) + tolerance_line(axes, tolerance) + curve(history, "max", axes) +
         curve(history, "rms", axes) + "</svg>";
  return svg +
         "<p class=\"legend\"><span class=\"max\">\u25cf</span> largest, <span class=\"rms\">"
         "\u25a0</span> rms; fractions of the diagonal</p>" +
         table(history);
}

std::string timing_bar(const Json& timing, const std::string& id) {
  double sum = 0;
  for (const auto& [step, milliseconds] : timing.items()) {
    if (step != "total") sum += milliseconds.get<double>();
  }
  if (!(sum > 0)) return "";
  std::string bar, list, words;
  double x = 0;
  for (const auto& [step, value] : timing.items()) {
    const double milliseconds = value.get<double>();
    if (step == "total" || !(milliseconds > 0)) continue;
    const double width = kWidth * milliseconds / sum;
    const std::string text = step + " " + duration(milliseconds);
    const std::string rectangle = "<rect class=\"t-" + step + "\"";  // its colour is page.css's
    bar += rectangle;
    bar += formatted(" x=\"{}\" width=\"{}\" height=\"22\"><title>", fixed(x, 2), fixed(width, 2));
    bar += text + "</title></rect>";
    list += "<li><svg class=\"swatch\" viewBox=\"0 0 9 9\" aria-hidden=\"true\">" + rectangle;
    list += " width=\"9\" height=\"9\"/></svg> " + text;
    words += (words.empty() ? "" : ", ") + text;
    x += width;
  }
  return formatted(
      "<svg class=\"bar\" viewBox=\"0 0 460 {}\" role=\"img\" aria-labelledby=\"{}b\"><title "
      "id=\"{}b\">Time: {}</title>{}</svg><ul class=\"steps\">{}</ul><p>{} all together.</p>",
      at(kBarHeight), id, id, words, bar, list, duration(timing["total"].get<double>()));
}

}  // namespace planish
