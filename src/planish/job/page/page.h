#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json.h"
#include "planish/job/job.h"
#include "planish/job/job_outputs.h"
#include "planish/job/job_settings.h"
#include "planish/job/page/page_scene.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/settings.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

// Everything that a page shows came from outside: names of files, jobs and devices, messages that
// quote them. What follows is all that stands between them and the page.

/// Text in which everything can be seen: control characters, marks that are invisible or turn the
/// direction of writing, and code points that are none stand as `u202e` behind a backslash, bytes
/// that are no UTF-8 as `xff`. Valid UTF-8. A line end is a control character like the others.
[[nodiscard]] std::string visible_text(std::string_view text);

/// visible_text() with & < > " ' ` as character references: for element content and quoted
/// attributes.
[[nodiscard]] std::string html_text(std::string_view text);

/// The same line by line, for preformatted text: line ends stay.
[[nodiscard]] std::string html_lines(std::string_view text);

/// Every string in a JSON value made visible, keys too.
[[nodiscard]] nlohmann::ordered_json visible_json(const nlohmann::ordered_json& value);

/// JSON for the inside of a script element: ASCII, with < > & as their escapes, so that nothing in
/// it can end the element.
[[nodiscard]] std::string script_json(const nlohmann::ordered_json& value);

/// A word of a command as a POSIX shell needs it written.
[[nodiscard]] std::string shell_word(std::string_view word);

/// Three significant digits: 1.99e-07, 0.353, 69,700, 1.5e+06; "not finite" for what is not.
[[nodiscard]] std::string figure(double number);
/// Of a report's number, which is null where it is not finite.
[[nodiscard]] std::string figure(const nlohmann::ordered_json& number);

/// The deepest level that a page shows.
inline constexpr int kPageLevel = 2;
/// Of a page's picture, and of a contact sheet's.
inline constexpr int kStillWidth = 720, kStillHeight = 480;
inline constexpr int kSmallWidth = 144, kSmallHeight = 96;

/// One job on a page.
struct PageJob {
  std::string name;
  std::string failure;            ///< the message of a job that failed; it has nothing else
  nlohmann::ordered_json report;  ///< as the job's JSON report
  /// The scene down to each level that can be shown, coarsest first; empty: figures only.
  std::vector<PagePayload> payloads;
  std::string still;  ///< a picture where no view runs, PNG in base64; there if the scene is
};

/// What stands above the view, in place of the table of all jobs, and below it: rows of a table
/// whose data-job is a job's place show that job.
struct PageLead {
  std::string html, below;
  std::string_view style, script;  ///< besides those of every page
};

/// One HTML file that needs nothing else: figures and plots of all jobs as text and SVG, a view of
/// their surfaces that a script draws. As large as the limit at most, but never without the
/// figures: where the scenes are too large the largest is shown a level coarser, and at last not at
/// all; the page says so. Paths below `folder` (absolute) are written relative to it. The same jobs
/// and options give the same bytes.
/// `kind`: what they are where they are no jobs: meshes of an asset.
[[nodiscard]] std::string make_page(std::span<const PageJob> jobs, const PageOptions& options,
                                    const std::filesystem::path& folder,
                                    const std::string& title = {}, std::string_view kind = "job",
                                    const PageLead* lead = nullptr);

/// A path, or a message that quotes some, without the folder that they are in: a page is mailed
/// round, and absolute paths name who made it.
[[nodiscard]] std::string relative_to(const std::filesystem::path& folder, std::string text);

/// A form with each {{name}} replaced by what has that name; all must be there.
[[nodiscard]] std::string filled_form(
    std::string_view form, const std::map<std::string, std::string, std::less<>>& places);

/// The policy of a page that runs this script and takes this style, and nothing else.
[[nodiscard]] std::string content_security(std::string_view script, std::string_view style);

/// Script and style as they stand in every page.
[[nodiscard]] std::string_view page_script();
[[nodiscard]] std::string_view page_style();

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

/// A mesh as it was given and its surface, PNG in base64.
struct SmallPictures {
  std::string given, surface;
};

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
  /// Of the mesh with the most vertices, where PageOptions ask for them.
  [[nodiscard]] const SmallPictures& small_pictures() const { return small_; }
  /// Its part of a page of several, where meshes are called after the asset, too.
  [[nodiscard]] std::vector<PageJob> jobs() &&;

 private:
  PageOptions options_;
  std::vector<PageJob> meshes_;
  std::string asset_;  ///< that has several
  SmallPictures small_;
  std::int32_t largest_ = -1;  // vertices of the mesh that they show
};

/// A picture of the surface as PNG, clear around it: what a page shows where no script draws.
[[nodiscard]] std::vector<std::byte> still_picture(const SurfaceMesh& surface, UpAxis up,
                                                   int width = kStillWidth,
                                                   int height = kStillHeight);

}  // namespace planish
