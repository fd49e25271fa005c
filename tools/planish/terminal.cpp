#include "terminal.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/platform/files.h"
#include "planish/core/platform/process.h"
#include "planish/core/words.h"
#include "planish/job/build_info.h"
#include "planish/job/staged_files.h"

namespace planish::command {

ExitCode exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return ExitCode::Usage;
    case ErrorCode::UnreadableInput:
      return ExitCode::UnreadableInput;
    case ErrorCode::UnusableMesh:
      return ExitCode::UnusableMesh;
    case ErrorCode::NoDevice:
    case ErrorCode::DeviceLost:
    case ErrorCode::OutOfMemory:
      return ExitCode::NoDevice;
    case ErrorCode::UnwritableOutput:
      return ExitCode::UnwritableOutput;
    case ErrorCode::Cancelled:
      return interrupt_signal() == SIGTERM ? ExitCode::Terminated : ExitCode::Interrupted;
  }
  return ExitCode::InternalError;
}

namespace {

constexpr const char* kClearLine = "\r\033[K";

bool no_color_is_set() {
  const char* value = std::getenv("NO_COLOR");
  return value != nullptr && *value != '\0';
}

}  // namespace

Console::Console(LogLevel level, ColorMode color, MessageForm form, std::string_view program)
    : level_(level),
      form_(form),
      program_(program),
      // Terminals that cannot move the cursor get neither colour nor a bar.
      terminal_(platform::moves_cursor(platform::kStandardError)),
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

bool stdout_is_terminal() { return platform::is_terminal(platform::kStandardOutput); }

int stdout_columns() {
  constexpr int kUsual = 80;
  return platform::terminal_columns(platform::kStandardOutput).value_or(kUsual);
}

namespace {

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

}  // namespace

void Table::add_row(std::vector<std::string> cells) {
  PLANISH_ASSERT(cells.size() == columns_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::text() const {
  std::vector<std::vector<std::string>> lines{{}};
  for (const Column& column : columns_) lines.front().push_back(column.title);
  lines.insert(lines.end(), rows_.begin(), rows_.end());
  std::vector<std::size_t> widths(columns_.size());
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i)
      widths[i] = std::max(widths[i], width_of(line[i]));
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string padding(widths[i] - width_of(line[i]), ' ');
      if (i > 0) text += "  ";
      text += columns_[i].align == Align::Left ? line[i] + padding : padding + line[i];
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  }
  return text;
}

namespace {

std::atomic<bool> is_ending = false;

// Jobs on other threads than the one that takes the signal read it, too.
std::atomic<int> noted_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free);
StopFlag stop = false;
MessageStyle ending_style;

void note_signal(int signal) {
  noted_signal = signal;
  stop = true;
}

// For work that does not come to its next check soon enough.
[[noreturn]] void end_for_good() {
  const auto moving = while_files_move();
  if (is_ending.exchange(true)) platform::sleep_for_ever();
  remove_temporary_folders();
  Console console(LogLevel::Error, ending_style.color, ending_style.form);
  if (console.is_terminal()) console.status("");
  console.error("interrupted; no partial file is left");
  std::_Exit(static_cast<int>(exit_code_of(ErrorCode::Cancelled)));
}

void wait_for_signal() {
  platform::wait_for_ending();
  std::this_thread::sleep_for(std::chrono::milliseconds(kPatienceMilliseconds));
  end_for_good();
}

}  // namespace

void install_signal_handlers(MessageStyle style) {
  ending_style = style;
  if constexpr (!kHasThreads) return;  // the engine's own end of a script
  platform::on_ending(note_signal);
  std::thread(wait_for_signal).detach();
}

int interrupt_signal() { return noted_signal; }

const StopFlag& interrupt_flag() { return stop; }

void check_interrupt() {
  if (noted_signal != 0) throw Error(ErrorCode::Cancelled, "interrupted");
}

void claim_end() {
  if (is_ending.exchange(true)) platform::sleep_for_ever();
}

namespace {

std::string joined(const std::vector<std::string>& messages) {
  std::string text;
  for (const std::string& message : messages) text += (text.empty() ? "" : "\n") + message;
  return text;
}

}  // namespace

FaultList::FaultList(ErrorCode code, std::vector<std::string> messages)
    : Error(code, joined(messages)), messages_(std::move(messages)) {}

void Faults::add(const Error& error) {
  if (messages_.empty() || exit_code_of(error.code()) < exit_code_of(code_)) code_ = error.code();
  const std::string message = error.what();
  if (std::ranges::find(messages_, message) == messages_.end()) messages_.push_back(message);
}

void Faults::throw_if_any() const {
  if (messages_.empty()) return;
  if (messages_.size() == 1) throw Error(code_, messages_.front());
  throw FaultList(code_, messages_);
}

