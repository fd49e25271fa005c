// Linux, macOS and Emscripten.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#ifdef __EMSCRIPTEN__
#include <emscripten/heap.h>
#include <malloc.h>
#endif

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string_view>

#include "planish/core/platform/files.h"
#include "planish/core/platform/machine.h"
#include "planish/core/platform/process.h"

extern char** environ;

namespace planish::platform {
namespace {

namespace fs = std::filesystem;

std::error_code reason_of(int number) { return {number, std::generic_category()}; }
std::error_code last_reason() { return reason_of(errno); }
std::error_code result_of(int returned) {
  return returned == 0 ? std::error_code() : last_reason();
}

// What a call returned that signals may cut short.
template <class Call>
auto whatever_signals(const Call& call) {
  auto returned = call();
  while (returned < 0 && errno == EINTR) returned = call();
  return returned;
}

File opened(int number, std::error_code& error) {
  error = number < 0 ? last_reason() : std::error_code();
  return File(number);
}

std::size_t count_of(ssize_t returned, std::error_code& error) {
  error = returned < 0 ? last_reason() : std::error_code();
  return static_cast<std::size_t>(std::max<ssize_t>(returned, 0));
}

}  // namespace

std::error_code File::close() {
  const int number = std::exchange(number_, -1);
  return number < 0 ? std::error_code() : result_of(::close(number));
}

File open_to_read(const fs::path& path, std::error_code& error) {
  return opened(::open(path.c_str(), O_RDONLY | O_CLOEXEC), error);
}

File open_regular_to_read(const fs::path& path, std::error_code& error) {
  constexpr int kHow = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW | O_NOCTTY;
  return opened(::open(path.c_str(), kHow), error);
}

File create_new(const fs::path& path, std::error_code& error) {
  // Unlike mkstemp, O_EXCL with mode 0666 leaves the permissions to the user's umask.
  return opened(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666), error);
}

FileFacts facts_of(int file, std::error_code& error) {
  struct stat status {};
  error = result_of(::fstat(file, &status));
  if (error) return {};
  const FileKind kind = S_ISREG(status.st_mode)   ? FileKind::Regular
                        : S_ISDIR(status.st_mode) ? FileKind::Folder
                        : S_ISCHR(status.st_mode) ? FileKind::CharacterDevice
                                                  : FileKind::Other;
  return {.kind = kind, .size = static_cast<std::uint64_t>(status.st_size)};
}

std::size_t read_some(int file, std::span<std::byte> bytes, std::error_code& error) {
  return count_of(whatever_signals([&] { return ::read(file, bytes.data(), bytes.size()); }),
                  error);
}

std::size_t read_at(int file, std::span<std::byte> bytes, std::uint64_t place,
                    std::error_code& error) {
  return count_of(whatever_signals([&] {
                    return ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(place));
                  }),
                  error);
}

std::error_code write_all(int file, std::span<const std::byte> bytes) {
  std::error_code error;
  while (!bytes.empty() && !error)
    bytes = bytes.subspan(count_of(
        whatever_signals([&] { return ::write(file, bytes.data(), bytes.size()); }), error));
  return error;
}

std::error_code set_size(int file, std::uint64_t bytes) {
  return result_of(::ftruncate(file, static_cast<off_t>(bytes)));
}

bool reserve(int file, std::uint64_t bytes, std::error_code& error) {
  error.clear();
#ifdef __linux__
  struct statvfs disk {};
  if (::fstatvfs(file, &disk) == 0 && disk.f_bavail * disk.f_frsize < bytes) {
    // Asked all the same, some systems would fill the disk first.
    error = reason_of(ENOSPC);
    return false;
  }
  const int failed = whatever_signals(
      [&] { return ::fallocate(file, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(bytes)); });
  // Anything else means that this file system has no such call.
  if (failed != 0 && (errno == ENOSPC || errno == EDQUOT)) error = last_reason();
  return failed == 0;
#elif defined(__EMSCRIPTEN__)
  // A file in memory is copied whenever it grows.
  return ::ftruncate(file, static_cast<off_t>(bytes)) == 0;
#else
  (void)file, (void)bytes;
  return false;
#endif
}

std::error_code rename_file(const fs::path& from, const fs::path& to, bool replaces) {
  if (replaces) return result_of(std::rename(from.c_str(), to.c_str()));
#ifdef RENAME_NOREPLACE
  const std::error_code error =
      result_of(::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE));
  if (error != std::errc::invalid_argument && error != std::errc::function_not_supported)
    return error;
