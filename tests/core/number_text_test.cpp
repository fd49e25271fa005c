#include "planish/core/error.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>

namespace planish {
namespace {

TEST(ParseNumber, RoundsAsStrtodDoes) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 200000; ++i) {
    std::string text = random() % 3 == 0 ? "-" : "";
    const std::size_t digits = 1 + random() % 20, point = random() % 22;
    for (std::size_t d = 0; d < digits; ++d) {
      if (d == point) text += '.';
      text += static_cast<char>('0' + random() % 10);
    }
    if (random() % 8 == 0) text += "e" + std::to_string(static_cast<int>(random() % 40) - 20);
    double value = 0;
    ASSERT_TRUE(parse_number(text, value)) << text;
    ASSERT_EQ(std::bit_cast<std::uint64_t>(value),
              std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)))
        << text;
  }
}

TEST(ParseNumber, TakesTheFormsOfStrtodAndNoOthers) {
  double value = 0;
  for (const char* text : {"5", "5.", ".5", "-0", "+2", "+.25", "9007199254740993", "1e3",
                           "00000000000000000000001", "0.00000000000000000000000001"}) {
    ASSERT_TRUE(parse_number(text, value)) << text;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(value),
              std::bit_cast<std::uint64_t>(std::strtod(text, nullptr)))
        << text;
  }
  value = 7;
  for (const char* text : {"", ".", "-", "+", "+-1", "--1", "1.2.3", "1-2", "0x10", "1e", "inf",
                           "nan", "1 ", "1e999"}) {
    EXPECT_FALSE(parse_number(text, value)) << text;
    EXPECT_EQ(value, 7) << text;
  }
}

TEST(NumberText, KnowsWordsForWhatIsNotFinite) {
  for (const char* word :
       {"nan", "NaN", "-NAN", "+nan", "-nan(ind)", "nan(0x7)", "1.#QNAN", "-1.#IND"}) {
    EXPECT_TRUE(is_nan_word(word)) << word;
    EXPECT_TRUE(is_non_finite_word(word)) << word;
  }
  for (const char* word : {"inf", "-Infinity", "+INF", "1.#INF", "-1.#INF00"}) {
    EXPECT_FALSE(is_nan_word(word)) << word;
    EXPECT_TRUE(is_non_finite_word(word)) << word;
  }
  for (const char* word : {"", "-", "nano", "info", "1", "1.#", "nan(", "--nan"})
    EXPECT_FALSE(is_non_finite_word(word)) << word;
}

TEST(NumberText, PercentsHaveNoExponent) {
  EXPECT_EQ(percent(0), "0 %");
  EXPECT_EQ(percent(1), "100 %");
  EXPECT_EQ(percent(0.125), "12.5 %");
  EXPECT_EQ(percent(0.997), "99.7 %");
  EXPECT_EQ(percent(0.9996), "over 99.9 %");  // not all of it
  EXPECT_EQ(percent(0.0000123), "0.00123 %");
  EXPECT_EQ(percent(4.1e-7), "under 0.001 %");
  EXPECT_EQ(percent(15), "1500 %");
  EXPECT_EQ(percent(-0.5), "-50 %");
}

TEST(NumberText, LargeNumbersForPeopleAreWhole) {
  EXPECT_EQ(short_number(999.4), "999");
  EXPECT_EQ(short_number(999.6), "1000");
  EXPECT_EQ(short_number(-12345.6), "-12346");
  EXPECT_EQ(short_number(999999), "999999");
  EXPECT_EQ(short_number(1e6), "1e+06");
  EXPECT_EQ(short_number(4.123e-7), "4.12e-07");
}

TEST(NumberText, SaysWhatAWordMayMean) {
  EXPECT_EQ(no_finite_number("x"), "`x` is no finite number");
  EXPECT_EQ(no_finite_number("+-1"), "`+-1` is no finite number");
  EXPECT_EQ(no_finite_number("-3.1+e2"),
            "`-3.1+e2` is no finite number; write -3.1e+2 if that is meant");
  EXPECT_EQ(no_finite_number("3-e"), "`3-e` is no finite number");
}

}  // namespace
}  // namespace planish
