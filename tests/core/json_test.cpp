// JSON is taken apart without memory.
#include "planish/core/json.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <new>
#include <string>

#include "support/failing_memory.h"

namespace planish {
namespace {

template <class Json>
class JsonOfBothOrders : public testing::Test {};
using Kinds = testing::Types<nlohmann::json, nlohmann::ordered_json>;
TYPED_TEST_SUITE(JsonOfBothOrders, Kinds);

// Arrays and objects in turn, each with members before and behind the one that is nested.
template <class Json>
std::unique_ptr<Json> nested(int depth) {
  auto root = std::make_unique<Json>();
  Json* at = root.get();
  for (int i = 0; i < depth; ++i) {
    if (i % 2 == 0) {
      *at = {{"a", std::string(40, 'a')}, {"b", nullptr}, {"c", {Json::object(), 3}}};
      at = &(*at)["b"];
    } else {
      *at = {Json{{"d", {1, "two"}}}, nullptr, 0.5};
      at = &(*at)[1];
    }
  }
  return root;
}

TYPED_TEST(JsonOfBothOrders, GoWithoutMemory) {
  auto document = nested<TypeParam>(20);
  EXPECT_GT(document->dump().size(), 500u);
  EXPECT_FALSE(test::with_failing_request(0, [&] { document.reset(); }));
}

TYPED_TEST(JsonOfBothOrders, GoHoweverDeep) {
  auto document = nested<TypeParam>(300'000);
  EXPECT_FALSE(test::with_failing_request(0, [&] { document.reset(); }));
}

// A value whose own memory could not be had is none that can be asked for members.
TYPED_TEST(JsonOfBothOrders, GoHalfMade) {
  for (std::int64_t n = 0;; ++n) {
    bool has_ended = false;
    const bool has_failed = test::with_failing_request(n, [&] {
      try {
        TypeParam value;
        value["a long key that takes memory of its own"]["b"].push_back({{"c", {1, 2, "three"}}});
        has_ended = true;
      } catch (const std::bad_alloc&) {
      }
    });
    if (!has_failed) break;
    EXPECT_FALSE(has_ended) << n;
  }
}

}  // namespace
}  // namespace planish
