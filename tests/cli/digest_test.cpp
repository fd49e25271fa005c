#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "planish/job/digest.h"

namespace planish::command {
namespace {

TEST(Digest, IsThatOfTheStandard) {
  EXPECT_EQ(sha256(std::as_bytes(std::span(std::string_view("abc")))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-4
}

// Around every place of the padding, and cut at every place of a block.
TEST(Digest, PlainOneIsThatOfTheLibrary) {
  std::vector<std::byte> bytes;
  for (int i = 0; i < 300; ++i) bytes.push_back(static_cast<std::byte>(i * 7919 >> 3));
  for (std::size_t size = 0; size <= bytes.size(); ++size) {
    const std::span<const std::byte> all = std::span(bytes).first(size);
    PlainSha256 plain;
    plain.add(all.first(size * 3 / 7));
    plain.add(all.subspan(size * 3 / 7));
    ASSERT_EQ(plain.finish(), sha256_bytes(all)) << size;
  }
}

}  // namespace
}  // namespace planish::command
