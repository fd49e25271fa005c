#pragma once

#include "planish/job/job_outputs.h"

namespace planish::test {

/// A level of a fitted mesh's surface, with what it is made of. The mesh must outlive it.
class FittedLevel {
 public:
  FittedLevel(const FittedMesh& fitted, Backend& backend, int level)
      : all_(fitted, backend, {}), level_(all_.level(level)) {}

  [[nodiscard]] const SurfaceBlocks& blocks() const { return level_.blocks(); }

 private:
  JobSurface all_;
  JobLevel level_;
};

}  // namespace planish::test
