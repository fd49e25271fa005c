#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace planish {

/// An allocator that leaves elements without a value uninitialised.
template <class T>
struct RawAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = RawAllocator<U>;
  };
  template <class U>
  void construct(U* place) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(place)) U;
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }
};

/// A vector whose resize() leaves numbers uninitialised: for large arrays that threads fill, whose
/// fresh pages are then taken on all threads too.
template <class T>
class RawVector : public std::vector<T, RawAllocator<T>> {
  using Base = std::vector<T, RawAllocator<T>>;

 public:
  using Base::Base;
  using Base::operator=;
  RawVector() = default;
  /// Copies an ordinary vector.
  RawVector(const std::vector<T>& other) : Base(other.begin(), other.end()) {}
  RawVector& operator=(const std::vector<T>& other) {
    this->assign(other.begin(), other.end());
    return *this;
  }
  friend bool operator==(const RawVector& a, const RawVector& b) {
    return static_cast<const Base&>(a) == static_cast<const Base&>(b);
  }
  friend bool operator==(const RawVector& a, const std::vector<T>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }
};

/// A range of rows of a table.
struct RowRange {
  std::int64_t first, count;
};

}  // namespace planish
