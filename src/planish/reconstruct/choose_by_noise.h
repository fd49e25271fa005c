#pragma once

#include "planish/reconstruct/reconstruct.h"

namespace planish {

/// Sets how often points are moved and how far they are kept from the mesh, as asked for, or as
/// result.noise, -1 where it was not measured, wants it with result.spacing and result.diagonal.
/// Warns "tolerance-below-noise".
void choose_by_noise(const ReconstructOptions& options, Reconstruction& result);

}  // namespace planish
