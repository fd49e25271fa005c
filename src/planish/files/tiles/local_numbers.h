#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "planish/core/raw_vector.h"

namespace planish {

/// Which numbers occur, by words of 64 that follow one another: rows come in runs, so that words
/// are few, and who looks for one finds it in a near cache.
class NumberWords {
 public:
  NumberWords() : table_(1024) {}

  /// Notes a number and returns its word's slot.
  std::int32_t note(std::int32_t number) {
    const std::int32_t word = number >> kBits;
    if (word != last_word_) {
      last_slot_ = slot_of(word);
      last_word_ = word;
    }
    masks_[last_slot_] |= std::uint64_t{1} << (number & kMask);
    return last_slot_;
  }

  /// All numbers, ascending; from now on place() knows theirs.
  RawVector<std::int32_t> sort() {
    const RawVector<std::int32_t> order = slots_by_word();
    first_.resize(words_.size());
    std::int32_t count = 0;
    for (const std::int32_t slot : order) {
      first_[slot] = count;
      count += std::popcount(masks_[slot]);
    }
    RawVector<std::int32_t> found;
    found.reserve(static_cast<std::size_t>(count));
    for (const std::int32_t slot : order)
      for (std::uint64_t left = masks_[slot]; left != 0; left &= left - 1)
        found.push_back((words_[slot] << kBits) + std::countr_zero(left));
    return found;
  }

  /// The place of a noted number among all, behind sort().
  [[nodiscard]] std::int32_t place(std::int32_t number, std::int32_t slot) const {
    const std::uint64_t below = (std::uint64_t{1} << (number & kMask)) - 1;
    return first_[slot] + std::popcount(masks_[slot] & below);
  }

 private:
  static constexpr int kBits = 6;
  static constexpr std::int32_t kMask = (1 << kBits) - 1;

  struct Entry {
    std::int32_t word = -1, slot = 0;
  };

  std::int32_t slot_of(std::int32_t word) {
    Entry* entry = &entry_of(word);
    if (entry->word >= 0) return entry->slot;
    // At most half full.
    if (2 * (words_.size() + 1) > table_.size()) {
      table_.assign(2 * table_.size(), {});
      for (std::size_t i = 0; i < words_.size(); ++i)
        entry_of(words_[i]) = {words_[i], static_cast<std::int32_t>(i)};
      entry = &entry_of(word);
    }
    *entry = {word, static_cast<std::int32_t>(words_.size())};
    words_.push_back(word);
    masks_.push_back(0);
    return entry->slot;
  }

  // Open addressing; where runs lie is mixed, for they begin at multiples of each other's lengths.
  Entry& entry_of(std::int32_t word) {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;  // 2^64 over the golden ratio
    const std::size_t mask = table_.size() - 1;
    std::size_t at = static_cast<std::uint64_t>(word) * kGolden >> 32 & mask;
    while (table_[at].word >= 0 && table_[at].word != word) at = (at + 1) & mask;
    return table_[at];
  }

  // By digits of words, which have 25 bits, the least first.
  [[nodiscard]] RawVector<std::int32_t> slots_by_word() const {
    constexpr int kDigitBits = 9, kDigits = 3;
    constexpr std::size_t kBuckets = std::size_t{1} << kDigitBits;
    RawVector<std::int32_t> order(words_.size()), other(words_.size());
    std::iota(order.begin(), order.end(), 0);
    for (int d = 0; d < kDigits; ++d) {
      std::vector<std::size_t> places(kBuckets + 1, 0);
      const auto digit = [&](std::int32_t slot) {
        return static_cast<std::size_t>(words_[slot] >> (d * kDigitBits)) & (kBuckets - 1);
      };
      for (const std::int32_t slot : order) ++places[digit(slot) + 1];
      std::partial_sum(places.begin(), places.end(), places.begin());
      for (const std::int32_t slot : order) other[places[digit(slot)]++] = slot;
      order.swap(other);
    }
    return order;
  }

  std::vector<Entry> table_;
  RawVector<std::int32_t> words_, first_;
  RawVector<std::uint64_t> masks_;
  std::int32_t last_word_ = -1, last_slot_ = 0;
};

/// Replaces numbers (of rows, not negative) by their places among those that occur, which it
/// returns in ascending order.
[[nodiscard]] inline RawVector<std::int32_t> make_local(std::span<std::int32_t> numbers) {
  NumberWords words;
  RawVector<std::int32_t> slots(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) slots[i] = words.note(numbers[i]);
  RawVector<std::int32_t> found = words.sort();
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = words.place(numbers[i], slots[i]);
  return found;
}

}  // namespace planish