#endif
  return link_in_place(from, to);
}

std::error_code link_in_place(const fs::path& from, const fs::path& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return result_of(::unlink(from.c_str()));
  if (errno == EEXIST) return last_reason();
  // Folders have no second names, nor have files everywhere: what comes between these two lines is
  // replaced.
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(to, ignored)))
    return std::make_error_code(std::errc::file_exists);
  return result_of(std::rename(from.c_str(), to.c_str()));
}

std::optional<FileIdentity> identity_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileIdentity{status.st_dev, status.st_ino};
}

fs::path comparable(const fs::path& path) { return path; }

std::string objection_to_name(const fs::path& path) {
  if (path.filename().native().size() <= NAME_MAX) return {};
  return "no file name is longer than " + std::to_string(NAME_MAX) + " bytes; choose a shorter one";
}

fs::path with_end(const fs::path& name, const std::string& end) {
  constexpr std::size_t kShortName = 100;
  std::string text = name;
  if (text.size() > kShortName) {
    std::size_t kept = text.size() - end.size();
    // No character of UTF-8 is cut: some file systems refuse such names.
    while (kept > 0 && (static_cast<unsigned char>(text[kept]) & 0xc0u) == 0x80) --kept;
    text.resize(kept);
  }
  return text + end;
}

std::error_code may_read(const fs::path& path) { return result_of(::access(path.c_str(), R_OK)); }

bool may_write_into(const fs::path& folder) { return ::access(folder.c_str(), W_OK | X_OK) == 0; }

fs::path make_temporary_folder(const fs::path& folder, std::error_code& error) {
  std::string name = folder / ".planish-XXXXXX";
  error = ::mkdtemp(name.data()) == nullptr ? last_reason() : std::error_code();
  if (error) return {};
  try {
    return fs::path(name.c_str());  // copied, for the name is wanted where that fails
  } catch (...) {
    ::rmdir(name.c_str());
    throw;
  }
}

namespace {

// By its name in an open folder.
void remove_at(int folder, const char* name) noexcept {
  if (::unlinkat(folder, name, 0) == 0) return;
  const int opened = ::openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (opened < 0) return;
  DIR* const entries = ::fdopendir(opened);
  if (entries == nullptr) {
    ::close(opened);
    return;
  }
  while (const dirent* const entry = ::readdir(entries)) {
    const std::string_view inside = entry->d_name;
    if (inside != "." && inside != "..") remove_at(opened, entry->d_name);
  }
  ::closedir(entries);
  ::unlinkat(folder, name, AT_REMOVEDIR);
}

}  // namespace

void remove_folder(const fs::path& folder) noexcept { remove_at(AT_FDCWD, folder.c_str()); }

File open_nameless(const fs::path& folder, std::error_code& error) {
#ifdef O_TMPFILE
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  // Some file systems have no such files.
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL))
    return opened(file, error);
#endif
  std::string name = folder / ".planish-XXXXXX";
  File named = opened(::mkostemp(name.data(), O_CLOEXEC), error);
  if (named.is_open()) ::unlink(name.c_str());
  return named;
}

namespace {

#ifndef __EMSCRIPTEN__
std::uint64_t read_number(const char* path) {
  std::uint64_t value = 0;
  std::ifstream file(path);
  return file >> value ? value : std::numeric_limits<std::uint64_t>::max();
}

std::uint64_t page_bytes() {
  static const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return page;
}

// What a limit of the process (ulimit -v) leaves.
std::uint64_t address_space_left() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return std::numeric_limits<std::uint64_t>::max();
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  file >> pages;
  return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, pages * page_bytes());
}
#endif

}  // namespace

std::uint64_t free_memory() {
#ifdef __EMSCRIPTEN__
  return ::emscripten_get_heap_max() - ::mallinfo().uordblks;
#else
  std::uint64_t available = address_space_left();
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  std::uint64_t kibibytes = 0;
  while (file >> key >> kibibytes && std::getline(file, unit)) {
    if (key == "MemAvailable:") available = std::min(available, kibibytes * 1024);
  }
  const std::uint64_t group_limit = read_number("/sys/fs/cgroup/memory.max");
  const std::uint64_t group_used = read_number("/sys/fs/cgroup/memory.current");
  if (group_limit != std::numeric_limits<std::uint64_t>::max() &&
      group_used != std::numeric_limits<std::uint64_t>::max())
    available = std::min(available, group_limit - std::min(group_limit, group_used));
  return available;
#endif
}

