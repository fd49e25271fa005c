#include <gtest/gtest.h>

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <random>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/words.h"

namespace planish::test {
namespace {

struct Said {
  std::optional<ErrorCode> code;
  std::string message;
  std::int64_t element = 0;
};

Said said_of(const std::function<void()>& work) {
  try {
    work();
  } catch (...) {
    const Failure failure = current_failure("no room");
    return {failure.code, failure.message, failure.element};
  }
  return {};
}

TEST(CurrentFailure, IsAnErrorAsItIs) {
  const Said said = said_of([] { throw Error(ErrorCode::DeviceLost, "gone", 7); });
  EXPECT_EQ(said.code, ErrorCode::DeviceLost);
  EXPECT_EQ(said.message, "gone");
  EXPECT_EQ(said.element, 7);
}

TEST(CurrentFailure, IsOutOfMemoryWhereNothingCanHoldTheArray) {
  const auto beyond_memory = [] {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    throw std::bad_alloc();  // a sanitizer's operator new ends the process instead
#else
    const volatile std::size_t count = static_cast<std::size_t>(-1) / 16;
    double* volatile array = new double[count];  // which Clang would leave out else
    delete[] array;
#endif
  };
  const auto beyond_counting = [] {
    const volatile std::size_t count = static_cast<std::size_t>(-1);
    std::vector<double>().reserve(count);
  };
  for (const std::function<void()>& work :
       {std::function<void()>(beyond_memory), {beyond_counting}}) {
    const Said said = said_of(work);
    EXPECT_EQ(said.code, ErrorCode::OutOfMemory);
    EXPECT_EQ(said.message, "no room");
    EXPECT_EQ(said.element, Error::kNoElement);
  }
}

TEST(CurrentFailure, IsAFaultOfOursElse) {
  const Said logic = said_of([] { throw std::logic_error("odd"); });
  EXPECT_FALSE(logic.code);
  EXPECT_EQ(logic.message, "odd");
  const Said foreign = said_of([] { throw 3; });
  EXPECT_FALSE(foreign.code);
  EXPECT_EQ(foreign.message, "an unknown exception");
}

}  // namespace
}  // namespace planish::test

namespace planish {
namespace {

template <class Number>
class FormattedNumber : public testing::Test {};
using Numbers = testing::Types<signed char, unsigned char, short, unsigned short, int, unsigned,
                               long, unsigned long, long long, unsigned long long>;
TYPED_TEST_SUITE(FormattedNumber, Numbers);

TYPED_TEST(FormattedNumber, ReadsAsTheStandardLibraryWritesIt) {
  using Limits = std::numeric_limits<TypeParam>;
  for (const TypeParam number : {Limits::min(), TypeParam(Limits::min() + 1), TypeParam(-1),
                                 TypeParam(0), TypeParam(7), TypeParam(100), Limits::max()})
    EXPECT_EQ(formatted("{}", number), std::to_string(number));
}

TEST(Formatted, TakesTextsOfAllKinds) {
  const std::string name = "bust.obj";
  const std::string_view part = std::string_view(name).substr(0, 4);
  EXPECT_EQ(formatted("{}: {} of {}{}", name, part, "it", std::string("!")),
            "bust.obj: bust of it!");
  EXPECT_EQ(formatted("nothing"), "nothing");
  EXPECT_EQ(formatted("{}", ""), "");
  EXPECT_EQ(formatted("{}{}", std::string(1, '\0'), 1), std::string("\0001", 2));
}

// What values hold is no format.
TEST(Formatted, LeavesOtherBracesAsTheyAre) {
  EXPECT_EQ(formatted("{ } {{}} }{ {}", "{}", 5), "{ } {{}} }{ 5");
}

TEST(Formatted, RefusesWhatCouldBeReadInTwoWays) {
  EXPECT_FALSE((std::constructible_from<Formattable, char>));
  EXPECT_FALSE((std::constructible_from<Formattable, bool>));
  EXPECT_FALSE((std::constructible_from<Formattable, double>));
  EXPECT_FALSE((std::constructible_from<Formattable, float>));
}

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

TEST(VisibleText, LeavesLettersOfAllTonguesAlone) {
  for (const char* text : {"goblet.obj", "K\xC3\xA4se \xF0\x9F\xA7\x80.obj", "a\\b 'c' \"d\"", ""})
    EXPECT_EQ(visible(std::string_view(text)), text);
}

TEST(VisibleText, ShowsWhatATerminalWouldObey) {
  EXPECT_EQ(visible(std::string_view("\x1b[31mred")), "\\x1b[31mred");
  EXPECT_EQ(visible(std::string_view("a\nb\rc\td\x7F")), "a\\nb\\rc\\td\\x7f");
  EXPECT_EQ(visible(std::string_view("\xC2\x9B"
                                     "31m")),
            "\\u009b31m");  // the 8-bit CSI
}

TEST(VisibleText, ShowsWhatTurnsOrHidesLetters) {
  EXPECT_EQ(visible(std::string_view("a\xE2\x80\xAE"
                                     "b")),
            "a\\u202eb");  // right-to-left override
  EXPECT_EQ(visible(std::string_view("a\xE2\x80\x8B"
                                     "b")),
            "a\\u200bb");  // no width
  EXPECT_EQ(visible(std::string_view("\xEF\xBB\xBF")), "\\ufeff");
  EXPECT_EQ(visible(std::string_view("\u00AD\u3164\uFE0F")), "\\u00ad\\u3164\\ufe0f");
  EXPECT_EQ(visible(std::string_view("\U000E0041")), "\\u{e0041}");      // a tag
  EXPECT_EQ(visible(std::string_view("\xE2\x80\x93")), "\xE2\x80\x93");  // a dash stays
}

TEST(VisibleText, ShowsBytesThatAreNoUtf8) {
  EXPECT_EQ(visible(std::string_view("\xFFz")), "\\xffz");
  EXPECT_EQ(visible(std::string_view("\xC3")), "\\xc3");
}

TEST(VisibleText, LinesStayWhereSeveralAreMeant) {
  EXPECT_EQ(visible_lines("a\n  b\x1b\n"), "a\n  b\\x1b\n");
}

TEST(VisibleText, LinesOfFilesHoldNoLineEndsOfAnyReader) {
  EXPECT_EQ(without_controls("a\u2028b\u2029c\u0085d\ne\x1b", '_'), "a_b_c_d_e_");
  EXPECT_EQ(without_controls("\u202ab\u202e\u2066d\u2069", '?'), "?b??d?");
  // A joiner, a mark, a dash, a space, a letter of Latin-1 by itself.
  for (const char* text : {"\u200d", "\u200f", "\u2027 \u2013", "\u202f", "K\xE4se", ""})
    EXPECT_EQ(without_controls(text, '_'), text);
}

// Messages quote what came from outside; Python can take them as text only if they are UTF-8.
TEST(Error, SaysNothingUnseen) {
  const std::string seen =
      Error(ErrorCode::UnreadableInput, "a\xff\x1b[31m:\n\xe2\x80\xae b").what();
  EXPECT_EQ(seen, "a\\xff\\x1b[31m:\n\\u202e b");
}

}  // namespace
}  // namespace planish
