// A tree whose corners have moved, against one made anew and against unions one by one.
#include "planish/queries/surface_queries.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>

#include "limit/limit_case.h"

namespace planish::test {
namespace {

bool same(const CornerBox& a, const CornerBox& b) { return a.low == b.low && a.high == b.high; }

// A surface whose control points of level 1 can be changed.
struct MovedCase {
  explicit MovedCase(const PolygonMesh& cage)
      : mesh(cage), placement(placement_of(mesh.positions)) {
    std::vector<glm::dvec3> unit;
    const auto prepared = prepare_mesh(mesh, "mesh");
    for (const std::int32_t v : prepared->vertices)
      unit.push_back(placement.to_unit(mesh.positions[v]));
    surface = std::make_shared<DooSabinSurface>(mesh, placement, unit,
                                                std::span<const glm::dvec3>{}, EvaluateOptions{});
    limit = std::make_unique<LimitSurface>(surface);
    (void)changed_corners();
  }
  // Moves some control points; returns the corners whose patches have others.
  std::vector<std::int32_t> move(std::mt19937& random, int count) {
    const PatchMesh& patches = surface->patches();
    std::uniform_int_distribution<std::int32_t> any(0, patches.state_size() - 1);
    std::normal_distribution<double> way(0, 0.1);
    for (int i = 0; i < count; ++i)
      surface->own_state()[any(random)] += glm::dvec3(way(random), way(random), way(random));
    patches.update_sums(surface->own_state());
    return changed_corners();
  }
  std::vector<std::int32_t> changed_corners() {
    const auto count = static_cast<std::size_t>(surface->topology().corner_count());
    last.resize(count);
    std::vector<std::int32_t> corners;
    LimitSurface::Corner corner(*limit);
    for (std::size_t c = count; c-- > 0;) {
      corner.move_to(static_cast<std::int32_t>(c));
      std::vector<glm::dvec3> points(corner.points().begin(), corner.points().end());
      points.push_back(corner.own());
      if (points != last[c]) corners.push_back(static_cast<std::int32_t>(c));
      last[c] = std::move(points);
    }
    return corners;
  }

  PolygonMesh mesh;
  Placement placement;
  std::shared_ptr<DooSabinSurface> surface;
  std::unique_ptr<LimitSurface> limit;
  std::vector<std::vector<glm::dvec3>> last;
};

// Every node holds what is below it, no more.
std::int64_t check_node(const CornerTree& tree, std::int32_t index) {
  const CornerTree::Node& node = tree.nodes()[index];
  CornerBox box{glm::vec3(1e30f), glm::vec3(-1e30f)};
  const auto add = [&](const CornerBox& other) {
    box = {glm::min(box.low, other.low), glm::max(box.high, other.high)};
  };
  std::int64_t count = 1;
  if (node.count > 0) {
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) add(tree.boxes()[i]);
  } else {
    for (const std::int32_t child : {index + 1, node.right}) {
      count += check_node(tree, child);
      add(tree.nodes()[child].box);
    }
  }
  EXPECT_TRUE(same(node.box, box)) << index;
  return count;
}

TEST(CornerTree, RefitsWhatHasMoved) {
  std::mt19937 random(6);
  for (const auto& [name, mesh] : limit_meshes()) {
    SCOPED_TRACE(name);
    MovedCase c(mesh);
    CornerTree tree(*c.limit);
    if (tree.nodes().empty()) continue;
    for (int i = 0; i < 4; ++i) {
      const std::vector<std::int32_t> corners = c.move(random, 3);
      const std::int64_t looked = tree.refit(corners);
      EXPECT_LE(looked, std::ssize(tree.nodes()));
      EXPECT_EQ(check_node(tree, 0), std::ssize(tree.nodes()));
    }
    const CornerTree fresh(*c.limit);
    ASSERT_EQ(fresh.corners().size(), tree.corners().size());
    std::vector<CornerBox> boxes(static_cast<std::size_t>(c.surface->topology().corner_count()));
    for (std::size_t i = 0; i < fresh.corners().size(); ++i)
      boxes[fresh.corners()[i]] = fresh.boxes()[i];
    for (std::size_t i = 0; i < tree.corners().size(); ++i)
      ASSERT_TRUE(same(tree.boxes()[i], boxes[tree.corners()[i]])) << i;
    tree.rebuild();
    EXPECT_EQ(tree.corners(), fresh.corners());
    for (std::size_t n = 0; n < fresh.nodes().size(); ++n)
      ASSERT_TRUE(same(tree.nodes()[n].box, fresh.nodes()[n].box)) << n;
    EXPECT_EQ(tree.refit({}), 0);
  }
}

TEST(CornerTree, LooksAtAsManyNodesAsAreAboveACorner) {
  for (const int size : {20, 80}) {
    const LimitCase c(torus(size, size, 1, 0.4));
    CornerTree tree(c.limit);
    const double height = std::log2(static_cast<double>(tree.corners().size()));
    for (const std::int32_t corner : {0, 7, size * size})
      EXPECT_LE(tree.refit(std::span(&corner, 1)), std::lround(std::ceil(height)) + 1);
    EXPECT_EQ(tree.refit(tree.corners()), std::ssize(tree.nodes()));
  }
}

}  // namespace
}  // namespace planish::test
