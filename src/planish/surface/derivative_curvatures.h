#pragma once

#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/normal_curvatures.h"
#include "planish/surface/surface_mesh.h"

namespace planish {

/// The curvatures of a Doo-Sabin surface at the vertices of a tessellation of it, from its second
/// derivatives. The surface is biquadratic piece by piece, and they jump from piece to piece: at a
/// vertex where several meet stands the mean of theirs. Those of `elsewhere` stay at vertices in no
/// piece, those of valence or face size other than 4 of the mesh, where second derivatives have no
/// limit. Units and signs as Curvatures has them; the same bits for every thread count.
[[nodiscard]] Curvatures curvatures_of_derivatives(const DooSabinSurface& surface,
                                                   const SurfaceMesh& tessellation,
                                                   Curvatures elsewhere);

}  // namespace planish
