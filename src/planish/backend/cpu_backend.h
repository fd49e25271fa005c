#pragma once

#include <memory>

#include "planish/backend/backend.h"

namespace planish {

/// What the solve computes in. Surfaces are always evaluated in double.
enum class Precision { Float, Double };

struct CpuBackendOptions {
  Precision solve_precision = Precision::Double;
  int thread_count = 0;  ///< with the caller's; 0: those of his arena. Same bits for every count.
};

/// The backend of machines without a GPU, and the oracle that every shader is held against.
[[nodiscard]] std::unique_ptr<Backend> make_cpu_backend(const CpuBackendOptions& options = {});

}  // namespace planish
