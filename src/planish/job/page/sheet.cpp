#include "planish/job/page/sheet.h"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <tuple>

#include "page_files.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/pipeline/option_table.h"

namespace planish {
namespace {

void add_mesh(const JobReport& report, SheetRow& row) {
  row.creases += report.fit.sharp_edges;
  row.joined += report.fit.joined;
  row.warnings += std::ssize(report.warnings);
  row.converged &= report.fit.interpolation.converged;
  if (!report.surface) return;
  row.is_measured = true;
  row.normals = std::max(row.normals, report.surface->quality.rms_normal_deviation);
  row.folded = std::max(row.folded, report.surface->quality.folded_area);
}

std::string method_of(const JobReport& report) {
  if (report.meshes.empty())
    return std::string(report.settings.scheme == Scheme::DooSabin
                           ? word_of(kMethodWords, report.fit.method)
                           : word_of(kSchemeWords, report.settings.scheme));
  const auto fair = std::ranges::count(report.meshes, InterpolationMethod::Fair,
                                       [](const JobReport& mesh) { return mesh.fit.method; });
  return formatted("{} of {} fair", fair, std::ssize(report.meshes));
}

// Larger is worse.
auto badness(const SheetRow& row) {
  return std::tuple(!row.failure.empty(), !row.converged, row.folded, row.warnings, row.normals);
}

// A cell of a column that is sorted by a number.
std::string cell(double number, const std::string& text) {
  return formatted("<td class=\"n\" data-v=\"{}\">{}", shortest(number), html_text(text));
}

std::string picture(const std::string& png, std::string_view what, const std::string& name) {
  if (png.empty()) return "<td>";
  return formatted(
      "<td><img width=\"{}\" height=\"{}\" alt=\"{} of {}\" src=\"data:image/png;base64,{}\">",
      kSmallWidth, kSmallHeight, what, html_text(name), png);
}

// A path as an address: its separators stay.
std::string encode_path(const std::string& path) {
  std::string uri;
  for (const std::filesystem::path& part : path_of(path))
    uri += (uri.empty() ? "" : "/") + (part == ".." ? utf8(part) : encode_uri(utf8(part)));
  return uri;
}

std::string row_html(const SheetRow& row, bool times) {
  constexpr double kUnknown = -1;
  const std::string name = html_text(row.name);
  const std::string linked =
      row.failure.empty() ? formatted("<a href=\"{}\">{}</a>", encode_path(row.page), name) : name;
  std::string html = "<tr>" + picture(row.given, "The input", row.name) +
                     picture(row.surface, "The surface", row.name) + "<th scope=\"row\">" + linked;
  if (row.meshes > 1) html += formatted("<br><small>the largest of {} meshes</small>", row.meshes);
  if (!row.failure.empty()) {
    html += "<td class=\"bad\">failed: " + html_text(row.failure);
    for (int i = 0; i < (times ? 8 : 7); ++i) html += cell(kUnknown, "");
    return html;
  }
  html += row.converged ? "<td>" + html_text(row.method) : "<td class=\"bad\">not converged";
  const auto count = [](std::int64_t number) {
    return cell(static_cast<double>(number), with_separators(number));
  };
  html += row.is_measured ? cell(row.folded, percent(row.folded)) : cell(kUnknown, "");
  html += count(row.warnings);
  html += row.is_measured ? cell(row.normals, fixed(row.normals, 1)) : cell(kUnknown, "");
  html += count(row.vertices) + count(row.creases) + count(row.joined) +
          cell(static_cast<double>(row.bytes), byte_size(row.bytes));
  if (times) html += cell(row.milliseconds, duration(row.milliseconds));
  return html;
}

std::string heads(bool times) {
  std::string html;
  const auto add = [&](std::string_view name, std::string_view kind) {
    html += formatted("<th scope=\"col\"{}><button type=\"button\">{}</button>", kind, name);
  };
  html += "<th scope=\"col\">input<th scope=\"col\">surface";
  add("file", "");
  add("method", "");
  for (const std::string_view name :
       {"folded", "warnings", "normals off, degrees", "vertices", "creases", "joined", "written"})
    add(name, " class=\"n\"");
  if (times) add("time", " class=\"n\"");
  return html;
}

}  // namespace

SheetRow sheet_row(const JobReport& report) {
  SheetRow row;
  row.method = method_of(report);
  row.vertices =
      report.meshes.empty() ? report.input.statistics.vertex_count : report.input.file_vertices;
  if (report.meshes.empty()) add_mesh(report, row);
  for (const JobReport& mesh : report.meshes) add_mesh(mesh, row);
  if (!report.meshes.empty()) {
    row.meshes = std::ssize(report.meshes);
    row.warnings += std::ssize(report.warnings);
  }
  for (const auto& output : report.outputs) row.bytes += output.bytes;
  row.milliseconds = report.timing.total;
  return row;
}

std::vector<std::size_t> worst_first(const std::vector<SheetRow>& rows) {
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](std::size_t i) { return badness(rows[i]); });
  return order;
}

std::string make_sheet(const std::vector<SheetRow>& rows, bool times, std::string_view kind) {
  const auto bad = std::ranges::count_if(
      rows, [](const SheetRow& row) { return !row.failure.empty() || !row.converged; });
  const std::string style = std::string(page_style()) + std::string(kSheetStyle);
  std::string body;
  for (const std::size_t i : worst_first(rows)) body += row_html(rows[i], times) + "\n";
  return filled_form(
      kSheetForm,
      {{"security", content_security(kSheetScript, style)},
       {"tool", "planish " PLANISH_VERSION},
       {"title", counted(std::ssize(rows), kind)},
       {"status", bad == 0 ? "all converged, the worst first"
                           : formatted("{} failed or not converged, the worst first", bad)},
       {"style", style},
       {"script", std::string(kSheetScript)},
       {"heads", heads(times)},
       {"rows", std::move(body)}});
}

}  // namespace planish
