// The command's operators new and delete where small blocks begin anywhere, pages' beginnings too,
// on a file system without nameless files.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <filesystem>
#include <memory>
#include <random>
#include <vector>

#include "large_arrays.h"
#include "support/files.h"

// The C library's, but without O_TMPFILE; the linker takes this one.
extern "C" int open(const char* path, int flags, ...) {
  std::va_list more;
  va_start(more, flags);
  const int mode = (flags & O_CREAT) != 0 ? va_arg(more, int) : 0;
  va_end(more);
  if ((flags & O_TMPFILE) == O_TMPFILE) {
    errno = EOPNOTSUPP;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}

namespace planish::test {
namespace {

TEST(LargeArrays, NamesThatBeginAPageDoNotWaitForThemselves) {
  const TemporaryFolder folder;
  command::hold_arrays_within(1, folder.path());
  std::mt19937 random(1);
  std::vector<std::unique_ptr<char[]>> between;
  for (int i = 0; i < 1000; ++i) {
    between.push_back(std::make_unique<char[]>(16 + random() % 64));
    ::operator delete(::operator new(command::kLargeArray));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace planish::test
