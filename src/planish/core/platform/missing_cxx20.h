#pragma once

// What planish uses of C++20 and LLVM's C++ library lacks: std::atomic_ref before 19, numbers of
// std::from_chars() and std::jthread before 20 (from 18 on it is there for those who ask). The
// root's CMakeLists.txt has it included before everything else.

#ifdef __cplusplus
#include <atomic>
#include <charconv>
#include <clocale>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <type_traits>
#if defined(__APPLE__)
#include <xlocale.h>
#endif

namespace std {

#ifndef __cpp_lib_atomic_ref
// In the strictest order, whichever is asked for.
template <class T>
class atomic_ref {
 public:
  explicit atomic_ref(T& value) : value_(&value) {}
  void store(T value, memory_order = memory_order_seq_cst) const {
    __atomic_store_n(value_, value, __ATOMIC_SEQ_CST);
  }
  T load(memory_order = memory_order_seq_cst) const {
    return __atomic_load_n(value_, __ATOMIC_SEQ_CST);
  }
  T fetch_add(T by, memory_order = memory_order_seq_cst) const {
    return __atomic_fetch_add(value_, by, __ATOMIC_SEQ_CST);
  }
  T fetch_or(T bits, memory_order = memory_order_seq_cst) const {
    return __atomic_fetch_or(value_, bits, __ATOMIC_SEQ_CST);
  }
  bool compare_exchange_strong(T& expected, T desired, memory_order = memory_order_seq_cst,
                               memory_order = memory_order_seq_cst) const {
    return __atomic_compare_exchange_n(value_, &expected, desired, false, __ATOMIC_SEQ_CST,
                                       __ATOMIC_SEQ_CST);
  }
  bool compare_exchange_weak(T& expected, T desired, memory_order = memory_order_seq_cst,
                             memory_order = memory_order_seq_cst) const {
    return __atomic_compare_exchange_n(value_, &expected, desired, true, __ATOMIC_SEQ_CST,
                                       __ATOMIC_SEQ_CST);
  }

 private:
  T* value_;
};
template <class T>
atomic_ref(T&) -> atomic_ref<T>;
#endif

#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 200000
// Waited for at its end; nobody asks one to stop.
class jthread : public thread {
 public:
  using thread::thread;
  jthread(jthread&&) noexcept = default;
  jthread& operator=(jthread&&) = delete;
  ~jthread() {
    if (joinable()) join();
  }
};
#endif

#if !defined(__cpp_lib_to_chars) && _LIBCPP_VERSION < 200000
// By the C library's strtod(), which rounds correctly, with a point whatever the locale has; what
// that takes and from_chars() does not (blanks, a plus, hexadecimal digits) is refused or ended
// here.
template <class Float>
requires is_floating_point_v<Float> from_chars_result from_chars(const char* first,
                                                                 const char* last, Float& value) {
  constexpr string_view kParts = "0123456789+-.eEinfatyINFATY()_";
  const char* end = first;
  while (end != last && kParts.find(*end) != string_view::npos) ++end;
  const char* digits = first + (first != end && *first == '-');
  if (digits == end || *digits == '+' || *digits == '-') return {first, errc::invalid_argument};
  const string text(first, end);
  char* parsed = nullptr;
  Float number{};
  static const locale_t kPlain = newlocale(LC_ALL_MASK, "C", locale_t{});
  if constexpr (is_same_v<Float, float>) {
    number = strtof_l(text.c_str(), &parsed, kPlain);
  } else {
    number = strtod_l(text.c_str(), &parsed, kPlain);
  }
  if (parsed == text.c_str()) return {first, errc::invalid_argument};
  const char* stop = first + (parsed - text.c_str());
  const Float size = number < 0 ? -number : number;
  const bool is_named = (*digits | 32) == 'i' || (*digits | 32) == 'n';
  // Too large, or of digits that are not all 0 and yet too small.
  if (!is_named && size == __builtin_huge_val()) return {stop, errc::result_out_of_range};
  if (size == 0) {
    for (const char* at = digits; at != stop && (*at | 32) != 'e'; ++at)
      if (*at >= '1' && *at <= '9') return {stop, errc::result_out_of_range};
  }
  value = number;
  return {stop, errc()};
}
#endif

}  // namespace std
#endif
