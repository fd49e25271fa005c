#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "planish/job/job_settings.h"
#include "planish/job/job_surface.h"
#include "planish/job/page/page.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

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

/// What a page shows of one job: its mesh, or those of an asset in their order.
class JobPage {
 public:
  explicit JobPage(const PageOptions& options) : options_(options) {}

  /// The deepest level that it can show of a mesh; -1: not even its own vertices.
  [[nodiscard]] int level(const PolygonMesh& mesh, Scheme scheme) const {
    return page_level(mesh, scheme, options_);
  }
  /// Takes what it draws of a level, in place of a coarser one. Returns whether a finer one may be
  /// shown, too. `exact`: what the level was taken from; null with other schemes than Doo-Sabin.
  bool show(std::size_t mesh, JobLevel& surface, const FittedMesh& fitted, const Settings& settings,
            const DooSabinSurface* exact);
  /// Once the report is complete but for the page.
  void take(const JobReport& report);
  /// A page of this job alone.
  [[nodiscard]] std::string text() const;
  /// Its part of a page of several, where meshes are called after the asset, too.
  [[nodiscard]] std::vector<PageJob> jobs() &&;

 private:
  PageOptions options_;
  std::vector<PageJob> meshes_;
  std::string asset_;  ///< that has several
};

}  // namespace planish
