// A libFuzzer target for the format that the build names in PLANISH_FUZZ_FORMAT, by the function
// that it names in PLANISH_FUZZ_READ.
#include <oneapi/tbb/global_control.h>

#include <cstdint>

#include "fuzz/fuzz_command.h"
#include "fuzz/fuzz_read.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // What takes several threads would not go the same way twice.
  static const oneapi::tbb::global_control one_thread(
      oneapi::tbb::global_control::max_allowed_parallelism, 1);
  (void)planish::test::PLANISH_FUZZ_READ(std::as_bytes(std::span(data, size)),
                                         planish::FileFormat::PLANISH_FUZZ_FORMAT);
  return 0;
}
