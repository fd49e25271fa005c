#pragma once

namespace planish::portable {

// Elementary functions with the same bits on every processor, system and compiler: those of the
// standard library differ, as they may, by what a processor has and by who wrote them. Made of
// + - * / and sqrt alone, none of them fused. Within 0.57 units in the last place of the true value
// (results below 2^-1022: 0.76), special values as in the standard, errno untouched.

/// Of radians. Beyond 2^20 the period is the double nearest to 2 pi.
[[nodiscard]] double sin(double x);
[[nodiscard]] double cos(double x);
[[nodiscard]] double tan(double x);

/// Radians. acos() of what is beyond -1 and 1 is no number.
[[nodiscard]] double acos(double x);
[[nodiscard]] double atan(double x);
[[nodiscard]] double atan2(double y, double x);

[[nodiscard]] double exp(double x);
[[nodiscard]] double log(double x);
[[nodiscard]] double log2(double x);
[[nodiscard]] double log10(double x);
/// Of x >= 0; of less it is no number, also where `y` is whole.
[[nodiscard]] double pow(double x, double y);

[[nodiscard]] double hypot(double x, double y);
[[nodiscard]] double hypot(double x, double y, double z);

}  // namespace planish::portable
