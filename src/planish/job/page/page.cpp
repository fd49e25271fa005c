#include "planish/job/page/page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "page_files.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/portable_math.h"
#include "planish/core/vectors.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/job/digest.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page_scene.h"
#include "planish/mesh/face_geometry.h"

namespace planish {
namespace {

template <class... Arguments>
std::string as_printed(const char* format, Arguments... arguments) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, arguments...);
  return buffer.data();
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (std::string_view("&<>\"'`").find(c) != std::string_view::npos) {
      out += "&#" + std::to_string(static_cast<int>(c)) + ";";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string visible_text(std::string_view text) {
  return with_escapes(text, [](std::uint32_t point) {
    return as_printed(point > 0xFFFF ? "\\u{%x}" : "\\u%04x", static_cast<unsigned>(point));
  });
}

std::string html_text(std::string_view text) { return escaped(visible_text(text)); }

std::string html_lines(std::string_view text) {
  std::string out;
  while (true) {
    const std::size_t end = text.find('\n');
    out += html_text(text.substr(0, end));
    if (end == std::string_view::npos) return out;
    out += '\n';
    text.remove_prefix(end + 1);
  }
}

nlohmann::ordered_json visible_json(const nlohmann::ordered_json& value) {
  if (value.is_string()) return visible_text(value.get_ref<const std::string&>());
  if (!value.is_structured()) return value;
  nlohmann::ordered_json out =
      value.is_array() ? nlohmann::ordered_json::array() : nlohmann::ordered_json::object();
  for (const auto& [key, entry] : value.items()) {
    if (value.is_array()) {
      out.push_back(visible_json(entry));
    } else {
      out[visible_text(key)] = visible_json(entry);
    }
  }
  return out;
}

std::string script_json(const nlohmann::ordered_json& value) {
  std::string out;
  for (const char c : value.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace)) {
    // Within JSON these stand in strings only.
    if (c == '<' || c == '>' || c == '&') {
      out += as_printed("\\u%04x", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out;
}

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos)
    return std::string(word);
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string figure(double number) {
  if (!std::isfinite(number)) return "not finite";
  // Three digits, as the viewer shows. Rounded first: 999.9 is 1,000.
  std::array<char, 32> digits;
  std::snprintf(digits.data(), digits.size(), "%.3g", number);
  const double rounded = std::strtod(digits.data(), nullptr);
  if (std::abs(rounded) >= 1e3 && std::abs(rounded) < 1e6)
    return with_separators(static_cast<std::int64_t>(rounded));
  return digits.data();
}

std::string figure(const nlohmann::ordered_json& number) {
  return number.is_number() ? figure(number.get<double>()) : "not finite";
}

// Pictures of a report's figures as SVG that needs no script and prints. `id` makes the names of
// their parts unlike those of other jobs.

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
    const double power = portable::log10(std::max(error, portable::pow(10.0, low)));
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
  axes.low = static_cast<int>(std::floor(portable::log10(least)));
  axes.high = std::max(axes.low + 1, static_cast<int>(std::ceil(portable::log10(most))));
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
    const double y = axes.y(portable::pow(10.0, power));
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

// Largest and rms error by iteration, on a logarithmic scale, with the tolerance; below it the
// same as a table. `solve`: of a report; its history is not empty.
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

// The steps of a run as one bar, named below it. `timing`: timing_ms of a report.
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

}  // namespace

// The parts of a page that need no script, all of them from a job's JSON report: nothing on a page
// can differ from it.

namespace {

std::string count_of(const Json& number) { return with_separators(number.get<std::int64_t>()); }

std::string text_of(const Json& text) { return text.get<std::string>(); }

std::string row(const std::string& label, const std::string& value) {
  return formatted("<tr><th scope=\"row\">{}<td>{}", html_text(label), html_text(value));
}

std::string share_text(const Json& share) {
  return share.is_number() ? percent(share.get<double>()) : "not finite";
}

std::string histogram(const Json& counts) {
  std::string text;
  for (const auto& [size, count] : counts.items())
    text += (text.empty() ? "" : ", ") + size + ": " + count_of(count);
  return text;
}

std::string method_text(const Json& solve) {
  if (solve["method"] == "fair")
    return "fair, " + counted(solve["fair"]["polish"].get<std::int64_t>(), "polish step");
  std::string text = "progressive, " + text_of(solve["scheme"]);
  if (solve["weights"].is_string()) text += " (" + text_of(solve["weights"]) + " weights)";
  return formatted("{}, {}, {}", text, text_of(solve["solver"]),
                   counted(solve["iterations"].get<std::int64_t>(), "iteration"));
}

std::string surface_rows(const Json& surface) {
  if (surface.is_null()) return "";
  const std::string reference =
      surface["reference"] == "input" ? "the input\u2019s faces" : text_of(surface["reference"]);
  std::string rows = row("folded area", share_text(surface["folded_area"]));
  rows += row("normals off " + reference + ", rms and largest",
              formatted("{}, {} degrees", figure(surface["rms_normal_deviation"]),
                        figure(surface["max_normal_deviation"])));
  rows += row("bending, of level 1", figure(surface["bending"]));
  if (const auto slide = surface.find("texture_slide"); slide != surface.end())
    rows += row("texture off the input\u2019s, rms and largest",
                formatted("{}, {} of the texture; {}, {} of the diagonal", figure((*slide)["rms"]),
                          figure((*slide)["largest"]), figure((*slide)["rms_distance"]),
                          figure((*slide)["largest_distance"])));
  for (const auto& [key, label] : {std::pair{"source_distance", "off the source"},
                                   std::pair{"distance_from_source", "source off the surface"},
                                   std::pair{"point_distance", "points off the surface"}}) {
    const std::string largest = std::string("max_") + key, rms = std::string("rms_") + key;
    if (!surface.contains(largest)) continue;
    rows += row(std::string(label) + ", rms and largest",
                figure(surface[rms]) + ", " + figure(surface[largest]) + " of the diagonal");
  }
  return rows + row("measured on level", std::to_string(surface["level"].get<int>()));
}

std::string reconstruction_rows(const Json& report) {
  if (!report.contains("reconstruction")) return "";
  const Json& made = report["reconstruction"];
  return row("points, used, outliers", count_of(made["points"]) + ", " + count_of(made["used"]) +
                                           ", " + count_of(made["outliers"])) +
         row("points off the mesh, rms and largest",
             formatted("{}, {} of the diagonal", figure(made["rms_point_distance"]),
                       figure(made["max_point_distance"])));
}

std::string figures(const Json& report) {
  const Json &input = report["input"], &solve = report["solve"], &device = report["device"];
  std::string rows = row("file", text_of(input["path"]) + " (" + text_of(input["format"]) + ")");
  rows += reconstruction_rows(report);
  rows += row("vertices, faces", count_of(input["vertices"]) + ", " + count_of(input["faces"]));
  rows += row("faces by corners", histogram(input["face_sizes"]));
  rows += row("boundary loops, parts, genus",
              formatted("{}, {}, {}", count_of(input["boundary_loops"]),
                        count_of(input["components"]), count_of(input["genus"])));
  rows += row("sharp edges, corners",
              count_of(input["sharp_edges"]) + ", " + count_of(input["corners"]));
  rows += row("method", method_text(solve));
  if (const Json choice = solve.value("choice", Json()); choice.is_object())
    for (const auto& [label, key] :
         {std::pair{"why this method", "reason"}, {"why these faces", "faces_reason"}})
      if (choice[key].is_string()) rows += row(label, text_of(choice[key]));
  if (const Json within = solve.value("within", Json()); within.is_object())
    rows += row("left by at most, rms", figure(within["allowed"]) + ", " +
                                            figure(within["distance"]["rms"]) + " of the diagonal");
  rows += row("error, rms and largest", figure(solve["error"]["rms"]) + ", " +
                                            figure(solve["error"]["max"]) + " of the diagonal");
  rows += surface_rows(report["surface"]);
  std::string name = text_of(device["kind"]) + ", " + text_of(device["name"]);
  if (!text_of(device["driver"]).empty()) name += ", " + text_of(device["driver"]);
  rows += row("device", name);
  if (report.contains("memory"))
    rows += row("memory", byte_size(report["memory"]["host_peak_bytes"].get<std::uint64_t>()));
  rows += row("planish", formatted("{} ({})", text_of(report["tool"]["version"]),
                                   text_of(report["tool"]["git"])));
  return "<h3>Figures</h3><table>" + rows + "</table>";
}

std::string convergence(const Json& report, const std::string& id) {
  std::string html = "<h3>Convergence</h3>";
  const Json& solve = report["solve"];
  html += solve["history"].empty() ? "<p>Built directly, without iterations.</p>"
                                   : convergence_plot(solve, "p" + id);
  if (report.contains("timing_ms"))
    html += "<h3>Time</h3>" + timing_bar(report["timing_ms"], "t" + id);
  return html;
}

std::string warnings(const Json& report) {
  std::string items;
  for (const Json& warning : report["warnings"]) {
    items += formatted("<li><strong>{}</strong> {}", html_text(text_of(warning["code"])),
                       html_text(text_of(warning["message"])));
  }
  return "<h3>Warnings</h3>" +
         (items.empty() ? "<p>None.</p>" : "<ul class=\"warnings\">" + items + "</ul>");
}

std::string files(const Json& report) {
  const Json& input = report["input"];
  std::string rows = formatted("<tr><td>{}<td>input<td class=\"n\">{}<td><td><code>{}</code>",
                               html_text(text_of(input["path"])), count_of(input["vertices"]),
                               html_text(text_of(input["sha256"])));
  for (const Json& output : report["outputs"]) {
    std::string what = text_of(output["what"]);
    if (output["level"].is_number()) what += formatted(", level {}", output["level"].get<int>());
    rows += formatted("<tr><td>{}<td>{}<td class=\"n\">{}<td class=\"n\">{}<td><code>{}</code>",
                      html_text(text_of(output["path"])), html_text(what),
                      count_of(output["vertices"]), byte_size(output["bytes"].get<std::uint64_t>()),
                      html_text(text_of(output["sha256"])));
  }
  return "<h3>Files</h3><div class=\"wide\"><table class=\"files\"><thead><tr><th "
         "scope=\"col\">file"
         "<th scope=\"col\">what<th scope=\"col\">vertices<th scope=\"col\">size"
         "<th scope=\"col\">SHA-256<tbody>" +
         rows + "</table></div>";
}

std::string command(const Json& report) {
  std::string line = "planish";
  for (std::size_t i = 1; i < report["argv"].size(); ++i)
    line += " " + shell_word(text_of(report["argv"][i]));
  return formatted(
      "<h3>Once more</h3><pre tabindex=\"0\">{}</pre><details><summary>The whole "
      "report</summary><pre class=\"raw\" tabindex=\"0\">{}</pre></details>",
      html_text(line), html_lines(report.dump(1, ' ', false, Json::error_handler_t::replace)));
}

std::string status_pill(const Json& solve) {
  if (solve["converged"].get<bool>()) return "<span class=\"pill good\">converged</span>";
  return "<span class=\"pill bad\">not converged: " + html_text(text_of(solve["stop_reason"])) +
         "</span>";
}

std::string opened(std::size_t number, const std::string& heading) {
  const std::string id = std::to_string(number);
  return "<section class=\"job\" id=\"job" + id + "\" aria-labelledby=\"h" + id + "\"><h2 id=\"h" +
         id + "\">" + heading + "</h2>";
}

// Report in one sentence or a few: what stands for the picture where none is seen.
std::string summary_sentence(const Json& report) {
  const Json &input = report["input"], &solve = report["solve"], &surface = report["surface"];
  const auto loops = input["boundary_loops"].get<std::int64_t>();
  const auto parts = input["components"].get<std::int64_t>();
  std::string text =
      loops == 0 ? "A closed surface" : "An open surface with " + counted(loops, "boundary loop");
  text += " of genus " + count_of(input["genus"]);
  if (parts > 1) text += " in " + counted(parts, "part");
  text += formatted(", for {} of {}. ", counted(input["vertices"].get<std::int64_t>(), "vertex"),
                    counted(input["faces"].get<std::int64_t>(), "face"));
  const std::string error = figure(solve["error"]["max"]) + " of the diagonal";
  const std::string tolerance = figure(solve["tolerance"]);
  text += solve["converged"].get<bool>()
              ? "It passes through all of them within " + error + " (tolerance " + tolerance + ")"
              : "It misses them by up to " + error + ", more than the tolerance of " + tolerance;
  const auto worst = solve["error"]["worst_vertex"].get<std::int64_t>();
  text += worst >= 0 ? formatted("; the farthest is vertex {}, counted from 0. ", worst) : ". ";
  if (surface.is_null()) return text;
  text += surface["folded_area"] == 0.0
              ? "Nothing is folded. "
              : share_text(surface["folded_area"]) + " of its area is folded. ";
  return text + "Its normals are " + figure(surface["rms_normal_deviation"]) + " degrees rms off " +
         (surface["reference"] == "input" ? "the input\u2019s faces."
                                          : text_of(surface["reference"]) + ".");
}

// Everything about one job; `number` is its place on the page. `view_note` says what the view
// shows of it, or why it has none; `still`: PageJob's.
std::string job_section(const Json& report, std::size_t number, const std::string& view_note,
                        const std::string& still = {}) {
  const std::string id = std::to_string(number);
  std::string html =
      opened(number, html_text(text_of(report["job"])) + " " + status_pill(report["solve"]));
  html += "<p class=\"summary\">" + html_text(summary_sentence(report)) + "</p>";
  if (!still.empty())
    html += formatted(
        "<img class=\"still\" width=\"{}\" height=\"{}\" alt=\"The surface of {}\" "
        "src=\"data:image/png;base64,{}\">",
        kStillWidth, kStillHeight, html_text(text_of(report["job"])), still);
  if (!view_note.empty()) html += "<p class=\"hint\">" + html_text(view_note) + "</p>";
  html += "<div class=\"cards\"><div>" + figures(report) + "</div><div>" + convergence(report, id) +
          "</div><div>" + warnings(report) + files(report) + command(report) + "</div></div>";
  return html + "</section>";
}

// The same for a job that ended with an error.
std::string failed_section(const std::string& name, const std::string& message,
                           std::size_t number) {
  return opened(number, html_text(name) + " <span class=\"pill bad\">failed</span>") +
         "<p class=\"summary\">" + html_text(message) + "</p></section>";
}

// A row of the table of all jobs.
std::string overview_row(const Json& report, std::size_t number) {
  const Json &solve = report["solve"], &surface = report["surface"];
  const std::string id = std::to_string(number);
  const auto cell = [](const std::string& text) { return "<td class=\"n\">" + html_text(text); };
  std::string html = "<tr data-job=\"" + id + "\"><th scope=\"row\"><a href=\"#job" + id + "\">" +
                     html_text(text_of(report["job"])) + "</a><td>" +
                     (solve["converged"].get<bool>() ? "converged" : "not converged");
  html += cell(count_of(report["input"]["vertices"])) + "<td>" +
          html_text(text_of(solve["method"])) + cell(count_of(solve["iterations"])) +
          cell(figure(solve["error"]["max"]));
  html += cell(surface.is_null() ? "" : share_text(surface["folded_area"])) +
          cell(surface.is_null() ? "" : figure(surface["rms_normal_deviation"]));
  if (report.contains("timing_ms"))
    html += cell(duration(report["timing_ms"]["total"].get<double>()));
  return html;
}

std::string overview(const std::string& rows, std::string_view kind, bool is_hidden,
                     bool has_times) {
  std::string heads;
  for (const std::string_view head :
       {kind, std::string_view("status"), std::string_view("vertices"), std::string_view("method"),
        std::string_view("iterations"), std::string_view("largest error"),
        std::string_view("folded"), std::string_view("normals off, degrees rms")})
    heads += formatted("<th scope=\"col\">{}", head);
  if (has_times) heads += "<th scope=\"col\">time";
  return formatted(
      "<div class=\"wide overview\" {}><table><thead><tr>{}</thead><tbody>{}</tbody></table></div>",
      is_hidden ? "hidden" : "", heads, rows);
}

std::string failed_row_html(const std::string& name, std::size_t number) {
  const std::string id = std::to_string(number);
  return "<tr data-job=\"" + id + "\"><th scope=\"row\"><a href=\"#job" + id + "\">" +
         html_text(name) + "</a><td colspan=\"8\">failed";
}

// What a job is called where it is compared with others: its name and method.
std::string job_label(const Json& report) {
  const Json& solve = report["solve"];
  std::string method = solve["method"] == "fair" ? "fair" : text_of(solve["scheme"]);
  if (method == "doo-sabin") method = "progressive";
  const std::string name = text_of(report["job"]);
  return name == method ? name : name + ", " + method;
}

// What a browser compares an inline script or style with before it takes it.
std::string csp_hash(std::string_view text) {
  return "'sha256-" + base64_text(sha256_bytes(std::as_bytes(std::span(text)))) + "'";
}

void replace_all(std::string& text, const std::string& old, const std::string& fresh) {
  for (std::size_t at = text.find(old); at != std::string::npos;
       at = text.find(old, at + fresh.size())) {
    text.replace(at, old.size(), fresh);
  }
}

void make_relative(Json& value, const std::filesystem::path& folder) {
  if (value.is_structured()) {
    for (Json& entry : value) make_relative(entry, folder);
  } else if (value.is_string()) {
    value = relative_to(folder, value.get<std::string>());
  }
}

// The report as the page has it: paths relative, times only where they are wanted.
Json shown_report(const PageJob& job, const PageOptions& options,
                  const std::filesystem::path& folder) {
  Json report = job.report;
  if (!options.times) {
    report.erase("timing_ms");
    report.erase("memory");
  }
  if (!report["argv"].empty()) report["argv"][0] = "planish";
  make_relative(report, folder);
  return report;
}

// Of each job the level that is shown; -1: none.
using ChosenLevels = std::vector<int>;

std::size_t scene_bytes(const PageJob& job, int level) {
  if (level < 0) return 0;
  const PagePayload& payload = job.payloads[level];
  return payload.packed.size() + payload.head.dump().size() + job.still.size();
}

ChosenLevels choose_levels(std::span<const PageJob> jobs, std::size_t words_bytes,
                           std::uint64_t limit) {
  ChosenLevels levels;
  std::size_t sum = words_bytes;
  for (const PageJob& job : jobs) {
    levels.push_back(static_cast<int>(job.payloads.size()) - 1);
    sum += scene_bytes(job, levels.back());
  }
  while (sum > limit) {
    std::size_t largest = 0;
    for (std::size_t j = 1; j < jobs.size(); ++j) {
      if (scene_bytes(jobs[j], levels[j]) > scene_bytes(jobs[largest], levels[largest]))
        largest = j;
    }
    if (levels.empty() || levels[largest] < 0) break;
    sum -= scene_bytes(jobs[largest], levels[largest]);
    sum += scene_bytes(jobs[largest], --levels[largest]);
  }
  return levels;
}

std::string view_note(const PageJob& job, int level, const PageOptions& options) {
  if (job.payloads.empty()) return "The view leaves this job out: its surface is too large.";
  const int deepest = job.payloads.back().level;
  if (level < 0)
    return "The view leaves this job out: even level 0 is larger than the page may be (" +
           byte_size(options.limit_bytes) + "; --page-limit raises it).";
  const std::string shown = formatted("The view shows level {}", job.payloads[level].level);
  const int larger = level + 1 < static_cast<int>(job.payloads.size()) ? deepest : deepest + 1;
  if (larger > kPageLevel) return shown + ".";
  return shown + ", because level " + std::to_string(larger) + " is larger than the page may be (" +
         byte_size(options.limit_bytes) + "; --page-limit raises it).";
}

std::string scene_blocks(const Json& report, const PagePayload& payload, std::size_t number) {
  Json head = {{"job", number},
               {"name", report["job"]},
               {"label", job_label(report)},
               {"tolerance", report["solve"]["tolerance"]}};
  head.update(payload.head);
  return "<script type=\"application/json\" class=\"head\">" + script_json(visible_json(head)) +
         "</script>\n<script type=\"application/octet-stream\" class=\"payload\">" +
         payload.packed + "</script>\n";
}

// Names that two jobs share get numbers, so that they can be told apart where they are compared.
void number_names(std::vector<Json>& reports) {
  std::map<std::string, int> seen;
  for (Json& report : reports) {
    if (report.is_null()) continue;
    const std::string name = report["job"].get<std::string>();
    if (const int before = seen[name]++; before > 0)
      report["job"] = formatted("{} ({})", name, before + 1);
  }
}

std::string status_of(std::span<const PageJob> jobs, std::string_view kind) {
  const auto bad = std::ranges::count_if(jobs, [](const PageJob& job) {
    return !job.failure.empty() || !job.report["solve"]["converged"].get<bool>();
  });
  if (bad > 0)
    return formatted("{} of {}{}", bad, counted(std::ssize(jobs), kind),
                     bad == 1 ? " has failed or not converged" : " have failed or not converged");
  return jobs.size() > 1 ? "all converged" : "";
}

}  // namespace

std::string relative_to(const std::filesystem::path& folder, std::string text) {
  replace_all(text, utf8(folder / ""), "");
  if (const std::filesystem::path path = path_of(text); path.is_absolute()) {
    const std::filesystem::path relative = path.lexically_relative(folder);
    if (!relative.empty()) text = utf8(relative);  // there is none from one drive to another
  }
  return text;
}

std::string content_security(std::string_view script, std::string_view style) {
  return formatted(
      "default-src 'none'; script-src {}; style-src {}; img-src data: blob:; base-uri 'none'; "
      "form-action 'none'; require-trusted-types-for 'script'",
      csp_hash(script), csp_hash(style));
}

std::string filled_form(std::string_view form,
                        const std::map<std::string, std::string, std::less<>>& places) {
  std::string out;
  while (true) {
    const std::size_t open = form.find("{{"), close = form.find("}}");
    if (open == std::string_view::npos) return out.append(form);
    const auto place = places.find(form.substr(open + 2, close - open - 2));
    PLANISH_ASSERT(place != places.end());
    out.append(form.substr(0, open)).append(place->second);
    form.remove_prefix(close + 2);
  }
}

std::string_view page_script() { return kPageScript; }
std::string_view page_style() { return kPageStyle; }

std::string make_page(std::span<const PageJob> jobs, const PageOptions& options,
                      const std::filesystem::path& folder, const std::string& title,
                      std::string_view kind, const PageLead* lead) {
  const std::string script = std::string(kPageScript) + std::string(lead ? lead->script : "");
  const std::string style = std::string(kPageStyle) + std::string(lead ? lead->style : "");
  std::vector<Json> reports;
  for (const PageJob& job : jobs)
    reports.push_back(job.failure.empty() ? shown_report(job, options, folder) : Json());
  number_names(reports);

  const auto page_with = [&](const ChosenLevels& levels) {
    std::map<std::string, std::string, std::less<>> places;
    for (std::size_t j = 0; j < jobs.size(); ++j) {
      if (reports[j].is_null()) {
        places["rows"] += failed_row_html(jobs[j].name, j);
        places["jobs"] += failed_section(jobs[j].name, relative_to(folder, jobs[j].failure), j);
        continue;
      }
      places["rows"] += overview_row(reports[j], j);
      places["jobs"] += job_section(reports[j], j, view_note(jobs[j], levels[j], options),
                                    levels[j] >= 0 ? jobs[j].still : std::string());
      if (levels[j] >= 0)
        places["scenes"] += scene_blocks(reports[j], jobs[j].payloads[levels[j]], j);
    }
    places["jobs"];
    places["scenes"];
    places["security"] = content_security(script, style);
    places["style"] = style;
    places["script"] = script;
    const bool alone = jobs.size() == 1 && lead == nullptr;
    places["title"] = alone           ? html_text(reports[0].is_null() ? jobs[0].name
                                                                       : reports[0]["job"].get<std::string>())
                      : title.empty() ? counted(std::ssize(jobs), kind)
                                      : html_text(title);
    places["below"] = lead ? lead->below : "";
    places["lead"] = lead ? lead->html : overview(places["rows"], kind, alone, options.times);
    places["status"] = status_of(jobs, kind);
    places["tool"] = "planish " PLANISH_VERSION;
    return filled_form(kPageForm, places);
  };
  // The words are needed to know how much room they leave.
  const std::string words = page_with(ChosenLevels(jobs.size(), -1));
  const ChosenLevels levels =
      choose_levels(jobs, words.size() + 1024 * jobs.size(), options.limit_bytes);
  return page_with(levels);
}

namespace {

// Vertices a byte: no surface has packed to less than half a byte a vertex.
constexpr std::uint64_t kMostPacked = 2;

}  // namespace

int page_level(const PolygonMesh& mesh, Scheme scheme, const PageOptions& options) {
  const std::uint64_t most = kMostPacked * options.limit_bytes;
  if (static_cast<std::uint64_t>(mesh.vertex_count()) > most) return -1;
  const bool triangles = scheme == Scheme::Loop;
  int level = 0;
  auto faces = static_cast<std::uint64_t>(mesh.face_vertices.size());
  if (triangles) faces = 2 * static_cast<std::uint64_t>(mesh.face_count());
  while (level < kPageLevel && faces <= most) {
    ++level;
    faces *= 4;
  }
  return level;
}

PageScene job_scene(const PagePayloadInput& input) {
  const PolygonMesh cage = control_cage(input.mesh, input.fitted, input.settings.sharp());
  return make_page_scene({input.surface, input.mesh, cage, input.file_vertices,
                          input.fitted.placement.diagonal, input.fitted.interpolation.worst_vertex,
                          input.exact});
}

std::vector<PagePayload> make_payloads(const PageScene& scene, const Settings& settings,
                                       const PageOptions& options) {
  std::vector<PagePayload> payloads;
  for (int level = 0; level < static_cast<int>(scene.order.counts.size()); ++level) {
    payloads.push_back(encode_scene(scene, level));
    payloads.back().head["up"] = settings.up == UpAxis::Z ? "z" : "y";
    if (payloads.back().packed.size() > options.limit_bytes) break;
  }
  return payloads;
}

namespace {

std::string in_base64(const std::vector<std::byte>& bytes) {
  return base64_text({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

// A mesh as flat faces.
SurfaceMesh faceted(const PolygonMesh& mesh) {
  SurfaceMesh flat;
  flat.face_offsets.assign(mesh.face_offsets.begin(), mesh.face_offsets.end());
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    const glm::vec3 normal(unit_or_zero(area_vector(mesh.positions, face)));
    for (const std::int32_t v : face) {
      flat.face_vertices.push_back(static_cast<std::int32_t>(flat.positions.size()));
      flat.positions.push_back(mesh.positions[v]);
      flat.normals.push_back(normal);
    }
  }
  return flat;
}

}  // namespace

bool JobPage::show(std::size_t mesh, JobLevel& surface, const FittedMesh& fitted,
                   const Settings& settings, const DooSabinSurface* exact) {
  if (meshes_.size() <= mesh) meshes_.resize(mesh + 1);
  PageJob& shown = meshes_[mesh];
  shown.payloads.clear();
  const auto rows = static_cast<std::uint64_t>(surface.blocks().info().row_count);
  const PageScene scene = job_scene(
      {surface.whole(), fitted.mesh, fitted.fit, settings, fitted.source_vertices, exact});
  shown.still = in_base64(still_picture(surface.whole(), settings.up));
  if (options_.small_width > 0 && fitted.mesh.vertex_count() >= largest_) {
    largest_ = fitted.mesh.vertex_count();
    const auto small = [&](const SurfaceMesh& what) {
      return in_base64(
          still_picture(what, settings.up, options_.small_width, options_.small_width * 2 / 3));
    };
    small_ = {small(faceted(fitted.mesh)), small(surface.whole())};
  }
  surface.let_go();
  shown.payloads = make_payloads(scene, settings, options_);
  const std::uint64_t new_vertices = 3 * rows;
  return shown.payloads.back().packed.size() + new_vertices / kMostPacked <= options_.limit_bytes;
}

void JobPage::take(const JobReport& report) {
  if (report.meshes.empty()) {
    meshes_.resize(1);
    meshes_.front().report = to_json(report);
    return;
  }
  asset_ = report.job;
  meshes_.resize(report.meshes.size());
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    JobReport mesh = report.meshes[i];
    mesh.job = mesh.mesh_name;
    mesh.arguments = report.arguments;
    mesh.outputs = report.outputs;
    mesh.host_peak_bytes = report.host_peak_bytes;
    mesh.device_bytes = report.device_bytes;
    for (const auto& [name, step] : kTimedSteps) mesh.timing.total += mesh.timing.*step;
    meshes_[i].report = to_json(mesh);
  }
}

std::string JobPage::text() const {
  const std::filesystem::path folder = std::filesystem::current_path();
  if (asset_.empty()) return make_page(meshes_, options_, folder);
  return make_page(meshes_, options_, folder,
                   formatted("{}: {}", asset_, counted(std::ssize(meshes_), "mesh")), "mesh");
}

std::vector<PageJob> JobPage::jobs() && {
  if (!asset_.empty())
    for (PageJob& mesh : meshes_)
      mesh.report["job"] = named_message(asset_, mesh.report["job"].get<std::string>());
  return std::move(meshes_);
}

}  // namespace planish
