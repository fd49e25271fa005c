#pragma once

#include <string>
#include <vector>

#include "options/scene_values.h"
#include "planish/job/scene_move.h"

namespace planish::command {

/// The "moves" of a job. Throws Error{InvalidArgument}: where, what is wanted, what is.
[[nodiscard]] std::vector<SceneMove> moves_of(const Json& json, const std::string& where);

}  // namespace planish::command
