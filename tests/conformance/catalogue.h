#pragma once

#include <vector>

#include "planish/doosabin/subdivision.h"
#include "support/meshes.h"

namespace planish::test {

inline constexpr Weights kBothWeights[] = {Weights::DooSabin, Weights::Averaged};

/// Small closed meshes without tags: every platonic kind, prisms, poles, valence 2, random ones.
[[nodiscard]] std::vector<NamedMesh> closed_meshes();

/// Small open meshes without tags.
[[nodiscard]] std::vector<NamedMesh> open_meshes();

/// Meshes with creases, corners and darts, open and closed.
[[nodiscard]] std::vector<NamedMesh> sharp_meshes();

/// All three.
[[nodiscard]] std::vector<NamedMesh> all_meshes();

}  // namespace planish::test
