#include "planish/core/error.h"

#include <gtest/gtest.h>

#include <concepts>
#include <limits>
#include <string>

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

}  // namespace
}  // namespace planish
