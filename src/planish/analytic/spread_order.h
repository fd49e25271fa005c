#pragma once

#include <cstddef>
#include <numeric>

namespace planish {

/// Numbers below a count, each once, the first ones from all over: by steps of the golden section.
class SpreadOrder {
 public:
  explicit SpreadOrder(std::size_t count)
      : count_(count), step_(static_cast<std::size_t>(0.618 * static_cast<double>(count)) + 1) {
    while (std::gcd(step_, count_) != 1) ++step_;
  }
  [[nodiscard]] std::size_t operator[](std::size_t i) const { return i * step_ % count_; }

 private:
  std::size_t count_, step_;
};

}  // namespace planish
