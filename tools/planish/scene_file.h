#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/json_fwd.h"
#include "planish/job/job.h"
#include "planish/job/job_settings.h"

namespace planish::command {

/// Keys in the order of the file, as in reports: one type of JSON is enough to compile.
using Json = nlohmann::ordered_json;

// Values of a scene file. Each refuses what it is not: `where: what is wanted, not what is`.

void require_object(const Json& json, const std::string& where);
[[nodiscard]] const std::string& text_of(const Json& json, const std::string& where);
[[nodiscard]] std::int64_t integer_of(const Json& json, const std::string& where);
/// From `least` to `most`.
[[nodiscard]] std::int64_t count_of(const Json& json, const std::string& where, std::int64_t least,
                                    std::int64_t most);
[[nodiscard]] double number_of(const Json& json, const std::string& where);

// Where a value stands: "scene.json: jobs[0].solve".
[[nodiscard]] std::string key_path(const std::string& where, std::string_view key);
[[nodiscard]] std::string entry_path(const std::string& where, std::size_t index);

/// Calls visit(entry, its place) for each entry of a list.
void for_entries(const Json& json, const std::string& where,
                 const std::function<void(const Json&, const std::string&)>& visit);

/// The JSON schema of scene files: settings are the rows of the tables of options. What it says of
/// keys is what is read: see scene_keys().
[[nodiscard]] std::string scene_schema_text();

/// The keys that each kind of object in a scene file may have.
enum class SceneObject { Scene, Defaults, Job, Solve, Output, Move };
[[nodiscard]] std::vector<std::string_view> scene_keys(SceneObject object);

/// Throws Error{InvalidArgument} for a key that the object may not have.
void check_keys(const Json& json, SceneObject kind, const std::string& where);

/// What an object of a scene file sets, and that it did. Throws Error{InvalidArgument}.
void apply_settings(Settings& settings, std::vector<GivenSetting>& given, const Json& json,
                    const std::string& where);

/// The same of keys that say how fine a surface is, which take the place of what said so before.
void apply_fineness(const Json& json, const std::string& where, FitSettings& settings);

/// An option as a scene file has it, of the text that its flag takes: "3,1" of a list as [3, 1].
[[nodiscard]] Json value_json(const OptionInfo& option, std::string_view text);

/// Notes a key that the object has.
void note_given(std::vector<GivenSetting>& given, const Json& json, std::string_view key,
                const std::string& where);

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
