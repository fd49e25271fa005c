#include "planish/files/readers.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace planish {
namespace {

std::string expand(std::vector<int> data, std::size_t size) {
  std::vector<std::byte> bytes;
  for (const int value : data) bytes.push_back(static_cast<std::byte>(value));
  std::string text;
  for (const std::byte b : expand_lzf(bytes, size)) text += static_cast<char>(b);
  return text;
}

TEST(Lzf, ExpandsLiteralsAndCopies) {
  EXPECT_EQ(expand({2, 'a', 'b', 'c'}, 3), "abc");
  // Copy of length 3 (1 + 2), distance 3.
  EXPECT_EQ(expand({2, 'a', 'b', 'c', 1 << 5, 2}, 6), "abcabc");
  // An overlapping copy repeats: length 7 + 1 + 2, distance 1.
  EXPECT_EQ(expand({0, 'x', 7 << 5, 1, 0}, 11), "xxxxxxxxxxx");
}

TEST(Lzf, RefusesDamagedData) {
  EXPECT_EQ(expand({2, 'a', 'b'}, 3), "");                // literals missing
  EXPECT_EQ(expand({2, 'a', 'b', 'c'}, 2), "");           // too long
  EXPECT_EQ(expand({2, 'a', 'b', 'c'}, 4), "");           // too short
  EXPECT_EQ(expand({0, 'a', 1 << 5, 1}, 4), "");          // from before the beginning
  EXPECT_EQ(expand({0, 'a', 1 << 5}, 4), "");             // distance missing
  EXPECT_EQ(expand({0, 'a', 7 << 5, 9}, 4), "");          // distance missing after a length
  EXPECT_EQ(expand({0, 'a'}, std::size_t{1} << 62), "");  // nothing expands that far
}

TEST(Lzf, SurvivesRandomData) {
  std::mt19937 random(1);
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::byte> data(random() % 64);
    for (std::byte& b : data) b = static_cast<std::byte>(random() % (round % 2 ? 256 : 40));
    const std::size_t size = random() % 300;
    const auto result = expand_lzf(data, size);
    EXPECT_TRUE(result.empty() || result.size() == size);
  }
}

}  // namespace
}  // namespace planish
