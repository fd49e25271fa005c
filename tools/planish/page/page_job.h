#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "page/page.h"
#include "planish/job/job_settings.h"
#include "planish/pipeline/fit.h"
#include "planish/surface/surface_mesh.h"

namespace planish::command {

/// The level that a page shows of a mesh: the deepest, up to kPageLevel, whose vertices may fit
/// into the limit; -1 where even the mesh's own do not.
[[nodiscard]] int page_level(const PolygonMesh& mesh, Scheme scheme, const PageOptions& options);

struct PagePayloadInput {
  const SurfaceMesh& surface;  ///< of page_level()
  const PolygonMesh& mesh;     ///< that was fitted
  const Fit& fitted;
  const Settings& settings;
  std::span<const std::int32_t> file_vertices;  ///< see PageSceneInput
  const DooSabinSurface* exact;                 ///< the same
};

/// What a page draws of a fitted job.
[[nodiscard]] PageScene job_scene(const PagePayloadInput& input);

/// A scene down to each level of its surface, coarsest first; none after the first that is larger
/// than a page may be.
[[nodiscard]] std::vector<PagePayload> make_payloads(const PageScene& scene,
                                                     const Settings& settings,
                                                     const PageOptions& options);

/// What pages show of one job.
class ShownJob final : public JobPage {
 public:
  ShownJob(std::string name, const PageOptions& options) : options_(options) {
    job_.name = std::move(name);
  }

  [[nodiscard]] int level(const PolygonMesh& mesh, Scheme scheme) const override {
    return page_level(mesh, scheme, options_);
  }
  bool show(JobLevel& surface, const FittedMesh& fitted, const Settings& settings,
            const DooSabinSurface* exact) override;
  [[nodiscard]] std::string text(const JobReport& report) override;
  /// For a page of several jobs.
  [[nodiscard]] PageJob with(const JobReport& report) &&;

 private:
  PageOptions options_;
  PageJob job_;
};

/// "8M", "500K", "2G" or bytes. Throws Error{InvalidArgument} naming `where`.
[[nodiscard]] std::uint64_t parse_page_limit(std::string_view value, std::string_view where);

/// The options as flags give them; an empty limit is the default.
[[nodiscard]] PageOptions page_options(const std::string& limit, bool no_times);

/// Refuses a path that is no .html or .htm, and "-" where stdout is a terminal, with
/// Error{InvalidArgument} naming `where`.
void require_page_path(const std::string& path, std::string_view where);

}  // namespace planish::command
