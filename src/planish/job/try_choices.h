#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/job/job.h"
#include "planish/job/page/page.h"
#include "planish/pipeline/choice.h"
#include "planish/solve/backend.h"

namespace planish {

/// A surface that a job may have: by settings that it leaves open, or as it is by itself.
struct TriedSurface {
  std::string title;  ///< "joined to quads, fair, edges kept sharp"
  std::string stem;   ///< of files: "quads_fair_auto"
  /// Settings by their names, in the order of flags; empty: what the job takes by itself, which no
  /// settings name.
  std::vector<std::pair<std::string, std::string>> settings;
  bool is_taken = false;    ///< the job's own, to the last byte
  std::string failure;      ///< the message of one that was not to be had; it has nothing else
  CostTerms cost;           ///< the sum of its meshes'
  bool is_measured = true;  ///< else its cost is not known
  double bending = 0;       ///< likewise
  double folded = 0;        ///< of the area, the worst mesh
  JobReport report;
  PageJob page;         ///< its part of a page; of an asset that of its largest mesh
  std::string picture;  ///< PNG in base64, kTriedWidth wide
};

/// Of pictures.
inline constexpr int kTriedWidth = 288;

/// What becomes of a job's surface.
struct Trial {
  std::vector<TriedSurface> surfaces;  ///< the one that is taken first, then by cost
  std::string reason;                  ///< why it is
};

/// Takes the file of a surface, a GLB.
using TakeSurface = std::function<void(const TriedSurface& tried, std::string_view bytes)>;

/// TriedSurface::stem of all that trying these settings may come to.
[[nodiscard]] std::vector<std::string> stems_to_try(const Settings& settings);

/// Throws Error{InvalidArgument} where a job leaves nothing open that could be tried: points, whose
/// mesh has a method of its own, other schemes than Doo-Sabin, settings that are all named; and for
/// stdin, for its input is read several times.
void require_open_choice(const Job& job);

/// Makes every surface that the choice of a job's settings is between, those too that it saves
/// itself, and weighs them by its figures. Of the job, input, name, label, settings, arguments and
/// page options are looked at; `arguments` of each get the flags that name it. Warnings are those
/// of the surface that is taken. `has_page`: whether TriedSurface::page and picture are made, which
/// take most of the time. Throws as require_open_choice() and run().
[[nodiscard]] Trial try_choices(const Job& job, Backend& backend, const JobWatch& watch,
                                bool has_page, const TakeSurface& take = {});

}  // namespace planish
