// planish_soak service|edit|host COUNT [FIRST]: see README.md. Exit codes: 0, 1 for faults, 2 for
// use, 77 where there is no device.
#include "soak/soak.h"

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

namespace planish::test {
namespace {
int complaint_count = 0;
volatile std::sig_atomic_t signal_number = 0;
constexpr double kMiB = 1024 * 1024;
}  // namespace

void complain(const std::string& what) {
  ++complaint_count;
  std::fprintf(stderr, "FAULT: %s\n", what.c_str());
}

int complaints() { return complaint_count; }

bool is_stopped() { return signal_number != 0; }

void stop_on_signals() {
  for (const int number : {SIGINT, SIGTERM})
    std::signal(number, [](int given) { signal_number = given; });
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * 4096;
}

std::uint64_t Growth::least(std::size_t quarter) const {
  const std::size_t begin = bytes_.size() * quarter / 4, end = bytes_.size() * (quarter + 1) / 4;
  return begin == end ? 0 : *std::min_element(bytes_.begin() + begin, bytes_.begin() + end);
}

std::uint64_t Growth::bytes(std::size_t since) const {
  const std::uint64_t before = least(since), after = least(3);
  return after > before ? after - before : 0;
}

std::string Growth::text() const {
  std::string text;
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    char part[32];
    std::snprintf(part, sizeof part, "%s%.1f", quarter ? ", " : "",
                  static_cast<double>(least(quarter)) / kMiB);
    text += part;
  }
  return text + " MiB in the quarters";
}

}  // namespace planish::test

namespace {

std::optional<std::uint32_t> number(const char* text) {
  std::uint32_t value = 0;
  const char* const end = text + std::strlen(text);
  const auto read = std::from_chars(text, end, value);
  if (read.ec != std::errc() || read.ptr != end) return {};
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace planish::test;
  const std::optional<std::uint32_t> count = argc > 2 ? number(argv[2]) : std::nullopt;
  const std::optional<std::uint32_t> first = argc > 3 ? number(argv[3]) : 1;
  const bool is_service = argc > 1 && std::strcmp(argv[1], "service") == 0;
  const bool is_edit = argc > 1 && std::strcmp(argv[1], "edit") == 0;
  const bool is_host = argc > 1 && std::strcmp(argv[1], "host") == 0;
  if (argc > 4 || !count || !first || !(is_service || is_edit || is_host)) {
    std::fprintf(stderr, "use: planish_soak service|edit|host COUNT [FIRST]\n");
    return 2;
  }
  if (!is_service) stop_on_signals();
  if (is_service) {
    soak_service(*count, *first);
  } else if (is_edit) {
    soak_edit(*count, *first);
  } else {
#ifdef PLANISH_SOAK_HOST
    if (!soak_host(*count, *first)) return 77;
#else
    std::fprintf(stderr, "This build has no Vulkan.\n");
    return 77;
#endif
  }
  std::printf("%d faults\n", complaints());
  return complaints() == 0 ? 0 : 1;
}
