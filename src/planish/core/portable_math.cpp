#include "planish/core/portable_math.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace planish::portable {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A sum of two doubles, the second at most half a unit in the last place of the first: about 106
// bits. Source: T. J. Dekker, "A Floating-Point Technique for Extending the Available Precision",
// 1971; D. E. Knuth, "The Art of Computer Programming" 2, 4.2.2.
struct Pair {
  double high = 0, low = 0;

  [[nodiscard]] constexpr double rounded() const { return high + low; }
};

constexpr Pair sum(double a, double b) {
  const double high = a + b, of_b = high - a;
  return {high, (a - (high - of_b)) + (b - of_b)};
}

// Where |a| >= |b|, or a is 0.
constexpr Pair ordered_sum(double a, double b) {
  const double high = a + b;
  return {high, b - (high - a)};
}

// The upper 26 bits, and the rest.
constexpr Pair halves(double a) {
  const double scaled = 0x1.0000002p27 * a, high = scaled - (scaled - a);
  return {high, a - high};
}

constexpr Pair product(double a, double b) {
  const double high = a * b;
  const Pair x = halves(a), y = halves(b);
  return {high, ((x.high * y.high - high) + x.high * y.low + x.low * y.high) + x.low * y.low};
}

constexpr Pair operator-(const Pair& a) { return {-a.high, -a.low}; }

// To two roundings of the lower parts, for what does not cancel below these.
constexpr Pair quick_sum(const Pair& a, const Pair& b) {
  const Pair high = sum(a.high, b.high);
  return ordered_sum(high.high, high.low + (a.low + b.low));
}

constexpr Pair operator+(const Pair& a, const Pair& b) {
  const Pair high = sum(a.high, b.high), low = sum(a.low, b.low);
  const Pair first = ordered_sum(high.high, high.low + low.high);
  return ordered_sum(first.high, first.low + low.low);
}
constexpr Pair operator-(const Pair& a, const Pair& b) { return a + -b; }
constexpr Pair operator*(const Pair& a, const Pair& b) {
  const Pair high = product(a.high, b.high);
  return ordered_sum(high.high, high.low + (a.high * b.low + a.low * b.high));
}
constexpr Pair operator/(const Pair& a, const Pair& b) {
  const double first = a.high / b.high;
  const Pair rest = a - Pair{first, 0} * b;
  return ordered_sum(first, rest.high / b.high);
}

// Tables are made when this is compiled, by series of pairs; steps of a series until no bit of a
// pair changes.

constexpr double kLeastTerm = 0x1p-110;

constexpr double size_of(double x) { return x < 0 ? -x : x; }

// sum of sign^k x^(2k+1) / (2k+1): the area tangent of x, with -1 the arc tangent.
constexpr Pair arc_series(const Pair& x, double sign) {
  const Pair square = x * x;
  Pair result = x, power = x;
  for (int n = 3; size_of(power.high) > kLeastTerm * size_of(x.high); n += 2) {
    power = power * square * Pair{sign, 0};
    result = result + power / Pair{static_cast<double>(n), 0};
  }
  return result;
}

// sum of x^n / n!, from `first` on, of each `step`th with signs that change where step is 2.
constexpr Pair power_series(const Pair& x, int first, int step) {
  Pair term{1, 0};
  for (int n = 1; n <= first; ++n) term = term * x / Pair{static_cast<double>(n), 0};
  Pair result = term;
  for (int n = first; size_of(term.high) > kLeastTerm * size_of(result.high);) {
    for (int i = 0; i < step; ++i) term = term * x / Pair{static_cast<double>(++n), 0};
    if (step == 2) term = -term;
    result = result + term;
  }
  return result;
}

constexpr Pair quotient_of(double a, double b) { return Pair{a, 0} / Pair{b, 0}; }

// Near its multiples nothing but the last part is left of an angle.
constexpr Pair kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
constexpr double kRestOfPi = -0x1.f1976b7ed8fbcp-109;
constexpr Pair kHalfPi{kPi.high / 2, kPi.low / 2};

// log(a / b).
constexpr Pair log_of_quotient(double a, double b) {
  return Pair{2, 0} * arc_series(quotient_of(a - b, a + b), 1);
}
constexpr Pair kLog2 = log_of_quotient(2, 1);
constexpr Pair kPerLog2 = Pair{1, 0} / kLog2;
constexpr Pair kPerLog10 = Pair{1, 0} / (Pair{3, 0} * kLog2 + log_of_quotient(10, 8));

