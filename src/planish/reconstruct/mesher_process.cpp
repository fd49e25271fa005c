#include "planish/reconstruct/mesher_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/reconstruct/mesher_protocol.h"

extern char** environ;

namespace planish {
namespace {

constexpr const char* kProgramName = "planish-reconstruct";
constexpr int kPollMilliseconds = 50;  // between tests for cancelling
constexpr std::size_t kMessageHead = 9;
constexpr std::int64_t kLongestText = 1 << 16;

class Child {
 public:
  explicit Child(const std::filesystem::path& program) : program_(program.string()) {
    int sockets[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets) != 0) fail_to_start(errno);
    socket_ = sockets[0];
    ::fcntl(socket_, F_SETFL, O_NONBLOCK);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, sockets[1], STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, sockets[1], STDOUT_FILENO);
    char* arguments[] = {program_.data(), nullptr};
    const int failed =
        ::posix_spawn(&process_, program_.c_str(), &actions, nullptr, arguments, environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(sockets[1]);
    if (failed != 0) {
      process_ = -1;
      ::close(socket_);
      fail_to_start(failed);
    }
  }
  ~Child() {
    ::close(socket_);
    if (process_ < 0) return;
    ::kill(process_, SIGKILL);
    (void)wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] int socket() const { return socket_; }
  [[nodiscard]] const std::string& program() const { return program_; }
  // The status of the ended process.
  int wait() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
  }

 private:
  [[noreturn]] void fail_to_start(int reason) const {
    throw Error(ErrorCode::NoDevice, program_ + ": cannot start: " + std::strerror(reason));
  }

  std::string program_;
  pid_t process_ = -1;
  int socket_ = -1;
};

class Conversation {
 public:
  Conversation(Child& child, std::span<const glm::dvec3> points, const Callbacks& callbacks)
      : child_(child), callbacks_(callbacks), point_count_(points.size()) {
    const auto count = static_cast<std::int64_t>(points.size());
    std::memcpy(head_.data(), kMesherMagic.data(), kMesherMagic.size());
    std::memcpy(head_.data() + kMesherMagic.size(), &count, sizeof count);
    unsent_ = {std::as_bytes(std::span(head_)), std::as_bytes(points)};
  }

  std::vector<Triangle> run() {
    const HostScope host(callbacks_);
    while (!finished_) {
      check_stop();
      pollfd wanted{.fd = child_.socket(), .events = POLLIN, .revents = 0};
      if (has_unsent()) wanted.events |= POLLOUT;
      if (::poll(&wanted, 1, kPollMilliseconds) < 0 && errno != EINTR) fail(std::strerror(errno));
      if (wanted.revents & POLLOUT) send_some();
      if (wanted.revents & (POLLIN | POLLHUP | POLLERR)) receive_some();
    }
    return std::move(triangles_);
  }

 private:
  [[nodiscard]] bool has_unsent() const { return !unsent_[0].empty() || !unsent_[1].empty(); }

  void send_some() {
    for (auto& part : unsent_) {
      if (part.empty()) continue;
      const ssize_t sent = ::send(child_.socket(), part.data(), part.size(), MSG_NOSIGNAL);
      // A broken connection shows when the answer is read.
      if (sent > 0) part = part.subspan(static_cast<std::size_t>(sent));
      if (!part.empty()) return;
    }
    ::shutdown(child_.socket(), SHUT_WR);
  }

  void receive_some() {
    constexpr std::size_t kChunk = 1 << 16;
    const std::size_t size = received_.size();
    received_.resize(size + kChunk);
    const ssize_t count = ::recv(child_.socket(), received_.data() + size, kChunk, 0);
    received_.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    const bool again = count < 0 && (errno == EAGAIN || errno == EINTR);
    if (count <= 0 && !again) explain_end();
    while (!finished_ && take_message()) {
    }
  }

  template <class Value>
  [[nodiscard]] Value value_at(std::size_t offset) const {
    Value value;
    std::memcpy(&value, received_.data() + offset, sizeof value);
    return value;
  }

