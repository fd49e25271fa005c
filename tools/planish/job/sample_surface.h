#pragma once

#include "planish/job/sampling.h"

namespace planish::command {

/// Sampling::draw. Throws what fit() and evaluate() throw.
[[nodiscard]] PointCloud sample_surface(const Input& input, const Sampling& sampling,
                                        const Callbacks& callbacks);

}  // namespace planish::command
