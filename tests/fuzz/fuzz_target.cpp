// A libFuzzer target for the format that the build names in PLANISH_FUZZ_FORMAT, with its enum.
#include <cstdint>

#include "fuzz/fuzz_read.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  planish::test::fuzz_read(std::as_bytes(std::span(data, size)), planish::PLANISH_FUZZ_FORMAT);
  return 0;
}
