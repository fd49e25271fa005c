#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "options/scene_schema.h"
#include "options/scene_values.h"
#include "planish/job/given_setting.h"
#include "planish/job/job_settings.h"

namespace planish::command {

/// Throws Error{InvalidArgument} for a key that the object may not have.
void check_keys(const Json& json, SceneObject kind, const std::string& where);

/// What an object of a scene file sets, and that it did. Throws Error{InvalidArgument}.
void apply_settings(Settings& settings, std::vector<GivenSetting>& given, const Json& json,
                    const std::string& where);

/// The same of keys that say how fine a surface is, which take the place of what said so before.
void apply_fineness(const Json& json, const std::string& where, FitSettings& settings);

/// Notes a key that the object has.
void note_given(std::vector<GivenSetting>& given, const Json& json, std::string_view key,
                const std::string& where);

}  // namespace planish::command
