#include "terminal/console.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "planish/core/error.h"

namespace planish::command {
namespace {

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

Console::Console(LogLevel level, ColorMode color)
    : level_(level),
      terminal_(is_capable_terminal()),
      color_(color == ColorMode::Always ||
             (color == ColorMode::Auto && terminal_ && !no_color_is_set())) {}

void Console::raw(std::string_view text) {
  clear_status();
  std::string line(text);
  line += '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
}

void Console::labelled(std::string_view color, std::string_view label, std::string_view text) {
  std::string line = "planish: ";
  if (color_) line += color;
  line += label;
  if (color_) line += "\033[0m";
  line += ": ";
  line += text;
  raw(line);
}

void Console::error(std::string_view text) { labelled("\033[1;31m", "error", text); }

void Console::warning(std::string_view text) {
  if (level_ >= LogLevel::Warning) labelled("\033[1;33m", "warning", text);
}

void Console::info(std::string_view text) {
  if (level_ >= LogLevel::Info) raw(text);
}

void Console::debug(std::string_view text) {
  if (level_ >= LogLevel::Debug) raw(text);
}

void Console::status(std::string_view text) {
  std::string line = "\r\033[K";
  line += text;
  std::fwrite(line.data(), 1, line.size(), stderr);
  std::fflush(stderr);
  status_shown_ = true;
}

void Console::clear_status() {
  if (!status_shown_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  status_shown_ = false;
}

void write_stdout(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw Error(ErrorCode::UnwritableOutput,
                std::string("stdout: cannot write: ") + std::strerror(errno));
  }
}

}  // namespace planish::command
