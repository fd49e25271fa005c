// measure PROGRAM ARGUMENT...: runs it, ends as it does, and writes its peak of memory in bytes and
// its CPU seconds, both with what it started itself, to file 3. What a large process starts itself
// is counted with the memory of that process.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

namespace {

double proportional_bytes(const std::string& process) {
  std::ifstream rollup(process + "/smaps_rollup");
  for (std::string word; rollup >> word;) {
    double kibibytes = 0;
    // Shared pages by shares, so that a library counts once.
    if (word == "Pss:" && rollup >> kibibytes) return 1024 * kibibytes;
  }
  return 0;
}

// What a process and those that it started hold now; 0 for what has ended meanwhile.
double process_tree_bytes(pid_t id) {
  const std::string process = "/proc/" + std::to_string(id);
  double bytes = proportional_bytes(process);
  std::error_code gone;
  for (auto task = std::filesystem::directory_iterator(process + "/task", gone);
       !gone && task != std::filesystem::directory_iterator(); task.increment(gone)) {
    std::ifstream children(task->path() / "children");
    for (pid_t child = 0; children >> child;) bytes += process_tree_bytes(child);
  }
  return bytes;
}

}  // namespace

int main(int, char** arguments) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::fcntl(3, F_SETFD, FD_CLOEXEC);
    ::execv(arguments[1], arguments + 1);
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  // The kernel has each process's own peak; of all together there are samples.
  double together = 0;
  pid_t ended = 0;
  while ((ended = ::wait4(child, &status, WNOHANG, &usage)) == 0) {
    together = std::max(together, process_tree_bytes(child));
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (ended != child) return 127;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  ::dprintf(3, "%.0f %.6f", std::max(together, 1024.0 * static_cast<double>(usage.ru_maxrss)),
            seconds(usage.ru_utime) + seconds(usage.ru_stime));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
}
