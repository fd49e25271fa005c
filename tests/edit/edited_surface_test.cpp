#include "planish/edit/edited_surface.h"

#include <gtest/gtest.h>

#include <limits>

#include "planish/core/error.h"
#include "planish/mesh/placement.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

ErrorCode refusal_of(const EvaluateOptions& options) {
  const PolygonMesh mesh = prism(5);
  try {
    const EditedSurface surface(mesh, placement_of(mesh), mesh.positions, {}, options);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "made at level " << options.level;
  return ErrorCode::Cancelled;
}

// Before its rows are numbered, which takes shifts and memory by the level.
TEST(EditedSurface, IsRefusedWhereThereIsNoSuchLevelOrNoRoom) {
  EvaluateOptions options;
  for (const int level : {-1, 31, 40, std::numeric_limits<int>::max()}) {
    options.level = level;
    EXPECT_EQ(refusal_of(options), ErrorCode::InvalidArgument) << level;
  }
  options.level = 2;
  options.memory_limit_bytes = 1;
  EXPECT_EQ(refusal_of(options), ErrorCode::OutOfMemory);
}

}  // namespace
}  // namespace planish::test
