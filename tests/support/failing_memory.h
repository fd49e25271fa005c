#pragma once

// For one source of a test program: replaces the operators that take memory by ones that fail when
// they are told to, and that end the program where somebody wrote behind what he took.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>

#include "planish/core/error.h"

namespace {

// Requests until one fails; negative: none does.
thread_local std::int64_t requests_left = -1;

// Bytes of the largest one since a test set it to 0.
[[maybe_unused]] thread_local std::size_t largest_request = 0;

constexpr std::size_t kGuardBytes = 16;  // behind each piece
constexpr unsigned char kGuard = 0xa5;

void* take(std::size_t size, std::size_t alignment) {
  largest_request = std::max(largest_request, size);
  if (requests_left == 0) {
    requests_left = -1;  // what handles the exception takes memory, too
    throw std::bad_alloc();
  }
  if (requests_left > 0) --requests_left;
  const std::size_t whole = size + kGuardBytes;
  void* const place =
      whole < size ? nullptr
      : alignment > alignof(std::max_align_t)
          ? std::aligned_alloc(alignment, (whole + alignment - 1) / alignment * alignment)
          : std::malloc(whole);
  if (place == nullptr) throw std::bad_alloc();
  std::memset(static_cast<unsigned char*>(place) + size, kGuard, kGuardBytes);
  return place;
}

void give_back(void* place, std::size_t size) noexcept {
  if (place == nullptr) return;
  const auto* const guard = static_cast<const unsigned char*>(place) + size;
  if (!std::all_of(guard, guard + kGuardBytes, [](unsigned char byte) { return byte == kGuard; })) {
    std::fprintf(stderr, "somebody wrote behind %zu bytes\n", size);
    std::abort();
  }
  std::free(place);
}

void* take_or_null(std::size_t size, std::size_t alignment) noexcept {
  try {
    return take(size, alignment);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

}  // namespace

void* operator new(std::size_t size) { return take(size, 0); }
void* operator new[](std::size_t size) { return take(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return take(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return take(size, static_cast<std::size_t>(alignment));
}
// The address sanitizer has its own of these, too: all memory is to have a guard.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return take_or_null(size, 0);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return take_or_null(size, 0);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return take_or_null(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return take_or_null(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept { std::free(place); }
void operator delete[](void* place) noexcept { std::free(place); }
void operator delete(void* place, std::size_t size) noexcept { give_back(place, size); }
void operator delete[](void* place, std::size_t size) noexcept { give_back(place, size); }
void operator delete(void* place, std::align_val_t) noexcept { std::free(place); }
void operator delete[](void* place, std::align_val_t) noexcept { std::free(place); }
void operator delete(void* place, std::size_t size, std::align_val_t) noexcept {
  give_back(place, size);
}
void operator delete[](void* place, std::size_t size, std::align_val_t) noexcept {
  give_back(place, size);
}

namespace planish::test {
namespace {

// Calls `work`, whose n-th request for memory fails; counted from 0. Returns whether one did.
bool with_failing_request(std::int64_t n, const std::function<void()>& work) {
  requests_left = n;
  work();
  const bool has_failed = requests_left < 0;
  requests_left = -1;
  return has_failed;
}

// Of the calling thread.
[[maybe_unused]] std::int64_t count_requests(const std::function<void()>& work) {
  constexpr std::int64_t kMany = std::int64_t{1} << 62;
  requests_left = kMany;
  work();
  const std::int64_t count = kMany - requests_left;
  requests_left = -1;
  return count;
}

// Runs `job` again and again, its n-th request for memory failing, until it makes no more of them.
// Returns how many it makes. What can do without (the buffer of a stable sort) may come to its end.
[[maybe_unused]] std::int64_t fail_at_every_request(
    const std::function<void()>& job, const std::function<void(std::int64_t)>& after_failure) {
  for (std::int64_t n = 0;; ++n) {
    bool has_ended = false;
    const bool has_failed = with_failing_request(n, [&] {
      try {
        job();
        has_ended = true;
      } catch (const std::bad_alloc&) {
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::OutOfMemory) << error.what();
      }
    });
    if (has_ended && !has_failed) return n;
    EXPECT_TRUE(has_failed) << "the job ended for another reason";
    if (!has_ended) after_failure(n);
    if (testing::Test::HasFailure()) return n;
  }
}

}  // namespace
}  // namespace planish::test
