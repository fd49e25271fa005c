// A libFuzzer target for the format that the build names in PLANISH_FUZZ_FORMAT, as mesh or points:
// PLANISH_FUZZ_READ.
#include <cstdint>

#include "fuzz/fuzz_command.h"
#include "fuzz/fuzz_read.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)planish::test::PLANISH_FUZZ_READ(std::as_bytes(std::span(data, size)),
                                         planish::FileFormat::PLANISH_FUZZ_FORMAT);
  return 0;
}
