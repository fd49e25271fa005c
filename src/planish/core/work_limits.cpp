#include "planish/core/work_limits.h"

#include <time.h>

#include <string>

#include "planish/core/error.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"

namespace planish {
namespace {

std::int64_t processor_nanoseconds() {
  timespec now{};
  (void)::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

}  // namespace

LimitScope::LimitScope(const WorkLimits& limits)
    : limits_(limits), stop_(is_over_, this), began_(processor_nanoseconds()) {}

LimitScope* LimitScope::current() {
  const StopScope* const scope = AdoptedStop::current();
  return scope != nullptr ? scope->limits_ : nullptr;
}

void LimitScope::look() {
  constexpr std::chrono::milliseconds kInterval{5};
  if (limits_.cpu_seconds <= 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < kInterval) return;
  last_ = now;
  const auto taken = static_cast<double>(processor_nanoseconds() - began_ +
                                         others_.load(std::memory_order_relaxed));
  if (taken > 1e9 * limits_.cpu_seconds) is_over_ = true;
}

void LimitScope::add_output(std::uint64_t bytes) {
  if (limits_.output_bytes == 0) return;
  const std::uint64_t all = written_.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  if (all <= limits_.output_bytes) return;
  throw Error(ErrorCode::UnwritableOutput,
              formatted("the files have more than the {} that they may; take a coarser level or "
                        "allow more",
                        byte_size(limits_.output_bytes)));
}

CountedTime::CountedTime(LimitScope* limits, const LimitScope* counted)
    : limits_(limits == counted || limits == nullptr || limits->limits_.cpu_seconds <= 0 ? nullptr
                                                                                         : limits) {
  if (limits_ != nullptr) began_ = processor_nanoseconds();
}

CountedTime::~CountedTime() {
  if (limits_ != nullptr)
    limits_->others_.fetch_add(processor_nanoseconds() - began_, std::memory_order_relaxed);
}

}  // namespace planish
