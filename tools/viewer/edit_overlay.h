#pragma once

#include <glm/vec2.hpp>

#include "camera.h"
#include "edit_session.h"

namespace planish::viewer {

/// The selected vertices as discs and those that move along as dots, the larger the more they do.
/// Between Overlay::begin() and record().
void draw_selection(const EditSession& session, const OrbitCamera& camera, const glm::vec2& size);

}  // namespace planish::viewer
