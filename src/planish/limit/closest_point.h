#pragma once

#include <glm/vec3.hpp>

#include "planish/limit/corner_tree.h"
#include "planish/limit/patch_pieces.h"

namespace planish {

/// The nearest place of a surface in unit coordinates.
struct NearestPlace {
  std::int32_t corner = -1;
  double u = 0, v = 0;
  double square_distance = 0;
};

/// Searches a tree for the place nearest to a point, both in unit coordinates. Used again from
/// point to point; one a thread.
class NearestSearch {
 public:
  explicit NearestSearch(const CornerTree& tree) : tree_(tree), pieces_(tree.surface()) {}

  [[nodiscard]] NearestPlace run(const glm::dvec3& point);

 private:
  void search_corner(std::int32_t corner, const glm::dvec3& point);
  void descend(double u, double v, const glm::dvec3& point);

  const CornerTree& tree_;
  PatchPieces pieces_;
  struct Waiting {
    std::int32_t node;
    double square_distance;
  };
  std::vector<Waiting> waiting_;
  NearestPlace best_;
};

}  // namespace planish
