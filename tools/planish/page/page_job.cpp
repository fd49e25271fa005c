#include "page/page_job.h"

#include <unistd.h>

#include <filesystem>

#include "options/size_value.h"
#include "page/page_coding.h"
#include "page/page_still.h"
#include "planish/core/error.h"
#include "planish/job/report_json.h"
#include "planish/job/text.h"

namespace planish::command {

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

bool ShownJob::show(JobLevel& surface, const FittedMesh& fitted, const Settings& settings,
                    const DooSabinSurface* exact) {
  job_.payloads.clear();
  const auto rows = static_cast<std::uint64_t>(surface.blocks().info().row_count);
  const PageScene scene = job_scene(
      {surface.whole(), fitted.mesh, fitted.fit, settings, fitted.source_vertices, exact});
  const std::vector<std::byte> still = still_picture(surface.whole(), settings.up);
  job_.still = base64_text({reinterpret_cast<const std::uint8_t*>(still.data()), still.size()});
  surface.let_go();
  job_.payloads = make_payloads(scene, settings, options_);
  const std::uint64_t new_vertices = 3 * rows;
  return job_.payloads.back().packed.size() + new_vertices / kMostPacked <= options_.limit_bytes;
}

std::string ShownJob::text(const JobReport& report) {
  job_.report = to_json(report);
  return make_page({&job_, 1}, options_, std::filesystem::current_path());
}

PageJob ShownJob::with(const JobReport& report) && {
  job_.report = to_json(report);
  return std::move(job_);
}

std::uint64_t parse_page_limit(std::string_view value, std::string_view where) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32;  // browsers hold a page as text
  return parse_size(value, where, kMost, "8M or 500K");
}

PageOptions page_options(const std::string& limit, bool no_times) {
  PageOptions options;
  options.times = !no_times;
  if (!limit.empty()) options.limit_bytes = parse_page_limit(limit, "--page-limit");
  return options;
}

void require_page_path(const std::string& path, std::string_view where) {
  if (path == "-") {
    if (::isatty(STDOUT_FILENO) == 1) {
      throw Error(ErrorCode::InvalidArgument,
                  std::string(where) + ": a page is not written to a terminal; name a file");
    }
    return;
  }
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".html" || extension == ".htm") return;
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: {}: a page is an .html file", where, plain_utf8(path)));
}

}  // namespace planish::command