// A number in parts: multiples of the first two, up to 2^25 times, have no rounding.
struct Parts {
  double first, second;
  Pair rest;
};
constexpr Parts parts_of(double high, const Pair& rest) {
  const double first =
      std::bit_cast<double>(std::bit_cast<std::uint64_t>(high) & ~((std::uint64_t{1} << 26) - 1));
  return {first, high - first, rest};
}

// x less the nearest multiple of a step, where that is at most 2^25 times.
struct Reduced {
  std::int64_t count;
  Pair rest;
};
Reduced reduced(double x, double per_step, const Parts& step) {
  const double count = std::floor(x * per_step + 0.5);
  const Pair main = sum(x - count * step.first, -count * step.second);
  const Pair further = product(count, step.rest.high);
  const double least = further.low + count * step.rest.low;
  return {static_cast<std::int64_t>(count), quick_sum(main, {-further.high, -least})};
}

// --- sine and cosine: of the nearest of 128 places around the circle, and of the rest ---

constexpr int kPlaces = 128;
constexpr Pair kPlace{kPi.high / (kPlaces / 2), kPi.low / (kPlaces / 2)};
constexpr Parts kPlaceParts = parts_of(kPlace.high, {kPlace.low, kRestOfPi / (kPlaces / 2)});

struct Turn {
  Pair sine, cosine;
};
constexpr std::array<Turn, kPlaces> kTurns = [] {
  const Turn step{power_series(kPlace, 1, 2), power_series(kPlace, 0, 2)};
  std::array<Turn, kPlaces> turns{};
  turns[0] = {{0, 0}, {1, 0}};
  for (int i = 1; i <= kPlaces / 4; ++i) {
    const Turn& last = turns[i - 1];
    turns[i] = {last.sine * step.cosine + last.cosine * step.sine,
                last.cosine * step.cosine - last.sine * step.sine};
  }
  turns[kPlaces / 4] = {{1, 0}, {0, 0}};
  for (int i = kPlaces / 4 + 1; i < kPlaces; ++i) {
    const Turn& quarter = turns[i - kPlaces / 4];
    turns[i] = {quarter.cosine, -quarter.sine};
  }
  return turns;
}();

// a + b r + c, where c is small beside.
Pair along(const Pair& a, const Pair& b, const Pair& r, double c) {
  const Pair main = product(b.high, r.high), whole = sum(a.high, main.high);
  return ordered_sum(whole.high,
                     whole.low + (main.low + (a.low + (b.low * r.high + (b.high * r.low + c)))));
}

Turn turn_of(double x) {
  constexpr double kFar = 0x1p20;
  if (std::abs(x) > kFar) x = std::fmod(x, 2 * kPi.high);
  const Reduced place = reduced(x, 1 / kPlace.high, kPlaceParts);
  const Turn& at = kTurns[static_cast<std::size_t>(place.count & (kPlaces - 1))];
  const Pair& r = place.rest;
  const double q = r.high * r.high;
  // sin r - r and cos r - 1.
  const double sine = r.high * q * (-1.0 / 6 + q * (1.0 / 120 + q * (-1.0 / 5040 + q / 362880)));
  const double cosine =
      q * (-1.0 / 2 + q * (1.0 / 24 + q * (-1.0 / 720 + q / 40320))) - r.high * r.low;
  return {along(at.sine, at.cosine, r, at.cosine.high * sine + at.sine.high * cosine),
          along(at.cosine, -at.sine, r, at.cosine.high * cosine - at.sine.high * sine)};
}

// --- arc tangent: of the nearest of 129 slopes, and of the rest ---

constexpr int kSlopes = 128;
constexpr std::array<Pair, kSlopes + 1> kAngles = [] {
  std::array<Pair, kSlopes + 1> angles{};
  for (int i = 1; i <= kSlopes; ++i)
    angles[i] =
        angles[i - 1] + arc_series(quotient_of(kSlopes, kSlopes * kSlopes + i * (i - 1)), -1);
  return angles;
}();

