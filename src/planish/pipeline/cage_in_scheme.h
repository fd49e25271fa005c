#pragma once

#include <optional>
#include <string_view>

#include "planish/core/callbacks.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/primal/scheme.h"
#include "planish/solve/backend.h"

namespace planish {

/// A control cage of another scheme beside a fitted surface: on the same faces, with the same
/// creases, its limit surface passes through the same points. It is for programs that know that
/// scheme and not Doo-Sabin. Where the scheme has no surface through these points, or the iteration
/// does not find it, the cage is the one of the least sum of squared distances that conjugate
/// gradients find within as many steps; Fit::interpolation says how far it is off, at most and on
/// average. Throws Error{UnusableMesh} (also for Loop on other faces than triangles) and
/// Error{Cancelled}.
[[nodiscard]] FittedMesh cage_in_scheme(const FittedMesh& fitted, Scheme scheme, Backend& backend,
                                        const Callbacks& callbacks = {});

/// Says of such a cage how far it leaves the vertices ("not-converged"); nothing where it is within
/// the tolerance.
[[nodiscard]] std::optional<Warning> cage_warning(const FittedMesh& cage, std::string_view name);

}  // namespace planish
