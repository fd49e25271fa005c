#pragma once

#include <cstdint>

namespace planish {

/// What an untagged open boundary is.
enum class BoundaryRule {
  Edge,           ///< creases throughout
  EdgeAndCorner,  ///< and boundary vertices with one face are corners
};

struct SharpFeatureOptions {
  BoundaryRule boundary = BoundaryRule::Edge;
  bool use_tags = true;  ///< false: only boundaries are sharp
};

}  // namespace planish
