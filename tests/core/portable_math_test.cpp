#include "planish/core/portable_math.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace planish {
namespace {

using Wide = long double;
constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Numbers by a generator that the standard defines to the bit; its distributions it does not.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  std::int64_t whole(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }
  // Of either sign and a power of two between.
  double of_size(int low, int high) {
    // One by one: arguments of a call are drawn in any order.
    const double sign = (random_() & 1) == 0 ? 1 : -1;
    const double size = 1 + unit();
    return std::ldexp(sign * size, static_cast<int>(whole(low, high)));
  }
  double near_one() {
    const double part = between(-1, 1);
    return 1 + std::ldexp(part, -static_cast<int>(whole(0, 50)));
  }
  // Beside a multiple of a quarter turn.
  double near_quarter() {
    const double multiple = static_cast<double>(whole(-600'000, 600'000)) * (std::numbers::pi / 2);
    return std::nextafter(multiple, (random_() & 1) == 0 ? kInfinite : -kInfinite);
  }

 private:
  std::mt19937_64 random_;
};

struct Function {
  std::string name;
  std::function<double(double)> own;
  std::function<Wide(Wide)> truth;
  std::vector<std::function<double(Draw&)>> arguments;
};

std::vector<Function> functions() {
  const auto between = [](double low, double high) {
    return [=](Draw& draw) { return draw.between(low, high); };
  };
  const auto sized = [](int low, int high) {
    return [=](Draw& draw) { return draw.of_size(low, high); };
  };
  const auto positive = [](int low, int high) {
    return [=](Draw& draw) { return std::abs(draw.of_size(low, high)); };
  };
  const auto quarters = [](Draw& draw) { return draw.near_quarter(); };
  const auto one = [](Draw& draw) { return draw.near_one(); };
  const auto below_one = [](Draw& draw) { return std::min(draw.near_one(), 1.0); };
  return {
      {"sin",
       portable::sin,
       [](Wide x) { return std::sin(x); },
       {between(-7, 7), sized(-40, 19), quarters}},
      {"cos",
       portable::cos,
       [](Wide x) { return std::cos(x); },
       {between(-7, 7), sized(-40, 19), quarters}},
      {"tan",
       portable::tan,
       [](Wide x) { return std::tan(x); },
       {between(-7, 7), sized(-40, 19), quarters}},
      {"acos", portable::acos, [](Wide x) { return std::acos(x); }, {between(-1, 1), below_one}},
      {"atan",
       portable::atan,
       [](Wide x) { return std::atan(x); },
       {between(-3, 3), sized(-300, 300)}},
      {"exp",
       portable::exp,
       [](Wide x) { return std::exp(x); },
       {between(-700, 700), sized(-40, 2)}},
      {"log",
       portable::log,
       [](Wide x) { return std::log(x); },
       {between(0.3, 3), positive(-1074, 1023), one}},
      {"log2", portable::log2, [](Wide x) { return std::log2(x); }, {positive(-1074, 1023), one}},
      {"log10",
       portable::log10,
       [](Wide x) { return std::log10(x); },
       {positive(-1074, 1023), one}},
  };
}

// In units in the last place of the true value.
double error_of(double value, Wide truth) {
  const double unit = std::ldexp(1.0, std::max(std::ilogb(static_cast<double>(truth)), -1022) - 52);
  return static_cast<double>(std::abs(static_cast<Wide>(value) - truth)) / unit;
}

constexpr double kAllowed = 0.57;
constexpr int kDraws = 100'000;

TEST(PortableMath, IsWithinHalfAUnitInTheLastPlace) {
  if (std::numeric_limits<Wide>::digits < 64) GTEST_SKIP() << "no wider numbers here";
#ifdef _WIN32
  GTEST_SKIP() << "the C library's wider functions, which are compared with, are off by more";
#endif
  for (const Function& function : functions()) {
    Draw draw(1);
    for (const auto& argument : function.arguments) {
      double worst = 0, at = 0;
      for (int i = 0; i < kDraws; ++i) {
        const double x = argument(draw), error = error_of(function.own(x), function.truth(x));
        if (error <= worst) continue;
        worst = error;
        at = x;
      }
      EXPECT_LT(worst, kAllowed) << function.name << " of " << at;
    }
  }
}

