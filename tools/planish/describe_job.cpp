#include "job.h"
#include "planish/mesh/check.h"
#include "point_input.h"
#include "prepare.h"
#include "text.h"

namespace planish::command {
namespace {

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
  if (!job.report.empty()) text += "  would write " + job.report + "  (report)\n";
  write_stdout(text);
}

}  // namespace

void describe_job(const Job& job, const std::vector<PlannedOutput>& outputs,
                  const DeviceDescription& device) {
  if (is_point_path(job.input, job.input_format)) {
    describe_point_job(job, outputs, device);
    return;
  }
  const Input input = read_input(job.input, job.input_format);
  const PolygonMesh mesh = prepare(input.file.mesh, job.settings).mesh;
  require_usable(mesh, input.name);
  std::string text = "would fit " + input.name + ": " + with_separators(mesh.vertex_count()) +
                     " vertices" + ", " + counted(mesh.face_count(), "face") + "\n";
  const Settings& settings = job.settings;
  text += "  device      " + device.kind + ", " + device.name + "\n  solve       " +
          std::string(name_of(settings.solver)) + ", " + std::string(name_of(settings.weights)) +
          " weights, tolerance " + short_number(settings.tolerance) + "\n";
  for (const PlannedOutput& output : outputs) {
    text += "  would write " + (output.to_stdout ? std::string("stdout") : output.path.string());
    if (output.kind == OutputKind::Cage) {
      text += "  (control cage)\n";
      continue;
    }
    const auto corners = static_cast<std::int64_t>(mesh.face_vertices.size());
    text += "  (level " + std::to_string(output.level) + ", " +
            (output.level == 0 ? counted(mesh.face_count(), "face")
                               : counted(corners << (2 * (output.level - 1)), "quad")) +
            ")\n";
  }
  if (!job.report.empty()) text += "  would write " + job.report + "  (report)\n";
  write_stdout(text);
}

}  // namespace planish::command
