#pragma once

// What planish uses of C++20 and libc++ 18 lacks; included before everything else. Without threads
// an atomic reference is a plain one.

#ifdef __cplusplus
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace std {

#ifndef __cpp_lib_atomic_ref
template <class T>
class atomic_ref {
 public:
  explicit atomic_ref(T& value) : value_(&value) {}
  void store(T value, memory_order = memory_order_seq_cst) const { *value_ = value; }
  T load(memory_order = memory_order_seq_cst) const { return *value_; }
  T fetch_add(T by, memory_order = memory_order_seq_cst) const {
    const T before = *value_;
    *value_ = static_cast<T>(before + by);
    return before;
  }
  T fetch_or(T bits, memory_order = memory_order_seq_cst) const {
    const T before = *value_;
    *value_ = static_cast<T>(before | bits);
    return before;
  }
  bool compare_exchange_strong(T& expected, T desired, memory_order = memory_order_seq_cst,
                               memory_order = memory_order_seq_cst) const {
    const bool equal = *value_ == expected;
    (equal ? *value_ : expected) = equal ? desired : *value_;
    return equal;
  }
  bool compare_exchange_weak(T& expected, T desired, memory_order success = memory_order_seq_cst,
                             memory_order failure = memory_order_seq_cst) const {
    return compare_exchange_strong(expected, desired, success, failure);
  }

 private:
  T* value_;
};
template <class T>
atomic_ref(T&) -> atomic_ref<T>;
#endif

#ifndef __cpp_lib_to_chars
// By musl's strtod, which rounds correctly; what that takes and from_chars() does not (blanks, a
// plus, hexadecimal digits) is refused or ended here.
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
  if constexpr (is_same_v<Float, float>) {
    number = strtof(text.c_str(), &parsed);
  } else {
    number = strtod(text.c_str(), &parsed);
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
