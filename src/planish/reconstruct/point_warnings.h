#pragma once

#include <cstdint>

#include "planish/core/callbacks.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish {

/// Warns of points that were removed for lying far from all others, and of those that stick out.
void tell_outliers(const Callbacks& callbacks, std::int64_t outliers, std::int64_t strays);

/// Warns of a tolerance that is hundreds of times the spacing.
void warn_of_scale(const Reconstruction& result, const Callbacks& callbacks);

/// Warns of what an open or broken mesh lacks: it is no silent success.
void warn_of_mesh(const Reconstruction& result, const ReconstructOptions& options);

}  // namespace planish
