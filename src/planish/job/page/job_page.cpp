#include "planish/job/page/job_page.h"

#include <filesystem>

#include "planish/core/counted.h"
#include "planish/job/page/page_coding.h"
#include "planish/job/page/page_still.h"
#include "planish/job/report_json.h"
#include "planish/job/text.h"

namespace planish {

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

bool JobPage::show(std::size_t mesh, JobLevel& surface, const FittedMesh& fitted,
                   const Settings& settings, const DooSabinSurface* exact) {
  if (meshes_.size() <= mesh) meshes_.resize(mesh + 1);
  PageJob& shown = meshes_[mesh];
  shown.payloads.clear();
  const auto rows = static_cast<std::uint64_t>(surface.blocks().info().row_count);
  const PageScene scene = job_scene(
      {surface.whole(), fitted.mesh, fitted.fit, settings, fitted.source_vertices, exact});
  const std::vector<std::byte> still = still_picture(surface.whole(), settings.up);
  shown.still = base64_text({reinterpret_cast<const std::uint8_t*>(still.data()), still.size()});
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
