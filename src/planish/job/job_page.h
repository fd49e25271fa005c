#pragma once

#include <string>

#include "planish/job/job_settings.h"
#include "planish/job/job_surface.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

struct JobReport;

/// The deepest level that a page shows.
inline constexpr int kPageLevel = 2;
/// Of a page's picture.
inline constexpr int kStillWidth = 720, kStillHeight = 480;

/// A page for people, to which a job shows its surface.
class JobPage {
 public:
  JobPage() = default;
  JobPage(const JobPage&) = delete;
  JobPage& operator=(const JobPage&) = delete;
  virtual ~JobPage() = default;

  /// The deepest level that it can show of a mesh; -1: not even its own vertices.
  [[nodiscard]] virtual int level(const PolygonMesh& mesh, Scheme scheme) const = 0;
  /// Takes what it draws of a level, in place of a coarser one. Returns whether a finer one may be
  /// shown, too. `exact`: what the level was taken from; null with other schemes than Doo-Sabin.
  virtual bool show(JobLevel& surface, const FittedMesh& fitted, const Settings& settings,
                    const DooSabinSurface* exact) = 0;
  /// All of it, once the report is complete but for the page.
  [[nodiscard]] virtual std::string text(const JobReport& report) = 0;
};

}  // namespace planish
