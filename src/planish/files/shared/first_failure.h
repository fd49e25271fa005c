#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>

#include "planish/core/error.h"

namespace planish {

/// Of several parts of a file that are read side by side, the failure of the first that is wrong:
/// the one that reading them one after another would meet.
class FirstFailure {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  /// Calls read() unless a part before has failed, and keeps the Error{UnreadableInput} that it
  /// throws.
  template <class Read>
  void watch(std::size_t part, const Read& read) {
    if (part > part_.load(std::memory_order_relaxed)) return;
    try {
      read();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::UnreadableInput) throw;
      const std::lock_guard lock(mutex_);
      if (part >= part_.load(std::memory_order_relaxed)) return;
      part_.store(part, std::memory_order_relaxed);
      failure_ = std::current_exception();
    }
  }

  /// The first part that failed; kNone if none did.
  [[nodiscard]] std::size_t part() const { return part_.load(std::memory_order_relaxed); }
  /// Throws it, if there is one, where the part's elements count from `elements_before`.
  void rethrow(std::int64_t elements_before = 0) const {
    if (!failure_) return;
    try {
      std::rethrow_exception(failure_);
    } catch (const Error& error) {
      if (error.element() < 0 || elements_before == 0) throw;
      throw Error(error.code(), error.what(), error.element() + elements_before);
    }
  }

 private:
  std::mutex mutex_;
  std::atomic<std::size_t> part_{kNone};
  std::exception_ptr failure_;
};

}  // namespace planish
