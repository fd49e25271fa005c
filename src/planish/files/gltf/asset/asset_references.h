#pragma once

#include <cstdint>
#include <set>

#include "planish/core/json_fwd.h"

namespace planish {

/// Accessors and buffer views that a document names, by number.
struct AssetReferences {
  std::set<std::int64_t> accessors, views;

  void add_primitive(const nlohmann::json& primitive);
  /// Whatever stands anywhere in `value` under the names that the format and its extensions have
  /// for them; no primitives.
  void add_all(const nlohmann::json& value);
};

/// Places in an asset's lists that only the triangles of some meshes name: what comes in their
/// place can have them.
struct FreePlaces {
  std::set<std::int64_t> accessors, views;
};
/// `is_replaced`: by mesh, whether its triangles give way.
[[nodiscard]] FreePlaces free_places(const nlohmann::json& document,
                                     const std::set<std::int64_t>& replaced_meshes);

}  // namespace planish
