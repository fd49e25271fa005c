#include "job/job.h"
#include "job/point_input.h"
#include "job/prepare.h"
#include "planish/mesh/check.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

// What is written beside surfaces and cages.
std::string described_words(const Job& job) {
  std::string text;
  if (!job.report.empty()) text += "  would write " + job.report + "  (report)\n";
  if (!job.page.empty()) text += "  would write " + job.page + "  (page)\n";
  return text;
}

// How large the mesh will be is not known before it is made.
void describe_point_job(const Job& job, const std::vector<PlannedOutput>& outputs,
                        const DeviceDescription& device) {
  const PointInput input = read_point_input(job.input);
  std::string text = "would reconstruct and fit " + input.name + ": " +
                     with_separators(static_cast<std::int64_t>(input.cloud.points.size())) +
                     " points\n";
  text += "  device      " + device.kind + ", " + device.name + "\n";
  for (const PlannedOutput& output : outputs)
    text +=
        "  would write " + (output.to_stdout ? std::string("stdout") : output.path.string()) + "\n";
  write_stdout(text + described_words(job));
}

std::string face_count_text(const PolygonMesh& mesh, Scheme scheme, int level) {
  if (level == 0) return counted(mesh.face_count(), "face");
  if (scheme == Scheme::Loop) {
    return counted(static_cast<std::int64_t>(mesh.face_count()) << (2 * level), "triangle");
  }
  const auto corners = static_cast<std::int64_t>(mesh.face_vertices.size());
  return counted(corners << (2 * (level - 1)), "quad");
}

}  // namespace

void describe_job(const Job& job, const std::vector<PlannedOutput>& outputs,
                  const DeviceDescription& device) {
  if (is_point_path(job.input, job.input_format)) {
    describe_point_job(job, outputs, device);
    return;
  }
  Input input = read_input(job.input, job.input_format);
  const auto method = job.settings.interpolation == InterpolationChoice::Fair
                          ? InterpolationMethod::Fair
                          : InterpolationMethod::Progressive;
  const PolygonMesh mesh = prepare(std::move(input.file.mesh), job.settings, method).mesh;
  require_usable(mesh, input.name);
  std::string text = "would fit " + input.name + ": " + with_separators(mesh.vertex_count()) +
                     " vertices" + ", " + counted(mesh.face_count(), "face") + "\n";
  const Settings& settings = job.settings;
  text += "  device      " + device.kind + ", " + device.name + "\n  solve       " +
          std::string(name_of(settings.solver)) + ", " +
          subdivision_text(settings.scheme, settings.weights) + ", tolerance " +
          short_number(settings.tolerance) + "\n";
  for (const PlannedOutput& output : outputs) {
    text += "  would write " + (output.to_stdout ? std::string("stdout") : output.path.string());
    if (output.kind == OutputKind::Cage) {
      text += "  (control cage)\n";
      continue;
    }
    text += "  (level " + std::to_string(output.level) + ", " +
            face_count_text(mesh, settings.scheme, output.level) + ")\n";
  }
  write_stdout(text + described_words(job));
}

}  // namespace planish::command