std::uint64_t peak_memory() {
#ifdef __linux__
  // What getrusage() says begins with the memory of who started the process.
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word && word != "VmHWM:") {
  }
  if (std::uint64_t kibibytes = 0; status >> kibibytes) return 1024 * kibibytes;
#endif
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#ifdef __APPLE__
  constexpr std::uint64_t kUnit = 1;
#else
  constexpr std::uint64_t kUnit = 1024;
#endif
  return kUnit * static_cast<std::uint64_t>(usage.ru_maxrss);
}

std::uint64_t resident_memory() {
#ifdef __EMSCRIPTEN__
  return 0;
#else
  unsigned long long all = 0, resident = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%llu %llu", &all, &resident) != 2) resident = 0;
    std::fclose(file);
  }
  return page_bytes() * resident;
#endif
}

void keep_freed_memory() {
#ifdef __GLIBC__
  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, -1);
  ::mallopt(M_TOP_PAD, 64 << 20);
#endif
}

void* map_memory(std::size_t bytes) noexcept {
  void* const array =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return array == MAP_FAILED ? nullptr : array;
}

void* map_file(int file, std::size_t bytes, std::error_code& error) noexcept {
#ifdef __APPLE__
  const int failed = ::ftruncate(file, static_cast<off_t>(bytes)) == 0 ? 0 : errno;
#else
  const int failed = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
#endif
  void* const array = failed != 0
                          ? MAP_FAILED
                          : ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  error = array != MAP_FAILED ? std::error_code() : reason_of(failed != 0 ? failed : errno);
  return array == MAP_FAILED ? nullptr : array;
}

void unmap(void* array, std::size_t bytes) noexcept { ::munmap(array, bytes); }

void let_pages_go(void* array, std::size_t bytes) noexcept {
  ::madvise(array, bytes, MADV_DONTNEED);
}

namespace {

std::int64_t nanoseconds_of(clockid_t clock) {
  timespec now{};
  (void)::clock_gettime(clock, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

}  // namespace

std::int64_t thread_nanoseconds() { return nanoseconds_of(CLOCK_THREAD_CPUTIME_ID); }
std::int64_t process_nanoseconds() { return nanoseconds_of(CLOCK_PROCESS_CPUTIME_ID); }

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::vector<std::string> program_arguments(int count, char** arguments) {
  return {arguments, arguments + count};
}

std::optional<std::string> environment(const char* name) {
  const char* const value = std::getenv(name);
  if (value == nullptr) return std::nullopt;
  return value;
}

namespace {

// A byte in it is a note: macOS has no semaphores for this.
int ending_notes[2] = {-1, -1};
#ifndef __EMSCRIPTEN__
void (*note_ending)(int signal) = nullptr;

extern "C" void take_signal(int signal) {
  const int kept = errno;
  note_ending(signal);
  [[maybe_unused]] const ssize_t written = ::write(ending_notes[1], "", 1);
  errno = kept;
}
#endif

}  // namespace

void on_ending(void (*note)(int signal)) {
#ifdef __EMSCRIPTEN__
  (void)note;  // no signal comes
#else
  note_ending = note;
  if (::pipe(ending_notes) == 0)
    for (const int end : ending_notes) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  struct sigaction action {};
  action.sa_handler = take_signal;
  ::sigemptyset(&action.sa_mask);
  // Back to the default after the first, so that the second kills. SA_RESTART: a read or write in
  // progress goes on, and the work stops at its next check.
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
#endif
}

void wait_for_ending() {
  char note = 0;
  if (whatever_signals([&] { return ::read(ending_notes[0], &note, 1); }) != 1) sleep_for_ever();
}

void sleep_for_ever() {
  for (;;) ::pause();
}

void end_by_broken_pipe() {
  std::signal(SIGPIPE, SIG_DFL);
  std::raise(SIGPIPE);
  std::_Exit(128 + SIGPIPE);
}

bool is_terminal(int file) { return ::isatty(file) != 0; }

bool moves_cursor(int file) {
  const char* const term = std::getenv("TERM");
  return is_terminal(file) && term != nullptr && std::string_view(term) != "dumb";
}

std::optional<int> terminal_columns(int file) {
  winsize size{};
  if (::ioctl(file, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return std::nullopt;
  return size.ws_col;
}

std::optional<fs::path> own_program() {
  std::error_code error;
  fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return std::nullopt;
  return program;
}

fs::path program_in(const fs::path& folder, const std::string& name) { return folder / name; }

bool is_program(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error) && ::access(path.c_str(), X_OK) == 0;
}

std::vector<fs::path> program_folders() {
  const char* const path = std::getenv("PATH");
  std::string_view left = path != nullptr ? path : "";
  std::vector<fs::path> folders;
  while (!left.empty()) {
    const std::string_view folder = left.substr(0, left.find(':'));
    left.remove_prefix(std::min(left.size(), folder.size() + 1));
    if (!folder.empty()) folders.emplace_back(folder);
  }
  return folders;
}

struct ChildProcess::System {
  pid_t process = -1;
  File socket;
};

ChildProcess::ChildProcess() : system_(std::make_unique<System>()) {}

ChildProcess::~ChildProcess() {
  (void)system_->socket.close();
  if (system_->process < 0) return;
  ::kill(system_->process, SIGKILL);
  (void)wait_for_end();
}

std::error_code ChildProcess::start(const fs::path& program) {
  int sockets[2];
#ifdef SOCK_CLOEXEC
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0) return last_reason();
#else
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0) return last_reason();
  for (const int socket : sockets) ::fcntl(socket, F_SETFD, FD_CLOEXEC);
  const int on = 1;
  ::setsockopt(sockets[0], SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on);
#endif
  system_->socket = File(sockets[0]);
  const File others(sockets[1]);
  ::fcntl(sockets[0], F_SETFL, O_NONBLOCK);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, sockets[1], kStandardInput);
  ::posix_spawn_file_actions_adddup2(&actions, sockets[1], kStandardOutput);
  std::string name = program;
  char* arguments[] = {name.data(), nullptr};
  const int failed =
      ::posix_spawn(&system_->process, name.c_str(), &actions, nullptr, arguments, environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) system_->process = -1;
  return reason_of(failed);
}

