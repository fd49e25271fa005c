#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/job/job_text.h"

#include <gtest/gtest.h>

#include <array>

#include "terminal.h"

namespace planish::command {
namespace {

TEST(Text, NumbersGetSeparators) {
  EXPECT_EQ(with_separators(0), "0");
  EXPECT_EQ(with_separators(999), "999");
  EXPECT_EQ(with_separators(1000), "1,000");
  EXPECT_EQ(with_separators(1234567), "1,234,567");
  EXPECT_EQ(with_separators(-123), "-123");
  EXPECT_EQ(with_separators(-1234), "-1,234");
}

TEST(Text, SizesAndDurationsAreShort) {
  EXPECT_EQ(byte_size(1023), "1023 B");
  EXPECT_EQ(byte_size(1024), "1.0 KiB");
  EXPECT_EQ(byte_size(5ull << 30), "5.0 GiB");
  EXPECT_EQ(duration(0.26), "0.3 ms");
  EXPECT_EQ(duration(12.4), "12 ms");
  EXPECT_EQ(duration(1234), "1.23 s");
  EXPECT_EQ(short_number(4.123e-7), "4.12e-07");
}

TEST(Text, CountsHaveTheirPlural) {
  EXPECT_EQ(counted(1, "face"), "1 face");
  EXPECT_EQ(counted(0, "face"), "0 faces");
  EXPECT_EQ(counted(1200, "face"), "1,200 faces");
}

TEST(Text, PlainUtf8KeepsLettersAndDropsTheRest) {
  EXPECT_EQ(plain_utf8("K\xC3\xA4se \xF0\x9F\xA7\x80"), "K\xC3\xA4se \xF0\x9F\xA7\x80");
  EXPECT_EQ(plain_utf8("a\nb\x7F"), "a?b?");
  EXPECT_EQ(plain_utf8("\xC3"), "?");                 // cut short
  EXPECT_EQ(plain_utf8("\xFFz"), "?z");               // no UTF-8 at all
  EXPECT_EQ(plain_utf8("\xC0\x80"), "??");            // overlong
  EXPECT_EQ(plain_utf8("\xED\xA0\x80"), "???");       // a surrogate
  EXPECT_EQ(plain_utf8("\xF4\x90\x80\x80"), "????");  // beyond Unicode
}

constexpr std::array<std::string_view, 4> kWords{"weights", "tolerance", "levels", "report"};

TEST(Nearest, FindsSlips) {
  EXPECT_EQ(nearest("wieghts", kWords), "weights");      // swapped
  EXPECT_EQ(nearest("tolerence", kWords), "tolerance");  // replaced
  EXPECT_EQ(nearest("level", kWords), "levels");         // missing
  EXPECT_EQ(nearest("reeport", kWords), "report");       // doubled
}

TEST(Nearest, LeavesOtherWordsAlone) {
  EXPECT_EQ(nearest("banana", kWords), std::nullopt);
  EXPECT_EQ(nearest(std::string(100000, 'x'), kWords), std::nullopt);
  EXPECT_EQ(did_you_mean("banana", kWords), "");
}

TEST(Table, AlignsColumnsByCharacters) {
  Table table({{"name"}, {"count", Align::Right}});
  table.add_row({"K\xC3\xA4se", "7"});
  table.add_row({"a", "1,000"});
  EXPECT_EQ(table.text(), "name  count\nK\xC3\xA4se      7\na     1,000\n");
}

}  // namespace
}  // namespace planish::command
