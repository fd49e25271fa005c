#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Groups of faces in the order in which they are first asked for, each once.
class GroupList {
 public:
  std::int32_t index_of(const FaceGroup& group) {
    const auto next = static_cast<std::int32_t>(groups_.size());
    const auto [entry, is_new] = index_of_.try_emplace({group.name, group.material}, next);
    if (is_new) groups_.push_back(group);
    return entry->second;
  }
  [[nodiscard]] const std::vector<FaceGroup>& groups() const { return groups_; }
  /// Hands them over; the list is not used any more.
  [[nodiscard]] std::vector<FaceGroup> take() { return std::move(groups_); }

 private:
  std::vector<FaceGroup> groups_;
  std::map<std::pair<std::string, std::string>, std::int32_t> index_of_;
};

}  // namespace planish
