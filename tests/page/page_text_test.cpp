#include "planish/job/page/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace planish {
namespace {

TEST(PageText, WhatCannotBeSeenIsMadeVisible) {
  EXPECT_EQ(visible_text("a\x1b[31mb\n\t"), "a\\u001b[31mb\\u000a\\u0009");
  EXPECT_EQ(visible_text("\u202e\u200b\ufeff\u2028\u00ad\u0085"),
            "\\u202e\\u200b\\ufeff\\u2028\\u00ad\\u0085");
  EXPECT_EQ(visible_text("\U000e0041"), "\\u{e0041}");
  EXPECT_EQ(visible_text("gr\u00fc\u00dfe \u4e2d \U0001f600"), "gr\u00fc\u00dfe \u4e2d \U0001f600");
}

TEST(PageText, BytesThatAreNoUtf8AreMadeVisible) {
  EXPECT_EQ(visible_text("a\xff\xc3"), "a\\xff\\xc3");
  EXPECT_EQ(visible_text("\xc0\x80"), "\\xc0\\x80");                    // overlong
  EXPECT_EQ(visible_text("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(visible_text("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond Unicode
}

TEST(PageText, HtmlHasNoMarkupLeft) {
  EXPECT_EQ(html_text("\"><script>'`&"), "&#34;&#62;&#60;script&#62;&#39;&#96;&#38;");
  EXPECT_EQ(html_lines("a<\nb"), "a&#60;\nb");
  EXPECT_EQ(html_text("a\nb"), "a\\u000ab");
}

TEST(PageText, JsonCannotEndItsElement) {
  const nlohmann::ordered_json value = {{"</script>", "<!--&\u2028"}};
  const std::string text = script_json(value);
  EXPECT_EQ(text.find_first_of("<>&"), std::string::npos);
  EXPECT_EQ(nlohmann::ordered_json::parse(text), value);
}

TEST(PageText, JsonStringsAreMadeVisibleAtAnyDepth) {
  const nlohmann::ordered_json value = {{"a\u202e", {1, "b\u200b", {{"c", "\x07"}}}}};
  EXPECT_EQ(visible_json(value).dump(), R"({"a\\u202e":[1,"b\\u200b",{"c":"\\u0007"}]})");
}

TEST(PageText, WordsOfACommandAreQuoted) {
  EXPECT_EQ(shell_word("out/a-b_c.glb"), "out/a-b_c.glb");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("`$(id)`'"), "'`$(id)`'\\'''");
}

TEST(PageText, FiguresHaveThreeDigits) {
  EXPECT_EQ(figure(1.9949e-7), "1.99e-07");
  EXPECT_EQ(figure(0.35349), "0.353");
  EXPECT_EQ(figure(999.9), "1,000");
  EXPECT_EQ(figure(-69741.0), "-69,700");
  EXPECT_EQ(figure(1.5e6), "1.5e+06");
  EXPECT_EQ(figure(std::numeric_limits<double>::infinity()), "not finite");
  EXPECT_EQ(figure(nlohmann::ordered_json()), "not finite");
}

}  // namespace
}  // namespace planish
