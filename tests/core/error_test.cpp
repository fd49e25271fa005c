#include "planish/core/error.h"

#include <gtest/gtest.h>

#include <functional>
#include <new>
#include <string>
#include <vector>

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