ChildProcess::Ready ChildProcess::wait(bool wants_to_send, int milliseconds,
                                       std::error_code& error) {
  pollfd wanted{.fd = system_->socket.number(), .events = POLLIN, .revents = 0};
  if (wants_to_send) wanted.events |= POLLOUT;
  error.clear();
  if (::poll(&wanted, 1, milliseconds) < 0 && errno != EINTR) error = last_reason();
  return {.to_send = (wanted.revents & POLLOUT) != 0,
          .to_receive = (wanted.revents & (POLLIN | POLLHUP | POLLERR)) != 0};
}

std::size_t ChildProcess::send(std::span<const std::byte> bytes) {
#ifdef MSG_NOSIGNAL
  constexpr int kHow = MSG_NOSIGNAL;
#else
  constexpr int kHow = 0;
#endif
  const ssize_t sent = ::send(system_->socket.number(), bytes.data(), bytes.size(), kHow);
  return static_cast<std::size_t>(std::max<ssize_t>(sent, 0));
}

void ChildProcess::end_sending() { ::shutdown(system_->socket.number(), SHUT_WR); }

std::optional<std::size_t> ChildProcess::receive(std::span<std::byte> bytes) {
  const ssize_t count = ::recv(system_->socket.number(), bytes.data(), bytes.size(), 0);
  if (count > 0) return static_cast<std::size_t>(count);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  return std::nullopt;
}

Ending ChildProcess::wait_for_end() {
  int status = 0;
  (void)whatever_signals([&] { return ::waitpid(system_->process, &status, 0); });
  system_->process = -1;
  if (WIFSIGNALED(status))
    return {.code = 0, .signal = WTERMSIG(status), .was_killed = WTERMSIG(status) == SIGKILL};
  return {.code = WEXITSTATUS(status), .signal = 0, .was_killed = false};
}

std::string library_file(const std::string& name, int version) {
#ifdef __APPLE__
  return "lib" + name + "." + std::to_string(version) + ".dylib";
#else
  return "lib" + name + ".so." + std::to_string(version);
#endif
}

void* load_library(const std::string& file, std::string& why) {
  void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) why = ::dlerror();
  return library;
}

void unload_library(void* library) { ::dlclose(library); }

Function function_of(void* library, const char* name) {
  return reinterpret_cast<Function>(::dlsym(library, name));
}

}  // namespace planish::platform
