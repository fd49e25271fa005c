// measure PROGRAM ARGUMENT...: runs it, ends as it does, and writes its peak of memory in bytes, or
// that of the largest program that it started, and their CPU seconds to file 3. What a large
// process starts itself is counted with the memory of that process.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>

int main(int, char** arguments) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::fcntl(3, F_SETFD, FD_CLOEXEC);
    ::execv(arguments[1], arguments + 1);
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  if (::wait4(child, &status, 0, &usage) != child) return 127;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  ::dprintf(3, "%.0f %.6f", 1024.0 * static_cast<double>(usage.ru_maxrss),
            seconds(usage.ru_utime) + seconds(usage.ru_stime));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
}