// Of 0 <= y <= x, not both 0, without too large or small ones.
inline Pair angle_of(Pair y, Pair x) {
  const double slope = y.high / x.high;
  const Pair back = product(slope, x.high);
  const double lost = (((y.high - back.high) - back.low) + (y.low - slope * x.low)) / x.high;
  // Below it what a slope of the table leaves would be too large a part of the angle.
  constexpr double kFlat = 1.0 / 16;
  if (slope < kFlat) {
    const double q = slope * slope;
    const double rest =
        q * (-1.0 / 3 +
             q * (1.0 / 5 +
                  q * (-1.0 / 7 + q * (1.0 / 9 + q * (-1.0 / 11 + q * (1.0 / 13 - q / 15))))));
    return ordered_sum(slope, lost + slope * rest);
  }
  const int place = static_cast<int>(slope * kSlopes + 0.5);
  const double nearest = static_cast<double>(place) / kSlopes;
  const double t = ((slope - nearest) + lost) / (1 + nearest * slope);
  const double q = t * t;
  const Pair& angle = kAngles[place];
  const Pair whole = ordered_sum(angle.high, t);
  return ordered_sum(whole.high,
                     whole.low + (angle.low + t * q * (-1.0 / 3 + q * (1.0 / 5 - q / 7))));
}

// Of y >= 0, in all four quarters.
inline Pair angle_around(Pair y, Pair x) {
  const Pair along = x.high < 0 ? -x : x;
  const bool is_steep = y.high > along.high;
  Pair angle = is_steep ? quick_sum(kHalfPi, -angle_of(along, y)) : angle_of(y, along);
  if (x.high < 0) angle = quick_sum(kPi, -angle);
  return angle;
}

// --- powers ---

constexpr int kRoots = 64;
constexpr std::array<Pair, kRoots> kRootsOf2 = [] {
  const Pair root = power_series(kLog2 / Pair{kRoots, 0}, 0, 1);
  std::array<Pair, kRoots> roots{};
  roots[0] = {1, 0};
  for (int i = 1; i < kRoots; ++i) roots[i] = roots[i - 1] * root;
  return roots;
}();
constexpr Pair kLogOfRoot{kLog2.high / kRoots, kLog2.low / kRoots};
constexpr Parts kLogOfRootParts = parts_of(kLogOfRoot.high, {kLogOfRoot.low, 0});

// x 2^exponent, where x is of about 1: in less time than ldexp() where it is no least number.
double scaled(double x, std::int64_t exponent) {
  constexpr std::int64_t kMost = 1000, kBias = 1023;
  if (exponent < -kMost || exponent > kMost) return std::ldexp(x, static_cast<int>(exponent));
  return x * std::bit_cast<double>(static_cast<std::uint64_t>(exponent + kBias) << 52);
}

double exp_of(const Pair& x) {
  if (x.high > 710) return kInfinite;
  if (x.high < -746) return 0;
  const Reduced root = reduced(x.high, 1 / kLogOfRoot.high, kLogOfRootParts);
  const double r = root.rest.high;
  const double rest =
      (root.rest.low + x.low) * (1 + r) +
      r * r * (1.0 / 2 + r * (1.0 / 6 + r * (1.0 / 24 + r * (1.0 / 120 + r / 720))));
  const Pair& base = kRootsOf2[static_cast<std::size_t>(root.count & (kRoots - 1))];
  const Pair main = product(base.high, r), whole = ordered_sum(base.high, main.high);
  const double low = whole.low + (main.low + (base.low * (1 + r) + base.high * rest));
  return scaled(whole.high + low, root.count >> 6);
}

// Of 1 to 2, at 27 places up to the root of 2, and of half as much at 38 from there on, so that
// those of 1 are 0.
constexpr int kLogs = 64, kUpperLogs = 91;
constexpr std::array<Pair, kLogs + 1> kLogsOf = [] {
  std::array<Pair, kLogs + 1> logs{};
  for (int i = 1; i <= kLogs; ++i)
    logs[i] = log_of_quotient(kLogs + i, kLogs + i < kUpperLogs ? kLogs : 2 * kLogs);
  return logs;
}();

// Of a positive finite number.
Pair log_of(double x) {
  constexpr std::uint64_t kFraction = (std::uint64_t{1} << 52) - 1;
  constexpr std::uint64_t kOne = std::bit_cast<std::uint64_t>(1.0);
  int exponent = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    exponent = -54;
  }
  const auto bits = std::bit_cast<std::uint64_t>(x);
  double m = std::bit_cast<double>((bits & kFraction) | kOne);  // 1 to 2
  exponent += static_cast<int>(bits >> 52) - 1023;
  const int place = static_cast<int>(m * kLogs + 0.5);
  double at = static_cast<double>(place) / kLogs;
  if (place >= kUpperLogs) {
    m /= 2;
    at /= 2;
    ++exponent;
  }
  // log(m / at) = 2 artanh((m - at) / (m + at)).
  const Pair s = Pair{m - at, 0} / sum(m, at);
  const double q = s.high * s.high;
  const double rest = 2 * s.high * q * (1.0 / 3 + q * (1.0 / 5 + q * (1.0 / 7 + q / 9)));
  const Pair main = Pair{static_cast<double>(exponent), 0} * kLog2 + kLogsOf[place - kLogs];
  return quick_sum(main, ordered_sum(2 * s.high, 2 * s.low + rest));
}

