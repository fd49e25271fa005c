#include "terminal/progress.h"
#include "planish/core/formatted.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "planish/core/json.h"

namespace planish::command {
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

}  // namespace planish::command
