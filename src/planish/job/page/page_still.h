#pragma once

#include <cstddef>
#include <vector>

#include "planish/pipeline/settings.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// A picture of the surface as PNG, clear around it: what a page shows where no script draws.
[[nodiscard]] std::vector<std::byte> still_picture(const SurfaceMesh& surface, UpAxis up);

}  // namespace planish