// log(x) / log(base). Where it is no number, or infinite: as the standard has it.
double log_by(double x, const Pair& per_log) {
  if (!(x >= 0)) return kNone;
  if (x == 0) return -kInfinite;
  return x == kInfinite ? x : (log_of(x) * per_log).rounded();
}

// Products of numbers up to this do not overflow, nor are what is left of those of its inverse
// lost.
constexpr double kLarge = 0x1p400;
bool is_extreme(double size) { return size > kLarge || size < 1 / kLarge; }

}  // namespace

double sin(double x) {
  if (!std::isfinite(x)) return kNone;
  return x == 0 ? x : turn_of(x).sine.rounded();
}

double cos(double x) { return std::isfinite(x) ? turn_of(x).cosine.rounded() : kNone; }

double tan(double x) {
  if (!std::isfinite(x)) return kNone;
  if (x == 0) return x;
  const Turn turn = turn_of(x);
  return (turn.sine / turn.cosine).rounded();
}

double acos(double x) {
  if (!(std::abs(x) <= 1)) return kNone;
  const Pair square = sum(1, -x) * sum(1, x);
  if (square.high == 0) return x > 0 ? 0 : kPi.rounded();
  const double root = std::sqrt(square.high);
  const Pair rest = square - product(root, root);
  return angle_around(ordered_sum(root, rest.rounded() / (2 * root)), {x, 0}).rounded();
}

double atan(double x) { return atan2(x, 1); }

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNone;
  double up = std::abs(y), along = std::abs(x);
  if (std::isinf(up) || std::isinf(along)) {
    up = std::isinf(up) ? 1 : 0;
    along = std::isinf(along) ? 1 : 0;
  }
  const bool is_backward = std::signbit(x);
  if (up == 0) return std::copysign(is_backward ? kPi.high : 0.0, y);
  double scaled_up = up, scaled_along = along;
  if (const double largest = std::max(up, along); is_extreme(largest)) {
    const int exponent = std::ilogb(largest);
    scaled_up = std::ldexp(up, -exponent);
    scaled_along = std::ldexp(along, -exponent);
  }
  // Where it is its tangent, and what is left of products would underflow.
  constexpr double kSlight = 0x1p-60;
  if (!is_backward && scaled_up < kSlight * scaled_along) return std::copysign(up / along, y);
  const Pair angle = angle_around({scaled_up, 0}, {is_backward ? -scaled_along : scaled_along, 0});
  return std::copysign(angle.rounded(), y);
}

double exp(double x) { return std::isnan(x) ? kNone : exp_of({x, 0}); }

double log(double x) { return log_by(x, {1, 0}); }
double log2(double x) { return log_by(x, kPerLog2); }
double log10(double x) { return log_by(x, kPerLog10); }

double pow(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (!(x >= 0) || std::isnan(y)) return kNone;
  if (x == 0 || x == kInfinite || std::isinf(y)) {
    const bool grows = std::isinf(y) ? (x > 1) == (y > 0) : (x > 0) == (y > 0);
    return grows ? kInfinite : 0;
  }
  const Pair logarithm = log_of(x);
  constexpr double kMost = 0x1p64;  // beyond it every power but 1's is infinite or 0
  return exp_of(logarithm * Pair{std::clamp(y, -kMost, kMost), 0});
}

double hypot(double x, double y) { return hypot(x, y, 0); }

double hypot(double x, double y, double z) {
  const double largest = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (std::isinf(x) || std::isinf(y) || std::isinf(z)) return kInfinite;
  if (std::isnan(x) || std::isnan(y) || std::isnan(z)) return kNone;
  if (largest == 0) return 0;
  const int exponent = is_extreme(largest) ? std::ilogb(largest) : 0;
  const auto squared = [&](double part) {
    const double scaled = exponent == 0 ? part : std::ldexp(part, -exponent);
    return product(scaled, scaled);
  };
  const Pair square = quick_sum(quick_sum(squared(x), squared(y)), squared(z));
  const double root = std::sqrt(square.high);
  const Pair rest = square - product(root, root);
  const double result = root + rest.rounded() / (2 * root);
  return exponent == 0 ? result : std::ldexp(result, exponent);
}

}  // namespace planish::portable
