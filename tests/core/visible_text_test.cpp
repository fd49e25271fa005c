#include "planish/core/error.h"
#include "planish/core/words.h"

#include <gtest/gtest.h>

namespace planish {
namespace {

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