namespace {

constexpr double kPlainInterval = 10.0;  // seconds; logs stay short
constexpr double kBarInterval = 0.05;    // faster than this nobody sees
constexpr int kBarWidth = 24;
constexpr double kShareToTell = 0.05;  // of the job, before which an estimate is a guess

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ProgressMode resolve(ProgressMode mode, const Console& console) {
  if (mode != ProgressMode::Auto) return mode;
  if (console.level() < LogLevel::Info) return ProgressMode::None;
  return console.is_terminal() ? ProgressMode::Bar : ProgressMode::Plain;
}

int percent_of(double fraction) { return static_cast<int>(std::floor(fraction * 100)); }

// Seconds that are left; negative where they cannot be told yet.
double seconds_left(double share, double seconds) {
  return share < kShareToTell ? -1 : seconds * (1 - share) / share;
}

std::string left_text(double share, double seconds) {
  const double left = seconds_left(share, seconds);
  if (left < 0) return {};
  const auto whole = static_cast<long>(std::lround(left));
  if (whole < 100) return formatted(", {} s left", whole);
  return formatted(", {} min left", (whole + 30) / 60);
}

}  // namespace

Progress::Progress(Console& console, ProgressMode mode, Clock clock, int job_count)
    : console_(console),
      mode_(resolve(mode, console)),
      clock_(clock ? std::move(clock) : Clock(steady_seconds)),
      job_count_(job_count),
      last_bar_(clock_()) {}

void Progress::show(JobDisplay& job) {
  const std::scoped_lock lock(mutex_);
  const double now = clock_();
  switch (mode_) {
    case ProgressMode::Bar:
      return draw_bar(job, now);
    case ProgressMode::Plain:
      return write_plain(job, now);
    case ProgressMode::JsonLines:
      return write_json(job, now);
    case ProgressMode::Auto:
    case ProgressMode::None:
      return;
  }
}

void Progress::draw_bar(JobDisplay& job, double now) {
  if (now - last_bar_ < kBarInterval) return;
  last_bar_ = now;
  const int filled = static_cast<int>(std::lround(job.share_ * kBarWidth));
  std::string line;
  if (job_count_ > 1) line = formatted("{}/{} ", job.number_, job_count_);
  line += formatted("{}  [{}{}]  {}%  {}{}", job.name_, std::string(filled, '#'),
                    std::string(kBarWidth - filled, '.'), percent_of(job.share_), job.step_,
                    left_text(job.share_, now - job.begun_));
  console_.status(line);
}

void Progress::write_plain(JobDisplay& job, double now) {
  if (now - job.last_plain_ < kPlainInterval) return;
  job.last_plain_ = now;
  console_.raw(formatted("{}: {}%, {}{}", job.name_, percent_of(job.share_), job.step_,
                         left_text(job.share_, now - job.begun_)));
}

void Progress::write_json(JobDisplay& job, double now) {
  const int percent = percent_of(job.fraction_);
  if (job.step_ == job.json_step_ && percent == job.json_percent_) return;
  job.json_step_ = job.step_;
  job.json_percent_ = percent;
  const double seconds = now - job.begun_;
  const double left = seconds_left(job.share_, seconds);
  const auto rounded = [](double value) { return std::round(value * 1000) / 1000; };
  nlohmann::ordered_json line;
  line["job"] = job.name_;
  line["step"] = job.step_;
  line["fraction"] = job.fraction_;
  line["number"] = job.number_;
  line["jobs"] = job_count_;
  line["share"] = rounded(job.share_);
  line["seconds"] = rounded(seconds);
  line["seconds_left"] =
      left < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(rounded(left));
  console_.raw(line.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

JobDisplay::JobDisplay(Progress& progress, std::string_view name, int number)
    : progress_(progress),
      name_(name),
      number_(number),
      begun_(progress.clock_()),
      last_plain_(begun_) {}

ProgressVisit JobDisplay::visit() {
  return
      [this](std::string_view step, double fraction, double share) { show(step, fraction, share); };
}

void JobDisplay::show(std::string_view step, double fraction, double share) {
  step_ = step;
  fraction_ = fraction;
  share_ = share;
  progress_.show(*this);
}

JobWatch watch_of(Console& console, JobDisplay& display, JobPage* page) {
  return {.progress = display.visit(),
          .warning = [&console](const Warning& warning) { console.warning(warning.message); },
          .details = [&console](const std::string& lines) { console.debug(lines); },
          .write =
              [&console](std::string_view bytes) {
                console.clear_status();
                write_stdout(bytes);
              },
          .page = page};
}

}  // namespace planish::command