  // False while the message is not all there.
  bool take_message() {
    if (received_.size() < kMessageHead) return false;
    const char kind = static_cast<char>(received_.front());
    std::size_t size = kMessageHead;
    if (kind == kMesherProgress) {
      callbacks_.report("mesh", std::clamp(value_at<double>(1), 0.0, 1.0));
    } else if (kind == kMesherTriangles) {
      const auto count = value_at<std::int64_t>(1);
      // A front names no triangle twice and closes a surface at most: far below this.
      if (count < 0 || static_cast<std::uint64_t>(count) > 16 * point_count_ + 16)
        fail(formatted("promises {} triangles", count));
      size += static_cast<std::size_t>(count) * sizeof(Triangle);
      if (received_.size() < size) return false;
      take_triangles(static_cast<std::size_t>(count));
      finished_ = true;
    } else if (kind == kMesherFailure) {
      const auto length = value_at<std::int64_t>(1);
      if (length < 0 || length > kLongestText) fail("sends a message of impossible length");
      size += sizeof(std::int32_t) + static_cast<std::size_t>(length);
      if (received_.size() < size) return false;
      const auto* text =
          reinterpret_cast<const char*>(received_.data()) + kMessageHead + sizeof(std::int32_t);
      throw Error(static_cast<ErrorCode>(value_at<std::int32_t>(kMessageHead)),
                  std::string(text, static_cast<std::size_t>(length)));
    } else {
      fail("answers what no mesher of this version does");
    }
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
    return true;
  }

  void take_triangles(std::size_t count) {
    if (count == 0) return;  // memcpy() takes no null pointer
    triangles_.resize(count);
    std::memcpy(triangles_.data(), received_.data() + kMessageHead, count * sizeof(Triangle));
    for (const Triangle& t : triangles_) {
      for (const std::int32_t corner : t)
        if (corner < 0 || static_cast<std::size_t>(corner) >= point_count_)
          fail(formatted("names point {} of {}", corner, point_count_));
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) fail("sends a triangle of two corners");
    }
  }

  [[noreturn]] void explain_end() {
    check_stop();
    const int status = child_.wait();
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
      throw Error(
          ErrorCode::OutOfMemory,
          formatted("{}: was killed while meshing {} points; it takes about 2 kB of memory a point",
                    child_.program(), point_count_));
    fail(WIFSIGNALED(status)
             ? formatted("was ended by signal {}", WTERMSIG(status))
             : formatted("ended with code {} without an answer", WEXITSTATUS(status)));
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {}; is it the planish-reconstruct of this version?",
                          child_.program(), what));
  }

  Child& child_;
  const Callbacks& callbacks_;
  std::size_t point_count_;
  std::array<char, 16> head_;
  std::array<std::span<const std::byte>, 2> unsent_;
  std::vector<std::byte> received_;
  std::vector<Triangle> triangles_;
  bool finished_ = false;
};

bool is_program(const std::filesystem::path& path) {
  return std::filesystem::is_regular_file(path) && ::access(path.c_str(), X_OK) == 0;
}

}  // namespace

std::optional<std::filesystem::path> find_mesher_program() {
  if (const char* named = std::getenv("PLANISH_RECONSTRUCT"); named && *named) {
    if (is_program(named)) return named;
    return std::nullopt;
  }
  std::error_code ignored;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", ignored);
  if (!ignored && is_program(self.parent_path() / kProgramName))
    return self.parent_path() / kProgramName;
  const char* path = std::getenv("PATH");
  std::string_view folders = path ? path : "";
  while (!folders.empty()) {
    const std::string_view folder = folders.substr(0, folders.find(':'));
    folders.remove_prefix(std::min(folders.size(), folder.size() + 1));
    if (!folder.empty() && is_program(std::filesystem::path(folder) / kProgramName))
      return std::filesystem::path(folder) / kProgramName;
  }
  return std::nullopt;
}

Mesher mesher_process(std::filesystem::path program) {
  return [program = std::move(program)](std::span<const glm::dvec3> points,
                                        const Callbacks& callbacks) {
    Child child(program);
    return Conversation(child, points, callbacks).run();
  };
}

}  // namespace planish
