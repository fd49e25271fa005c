// libc++'s to_chars() writes doubles that are whole numbers above 2^53 by a function of its own for
// any number of digits, whose tables are 109 kB. Here are all four functions of that object, so
// that this one is linked in its place; to_chars() without a number of digits, which alone is
// called, asks them for nothing else.

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>

namespace std {
inline namespace __2 {

std::to_chars_result __d2fixed_buffered_n(char* first, char* last, double value,
                                          uint32_t decimals) {
  constexpr int kFractionBits = 53;
  // Of the largest double, the least first.
  std::array<char, 309> digits;
  int exponent = 0;
  auto whole = static_cast<uint64_t>(ldexp(frexp(value, &exponent), kFractionBits));
  exponent -= kFractionBits;
  if (decimals != 0 || exponent < 0) __builtin_trap();
  int count = 0;
  for (; whole > 0; whole /= 10) digits[count++] = static_cast<char>(whole % 10);
  for (; exponent > 0; --exponent) {
    int carry = 0;
    for (int i = 0; i < count; ++i) {
      const int doubled = 2 * digits[i] + carry;
      digits[i] = static_cast<char>(doubled % 10);
      carry = doubled / 10;
    }
    if (carry > 0) digits[count++] = static_cast<char>(carry);
  }
  if (last - first < count) return {last, errc::value_too_large};
  while (count > 0) *first++ = static_cast<char>('0' + digits[--count]);
  return {first, errc()};
}

std::to_chars_result __d2exp_buffered_n(char*, char*, double, uint32_t) { __builtin_trap(); }

void __append_n_digits(uint32_t length, uint32_t digits, char* first) {
  for (; length > 0; digits /= 10) first[--length] = static_cast<char>('0' + digits % 10);
}
void __append_nine_digits(uint32_t digits, char* first) { __append_n_digits(9, digits, first); }

}  // namespace __2
}  // namespace std
