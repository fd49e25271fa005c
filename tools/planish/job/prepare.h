#pragma once

#include "options/settings.h"
#include "planish/fair/interpolation_method.h"
#include "planish/pipeline/make_ready.h"

namespace planish::command {

/// make_ready() of a job, whose scene file may tag further edges and vertices of the input. Throws
/// as that, and Error{UnusableMesh} for a tag that names no vertex.
[[nodiscard]] ReadyMesh prepare(PolygonMesh&& mesh, const Settings& settings,
                                InterpolationMethod method);

}  // namespace planish::command
