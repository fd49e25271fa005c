#pragma once

#include "planish/backend/backend.h"
#include "planish/pipeline/fit_mesh.h"

namespace planish {

/// Fits a mesh that is ready: as its options say, and where these leave the method, joined
/// triangles or added vertices open, by each way that may be the best, of which the one with the
/// least cost is taken (see choice.h). Through given vertices: FitOptions::within is 0. Throws as
/// fit().
[[nodiscard]] FittedMesh choose_fit(ReadyFit ready, Backend& backend);

/// Whether anything is left open.
[[nodiscard]] bool is_open(const ReadyFit& ready);

/// Whether vertices may be added: nothing but its surface hangs on the mesh's own, and where nobody
/// named it, nothing but measurement chooses.
[[nodiscard]] bool may_refine(const ReadyFit& ready);

}  // namespace planish
