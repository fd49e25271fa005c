#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"

// What whoever gives a mesh should know of it, although it is fitted as it is. Elements are counted
// as in the given mesh.
namespace planish {

/// "torn-vertices" of a mesh that is ready: see torn_vertices(). None where somebody has welded it,
/// or sheets of it were separated: whoever did knows of vertices at one place.
[[nodiscard]] std::optional<Warning> torn_warning(const FittedMesh& ready, std::string_view name);

/// "unused-vertices" of a fitted mesh; with `of_input`, where the faces are the caller's own,
/// "inside-out", too.
[[nodiscard]] std::vector<Warning> mesh_warnings(const FittedMesh& fitted, std::string_view name,
                                                 bool of_input);

}  // namespace planish
