#pragma once

#include <cstdint>
#include <vector>

#include "planish/doosabin/face_rule.h"
#include "planish/patches/patch_mesh.h"
#include "planish/stencil/stencil_table.h"
#include "shaders/shared.h"

namespace planish::vulkan {

/// Points of the state of level 1 that one dispatch makes.
struct StepPart {
  std::uint32_t kind = shared::kStepFaces;
  std::uint32_t count = 0;        ///< of points, or of large faces
  std::uint32_t first_point = 0;  ///< where the points are no large faces'
  std::uint32_t first_word = 0;   ///< of the sharp points or large faces
};

/// The first step as its kernel takes it, beside PatchRecords::links.
struct StepRecords {
  std::vector<std::uint32_t> vertices;  ///< per corner
  /// The place of each small face size's weights, the weights; of each large face its
  /// kLargeFaceWords, and what they name; then of each sharp point its vertex and where its pairs
  /// begin, and pairs of a vertex and a weight.
  std::vector<std::uint32_t> words;
  FaceSumRule rule{};
  std::vector<StepPart> parts;
};

/// `sharp_rows`: the rows of the first step behind those of the corners.
[[nodiscard]] StepRecords step_records(const PatchMesh& mesh, Weights weights,
                                       const StencilView<double>& sharp_rows);

}  // namespace planish::vulkan
