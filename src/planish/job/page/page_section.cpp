#include "planish/job/page/page_section.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include "planish/core/formatted.h"
#include "planish/job/page/page.h"
#include "planish/job/page/page_plot.h"
#include "planish/job/page/page_text.h"
#include "planish/job/text.h"

namespace planish {
namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

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

std::string job_section(const Json& report, std::size_t number, const std::string& view_note,
                        const std::string& still) {
  const std::string id = std::to_string(number);
  std::string html =
      opened(number, html_text(text_of(report["job"])) + " " + status_pill(report["solve"]));
  html += "<p class=\"summary\">" + html_text(summary_sentence(report)) + "</p>";
  if (!still.empty())
    html += formatted(
        "<noscript><img class=\"still\" width=\"{}\" height=\"{}\" alt=\"The surface of {}\" "
        "src=\"data:image/png;base64,{}\"></noscript>",
        kStillWidth, kStillHeight, html_text(text_of(report["job"])), still);
  if (!view_note.empty()) html += "<p class=\"hint\">" + html_text(view_note) + "</p>";
  html += "<div class=\"cards\"><div>" + figures(report) + "</div><div>" + convergence(report, id) +
          "</div><div>" + warnings(report) + files(report) + command(report) + "</div></div>";
  return html + "</section>";
}

std::string failed_section(const std::string& name, const std::string& message,
                           std::size_t number) {
  return opened(number, html_text(name) + " <span class=\"pill bad\">failed</span>") +
         "<p class=\"summary\">" + html_text(message) + "</p></section>";
}

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

std::string failed_row_html(const std::string& name, std::size_t number) {
  const std::string id = std::to_string(number);
  return "<tr data-job=\"" + id + "\"><th scope=\"row\"><a href=\"#job" + id + "\">" +
         html_text(name) + "</a><td colspan=\"8\">failed";
}

std::string job_label(const Json& report) {
  const Json& solve = report["solve"];
  std::string method = solve["method"] == "fair" ? "fair" : text_of(solve["scheme"]);
  if (method == "doo-sabin") method = "progressive";
  const std::string name = text_of(report["job"]);
  return name == method ? name : name + ", " + method;
}

}  // namespace planish
