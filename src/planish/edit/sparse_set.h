#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace planish {

/// Some of the numbers 0 to size - 1 in the order in which they came, for loops whose cost follows
/// what is in it, not `size`: it is emptied at no cost. 4 bytes a number. Source: Briggs & Torczon,
/// "An efficient representation for sparse sets", 1993.
class SparseSet {
 public:
  explicit SparseSet(std::int32_t size) : places_(static_cast<std::size_t>(size), 0) {}

  void clear() { members_.clear(); }
  [[nodiscard]] bool contains(std::int32_t number) const {
    const auto place = static_cast<std::size_t>(places_[number]);
    return place < members_.size() && members_[place] == number;
  }
  /// Where the number stands among members(); it must be there.
  [[nodiscard]] std::size_t place_of(std::int32_t number) const {
    return static_cast<std::size_t>(places_[number]);
  }
  /// False where it was there already.
  bool add(std::int32_t number) {
    if (contains(number)) return false;
    places_[number] = static_cast<std::int32_t>(members_.size());
    members_.push_back(number);
    return true;
  }
  [[nodiscard]] std::span<const std::int32_t> members() const { return members_; }

 private:
  std::vector<std::int32_t> places_, members_;
};

}  // namespace planish
