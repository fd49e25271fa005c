#include "terminal/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

constexpr const char* kClearLine = "\r\033[K";

// Terminals that cannot move the cursor get neither colour nor a bar.
bool is_capable_terminal() {
  const char* term = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && term != nullptr && std::string_view(term) != "dumb";
}

bool no_color_is_set() {
  const char* value = std::getenv("NO_COLOR");
  return value != nullptr && *value != '\0';
}

}  // namespace

Console::Console(LogLevel level, ColorMode color, MessageForm form, std::string_view program)
    : level_(level),
      form_(form),
      program_(program),
      terminal_(is_capable_terminal()),
      color_(color == ColorMode::Always ||
             (color == ColorMode::Auto && terminal_ && !no_color_is_set())) {}

void Console::write_line(std::string line) {
  line += '\n';
  const std::scoped_lock lock(mutex_);
  // Within the lock, or another thread's status line may come between.
  if (status_shown_) line.insert(0, kClearLine);
  status_shown_ = false;
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

void Console::raw(std::string_view text) { write_line(visible_lines(text)); }

void Console::say(std::string_view level, std::string_view color, std::string_view text) {
  if (form_ == MessageForm::JsonLines) {
    const nlohmann::ordered_json line{{"level", level}, {"message", visible_lines(text)}};
    return write_line(line.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
  }
  std::string line;
  if (!color.empty()) {
    line = program_ + ": ";
    if (color_) line += color;
    line += level;
    if (color_) line += "\033[0m";
    line += ": ";
  }
  write_line(line + visible_lines(text));
}

void Console::error(std::string_view text) { say("error", "\033[1;31m", text); }

void Console::warning(std::string_view text) {
  if (level_ >= LogLevel::Warning) say("warning", "\033[1;33m", text);
}

void Console::info(std::string_view text) {
  if (level_ >= LogLevel::Info) say("info", "", text);
}

void Console::debug(std::string_view text) {
  if (level_ >= LogLevel::Debug) say("debug", "", text);
}

void Console::status(std::string_view text) {
  const std::string line = kClearLine + visible(text);
  const std::scoped_lock lock(mutex_);
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
  status_shown_ = true;
}

void Console::clear_status() {
  const std::scoped_lock lock(mutex_);
  if (!status_shown_) return;
  std::fputs(kClearLine, stderr);
  std::fflush(stderr);
  status_shown_ = false;
}

void write_stdout(std::string_view bytes) {
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size();
  if (written && std::fflush(stdout) == 0) return;
  if (errno == EPIPE) throw BrokenPipe();
  throw Error(ErrorCode::UnwritableOutput,
              std::string("stdout: cannot write: ") + std::strerror(errno));
}

void write_text(std::string_view text) { write_stdout(visible_lines(text)); }

bool stdout_is_terminal() { return isatty(STDOUT_FILENO) != 0; }

int stdout_columns() {
  constexpr int kUsual = 80;
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsual;
  return size.ws_col;
}

}  // namespace planish::command
