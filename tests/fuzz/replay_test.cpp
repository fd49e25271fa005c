// The committed corpus through the functions that the fuzzers call.
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "fuzz/fuzz_targets.h"
#include "planish/files/read_file.h"

namespace planish {

namespace test {
void PrintTo(const FuzzTarget& target, std::ostream* out) { *out << target.name; }
}  // namespace test

namespace {

class FuzzCorpus : public testing::TestWithParam<test::FuzzTarget> {};

TEST_P(FuzzCorpus, KeepsItsPromises) {
  for (const std::string& name : GetParam().folders) {
    const std::filesystem::path folder = std::filesystem::path(PLANISH_FUZZ_CORPUS) / name;
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path());
      GetParam().read(read_file(entry.path()), GetParam().format);
      ++count;
    }
    EXPECT_GT(count, 0) << folder;
  }
}

INSTANTIATE_TEST_SUITE_P(Of, FuzzCorpus, testing::ValuesIn(test::fuzz_targets()),
                         [](const auto& target) { return target.param.name; });

}  // namespace
}  // namespace planish
