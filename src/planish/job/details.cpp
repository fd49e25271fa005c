#include "planish/job/details.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include <oneapi/tbb/task_arena.h>

#include "planish/core/formatted.h"
#include "planish/core/visible_text.h"
#include "planish/job/text.h"

namespace planish {
namespace {

std::string line(const char* label, const std::string& value) {
  std::string text = std::string("  ") + label;
  text.resize(14, ' ');
  return text + value + "\n";
}

std::string errors_text(const std::vector<ErrorNorms>& history) {
  constexpr std::size_t kShown = 24;
  std::string text;
  for (std::size_t i = 0; i < history.size() && i < kShown; ++i)
    text += (i == 0 ? "" : ", ") + short_number(history[i].max);
  return history.size() > kShown ? text + ", ... (the report has all)" : text;
}

}  // namespace

std::string details(const JobReport& report) {
  if (!report.meshes.empty()) {
    std::string all;
    for (const JobReport& mesh : report.meshes)
      all += (all.empty() ? "" : "\n") + mesh.mesh_name + " of " + details(mesh);
    return all;
  }
  std::string text = report.job + ", in detail:\n";
  text += line("threads", std::to_string(oneapi::tbb::this_task_arena::max_concurrency()));
  if (report.fit.fair) {
    text += line("drawn in", formatted("{}, {} turned back, {} cured of folds",
                                       counted(report.fit.fair->shrunk_vertices, "vertex"),
                                       counted(report.fit.fair->reversed_vertices, "vertex"),
                                       with_separators(report.fit.fair->cured_vertices)));
    if (report.fit.fair->least_polygon)
      text += line("least polygon",
                   short_number(*report.fit.fair->least_polygon) + " of its vertex' shortest edge");
    text += line("flagged", counted(report.fit.fair->flagged_edges, "edge") + ", " +
                                counted(report.fit.fair->flagged_faces, "face"));
  } else {
    text += line("bound", short_number(report.fit.spectral_bound) + " (least eigenvalue of B)");
  }
  text += line("errors", errors_text(report.fit.interpolation.history));
  if (report.host_peak_bytes > 0)  // of a mesh of several only the job has it
    text += line("memory", byte_size(report.host_peak_bytes) + " at most" +
                               (report.device_bytes > 0
                                    ? ", " + byte_size(report.device_bytes) + " on the device"
                                    : ""));
  text.pop_back();
  return text;
}

std::string next_step(const JobReport& report) {
  const bool has_page = !report.page.path.empty() && report.page.path != "-";
  if (has_page) return "next: open " + visible(report.page.path) + " in a browser";
  for (const WrittenOutput& output : report.outputs) {
    if (output.path == "-") continue;
    const std::string path = visible(output.path);
    if (output.kind == OutputKind::Cage)
      return formatted("next: planish verify {} {}", path, visible(report.input.path));
    return "next: open " + path + ", or see it in a browser: planish fit ... --page out.html";
  }
  return "next: see it in a browser: planish fit ... --page out.html";
}

}  // namespace planish
