#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "options/scene_settings.h"
#include "planish/job/job.h"

namespace planish::command {

/// The jobs of a scene file, in its order, with defaults applied and paths made relative to the
/// file's folder. Throws Error{InvalidArgument}: `scene.json: jobs[0].solve.solver: what, value`;
/// for a key that is not known the nearest known one is named.
[[nodiscard]] std::vector<Job> read_scene_file(const std::filesystem::path& path);

/// The text of a scene file. Throws Error{InvalidArgument} where it cannot be read.
[[nodiscard]] std::string read_scene_text(const std::filesystem::path& path);

/// The same from text; `name` stands in messages, `folder` is what paths are relative to.
[[nodiscard]] std::vector<Job> parse_scene(std::string_view text, const std::string& name,
                                           const std::filesystem::path& folder);

/// The jobs of those names in the order of the scene; all for no names.
/// Throws Error{InvalidArgument} for a name that no job has.
[[nodiscard]] std::vector<Job> select_jobs(std::vector<Job> jobs,
                                           const std::vector<std::string>& names);

}  // namespace planish::command
