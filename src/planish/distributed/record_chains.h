#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace planish {

/// Finds where records of unknown lengths begin in a range of bytes that may begin inside one.
/// Chains of records are followed from every possible first byte; those that meet something
/// impossible end, others soon merge. Which one is true is told by where the first record really
/// begins, which the range before knows: nothing is guessed.
class RecordChains {
 public:
  /// Behind the record at a place, or below 0 where none can be. Places count from the range's
  /// first byte; records may end behind the range.
  using Next = std::function<std::int64_t(std::int64_t)>;

  /// `candidates`: how many of the first bytes may begin a record.
  RecordChains(std::int64_t range_bytes, std::int64_t candidates, const Next& next);

  /// Where the first record at or behind the range's end begins, counted from there, if the first
  /// at or behind the range's begin is at `start`; below 0 where that chain ends before.
  [[nodiscard]] std::int64_t overhang(std::int64_t start) const;

 private:
  struct Chain {
    std::int64_t end = -1;
    std::int32_t joined = -1;  ///< the chain that it merged with
  };
  std::int64_t range_bytes_;
  std::vector<Chain> chains_;
};

}  // namespace planish
