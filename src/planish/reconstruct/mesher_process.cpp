#include "planish/reconstruct/mesher_process.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <system_error>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/platform/process.h"
#include "planish/core/words.h"
#include "planish/reconstruct/mesher_protocol.h"

namespace planish {
namespace {

constexpr const char* kProgramName = "planish-reconstruct";
constexpr int kPollMilliseconds = 50;  // between tests for cancelling
constexpr std::size_t kMessageHead = 9;
constexpr std::int64_t kLongestText = 1 << 16;

class Conversation {
 public:
  Conversation(const std::filesystem::path& program, std::span<const glm::dvec3> points,
               const Callbacks& callbacks)
      : program_(utf8(program)), callbacks_(callbacks), point_count_(points.size()) {
    if (const std::error_code error = child_.start(program))
      throw Error(ErrorCode::NoDevice, program_ + ": cannot start: " + error.message());
    const auto count = static_cast<std::int64_t>(points.size());
    std::memcpy(head_.data(), kMesherMagic.data(), kMesherMagic.size());
    std::memcpy(head_.data() + kMesherMagic.size(), &count, sizeof count);
    unsent_ = {std::as_bytes(std::span(head_)), std::as_bytes(points)};
  }

  std::vector<Triangle> run() {
    const HostScope host(callbacks_);
    while (!finished_) {
      check_stop();
      std::error_code error;
      const auto ready = child_.wait(has_unsent(), kPollMilliseconds, error);
      if (error) fail(error.message());
      if (ready.to_send) send_some();
      if (ready.to_receive) receive_some();
    }
    return std::move(triangles_);
  }

 private:
  [[nodiscard]] bool has_unsent() const { return !unsent_[0].empty() || !unsent_[1].empty(); }

  void send_some() {
    for (auto& part : unsent_) {
      if (part.empty()) continue;
      part = part.subspan(child_.send(part));
      if (!part.empty()) return;
    }
    child_.end_sending();
  }

  void receive_some() {
    constexpr std::size_t kChunk = 1 << 16;
    const std::size_t size = received_.size();
    received_.resize(size + kChunk);
    const auto count = child_.receive(std::span(received_).subspan(size));
    received_.resize(size + count.value_or(0));
    if (!count) explain_end();
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
    const platform::Ending end = child_.wait_for_end();
    if (end.was_killed)
      throw Error(
          ErrorCode::OutOfMemory,
          formatted("{}: was killed while meshing {} points; it takes about 2 kB of memory a point",
                    program_, point_count_));
    fail(end.signal != 0 ? formatted("was ended by signal {}", end.signal)
                         : formatted("ended with code {} without an answer", end.code));
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("{}: {}; is it the planish-reconstruct of this version?", program_, what));
  }

  std::string program_;
  platform::ChildProcess child_;
  const Callbacks& callbacks_;
  std::size_t point_count_;
  std::array<char, 16> head_;
  std::array<std::span<const std::byte>, 2> unsent_;
  std::vector<std::byte> received_;
  std::vector<Triangle> triangles_;
  bool finished_ = false;
};

}  // namespace

std::optional<std::filesystem::path> find_mesher_program() {
  if (const auto named = platform::environment("PLANISH_RECONSTRUCT"); named && !named->empty()) {
    if (std::filesystem::path program = path_of(*named); platform::is_program(program))
      return program;
    return std::nullopt;
  }
  std::vector<std::filesystem::path> folders = platform::program_folders();
  if (const auto self = platform::own_program())
    folders.insert(folders.begin(), self->parent_path());
  for (const std::filesystem::path& folder : folders)
    if (std::filesystem::path program = platform::program_in(folder, kProgramName);
        platform::is_program(program))
      return program;
  return std::nullopt;
}

Mesher mesher_process(std::filesystem::path program) {
  return [program = std::move(program)](std::span<const glm::dvec3> points,
                                        const Callbacks& callbacks) {
    return Conversation(program, points, callbacks).run();
  };
}

}  // namespace planish
