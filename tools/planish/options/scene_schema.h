#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planish::command {

/// The JSON schema of scene files: settings are the rows of the tables of options. What it says of
/// keys is what is read: see scene_keys().
[[nodiscard]] std::string scene_schema_text();

/// The keys that each kind of object in a scene file may have.
enum class SceneObject { Scene, Defaults, Job, Solve, Output, Sample, Move };
[[nodiscard]] std::vector<std::string_view> scene_keys(SceneObject object);

}  // namespace planish::command
