#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "planish/core/callbacks.h"
#include "planish/core/host_scope.h"
#include "planish/files/formats.h"

namespace planish {

/// How far a file is read: threads count the bytes that they are through with, and the thread that
/// made it tells their share as the step "read", as LoopProgress does. Asks `cancelled` meanwhile.
/// The callbacks must outlive it.
class ReadProgress {
 public:
  /// 0 is told at once.
  ReadProgress(const Callbacks& callbacks, std::size_t byte_count)
      : scope_(callbacks),
        callbacks_(callbacks),
        loop_(callbacks, kStep, 0, 1,
              kUnits * static_cast<std::int64_t>(std::max<std::size_t>(byte_count, 1))) {}

  /// Bytes are counted so often, 1 to 4 times; to be called before the first.
  void expect_passes(int passes) { units_ = kUnits / passes; }
  /// On any thread.
  void add(std::size_t bytes) { loop_.add(units_ * static_cast<std::int64_t>(bytes)); }
  /// All is read: tells 1.
  void finish() const { callbacks_.report(kStep, 1); }

 private:
  static constexpr const char* kStep = "read";
  static constexpr std::int64_t kUnits = 12;  // of a byte: 1, 2, 3 and 4 divide it

  const HostScope scope_;
  const Callbacks& callbacks_;
  LoopProgress loop_;
  std::int64_t units_ = kUnits;
};

/// For readers: where nobody asks, null, nothing is counted.
inline void expect_passes(const FileBytes& file, int passes) {
  if (file.progress != nullptr) file.progress->expect_passes(passes);
}
inline void count_read(ReadProgress* progress, std::size_t bytes) {
  if (progress != nullptr) progress->add(bytes);
}

}  // namespace planish
