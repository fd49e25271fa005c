#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planish/job/try_choices.h"

namespace planish {

/// A surface on a page of those that were tried, and what makes it once more.
struct TrialCard {
  TriedSurface tried;
  std::string command;  ///< a line for a shell
  std::string scene;    ///< the text of a scene file
};

/// A page of all surfaces that were tried, as make_page() makes one of jobs: above the view a
/// picture and figures of each, a table of what its cost is the sum of, and for the one that is
/// looked at how to make it. `name`: of the input; `reason`: why the first is taken.
[[nodiscard]] std::string make_trial_page(std::vector<TrialCard> cards, const PageOptions& options,
                                          const std::filesystem::path& folder,
                                          const std::string& name, const std::string& reason);

}  // namespace planish