TEST(PortableMath, OfTwoAndThreeNumbersToo) {
  if (std::numeric_limits<Wide>::digits < 64) GTEST_SKIP() << "no wider numbers here";
  Draw draw(2);
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw.of_size(-8, 8), y = draw.of_size(-8, 8), z = draw.of_size(-8, 8);
    EXPECT_LT(error_of(portable::atan2(y, x), std::atan2(Wide{y}, Wide{x})), kAllowed) << y << x;
    const Wide square = Wide{x} * x + Wide{y} * y;
    EXPECT_LT(error_of(portable::hypot(x, y), std::sqrt(square)), kAllowed) << x << y;
    EXPECT_LT(error_of(portable::hypot(x, y, z), std::sqrt(square + Wide{z} * z)), kAllowed);
    // Powers near 1: std::pow() of wide numbers loses digits of larger ones.
    const double base = draw.between(0.5, 2), exponent = draw.between(-3, 3);
    EXPECT_LT(error_of(portable::pow(base, exponent), std::pow(Wide{base}, Wide{exponent})),
              kAllowed)
        << base << " to the " << exponent;
  }
}

TEST(PortableMath, WholePowersAndLogarithmsAreExact) {
  for (int i = 0; i <= 22; ++i) {
    double power = 1;
    for (int j = 0; j < i; ++j) power *= 10;
    EXPECT_EQ(portable::pow(10, i), power);
    EXPECT_EQ(portable::log10(power), i);
    EXPECT_EQ(portable::log2(std::ldexp(1.0, 40 * i)), 40 * i);
    EXPECT_EQ(portable::pow(i + 0.25, 2), (i + 0.25) * (i + 0.25));
  }
  EXPECT_EQ(portable::hypot(3, 4), 5);
  EXPECT_EQ(portable::atan2(1, 1), std::numbers::pi / 4);
  EXPECT_EQ(portable::acos(-1), std::numbers::pi);
}

// Equal but for a unit in the last place, signs of zeros included; or both no numbers.
::testing::AssertionResult alike(double value, double standard) {
  const bool are_none = std::isnan(value) && std::isnan(standard);
  const double next = std::nextafter(standard, value);
  const bool is_near =
      (value == standard || next == value) && std::signbit(value) == std::signbit(standard);
  if (are_none || is_near) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << value << " in place of " << standard;
}

TEST(PortableMath, HasTheStandardsSpecialValues) {
  const std::vector<double> values = {0.0,  -0.0,  1,      -1,     kInfinite, -kInfinite,
                                      kNan, 1e308, -1e308, 5e-324, -5e-324,   1e-310,
                                      0.5,  2,     -3,     1e-200, -1e200};
  for (const double x : values) {
    SCOPED_TRACE(x);
    if (!(std::abs(x) > 1e6) || std::isinf(x)) {  // beyond, the period is another
      EXPECT_TRUE(alike(portable::sin(x), std::sin(x)));
      EXPECT_TRUE(alike(portable::cos(x), std::cos(x)));
      EXPECT_TRUE(alike(portable::tan(x), std::tan(x)));
    }
    EXPECT_TRUE(alike(portable::acos(x), std::acos(x)));
    EXPECT_TRUE(alike(portable::atan(x), std::atan(x)));
    EXPECT_TRUE(alike(portable::exp(x), std::exp(x)));
    EXPECT_TRUE(alike(portable::log(x), std::log(x)));
    EXPECT_TRUE(alike(portable::log2(x), std::log2(x)));
    EXPECT_TRUE(alike(portable::log10(x), std::log10(x)));
    for (const double y : values) {
      SCOPED_TRACE(y);
      EXPECT_TRUE(alike(portable::atan2(y, x), std::atan2(y, x)));
      EXPECT_TRUE(alike(portable::hypot(x, y), std::hypot(x, y)));
      if (std::signbit(x)) continue;
      EXPECT_TRUE(alike(portable::pow(x, y), std::pow(x, y)));
    }
  }
  EXPECT_TRUE(std::isnan(portable::pow(-8, 1.0 / 3)));
  EXPECT_EQ(portable::hypot(1e-320, 0, 0), 1e-320);
  EXPECT_EQ(portable::sin(1e300), portable::sin(std::fmod(1e300, 2 * std::numbers::pi)));
}

// On every machine: who changes these bits changes the files of all fits.
TEST(PortableMath, HasTheSameBitsEverywhere) {
  Draw draw(3);
  std::uint64_t hash = 14695981039346656037u;
  const auto add = [&](double value) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211u;
  };
  for (int i = 0; i < kDraws; ++i) {
    const double x = draw.of_size(-20, 9), y = draw.of_size(-20, 9), size = std::abs(x);
    for (const double value :
         {portable::sin(x), portable::cos(x), portable::tan(x), portable::acos(draw.between(-1, 1)),
          portable::atan2(y, x), portable::exp(x), portable::log(size), portable::log2(size),
          portable::log10(size), portable::pow(size, y), portable::hypot(x, y),
          portable::hypot(x, y, 1)})
      add(value);
  }
  EXPECT_EQ(hash, 12732275935415211830u);
}

}  // namespace
}  // namespace planish
