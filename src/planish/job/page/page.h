#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json.h"
#include "planish/job/job.h"
#include "planish/job/page/page_scene.h"

namespace planish {

/// The deepest level that a page shows.
inline constexpr int kPageLevel = 2;
/// Of a page's picture.
inline constexpr int kStillWidth = 720, kStillHeight = 480;

/// One job on a page.
struct PageJob {
  std::string name;
  std::string failure;            ///< the message of a job that failed; it has nothing else
  nlohmann::ordered_json report;  ///< as the job's JSON report
  /// The scene down to each level that can be shown, coarsest first; empty: figures only.
  std::vector<PagePayload> payloads;
  std::string still;  ///< a picture for who runs no script, PNG in base64; shown with the scene
};

/// One HTML file that needs nothing else: figures and plots of all jobs as text and SVG, a view of
/// their surfaces that a script draws. As large as the limit at most, but never without the
/// figures: where the scenes are too large the largest is shown a level coarser, and at last not at
/// all; the page says so. Paths below `folder` (absolute) are written relative to it. The same jobs
/// and options give the same bytes.
/// `kind`: what they are where they are no jobs: meshes of an asset.
[[nodiscard]] std::string make_page(std::span<const PageJob> jobs, const PageOptions& options,
                                    const std::filesystem::path& folder,
                                    const std::string& title = {}, std::string_view kind = "job");

/// Script and style as they stand in every page.
[[nodiscard]] std::string_view page_script();
[[nodiscard]] std::string_view page_style();

}  // namespace planish
