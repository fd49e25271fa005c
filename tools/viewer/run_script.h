#pragma once

#include <span>

#include "edit_script.h"
#include "edit_session.h"
#include "headless.h"

namespace planish::viewer {

/// Drives a session as the mouse and the keys of a window do, and draws each frame. Returns how
/// many it drew. Throws Error with the step's file and line.
int run_script(std::span<const ScriptStep> script, EditSession& session, Headless& headless,
               const SaveOptions& save);

}  // namespace planish::viewer
