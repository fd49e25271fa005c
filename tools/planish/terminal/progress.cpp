#include "terminal/progress.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

namespace planish::command {
namespace {

constexpr double kPlainInterval = 10.0;  // seconds; logs stay short
constexpr double kBarInterval = 0.05;    // faster than this nobody sees
constexpr int kBarWidth = 24;

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ProgressMode resolve(ProgressMode mode, const Console& console) {
  if (mode != ProgressMode::Auto) return mode;
  if (console.level() < LogLevel::Info) return ProgressMode::None;
  return console.is_terminal() ? ProgressMode::Bar : ProgressMode::Plain;
}

int percent_of(double fraction) { return static_cast<int>(std::floor(fraction * 100)); }

}  // namespace

Progress::Progress(Console& console, ProgressMode mode, Clock clock)
    : console_(console),
      mode_(resolve(mode, console)),
      clock_(clock ? std::move(clock) : Clock(steady_seconds)),
      last_shown_(clock_()) {}

void Progress::begin_job(std::string_view name) {
  job_ = name;
  step_.clear();
  json_step_.clear();
  json_percent_ = -1;
}

void Progress::update(std::string_view step, double fraction) {
  step_ = step;
  fraction_ = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const double now = clock_();
  switch (mode_) {
    case ProgressMode::Bar:
      return draw_bar(now);
    case ProgressMode::Plain:
      return write_plain(now);
    case ProgressMode::Json:
      return write_json();
    case ProgressMode::Auto:
    case ProgressMode::None:
      return;
  }
}

void Progress::draw_bar(double now) {
  if (now - last_shown_ < kBarInterval) return;
  last_shown_ = now;
  const int filled = static_cast<int>(std::lround(fraction_ * kBarWidth));
  std::string line = job_ + "  [" + std::string(filled, '#') +
                     std::string(kBarWidth - filled, '.') + "]  " +
                     std::to_string(percent_of(fraction_)) + "%  " + step_;
  console_.status(line);
}

void Progress::write_plain(double now) {
  if (now - last_shown_ < kPlainInterval) return;
  last_shown_ = now;
  console_.raw(job_ + ": " + step_ + " " + std::to_string(percent_of(fraction_)) + "%");
}

void Progress::write_json() {
  const int percent = percent_of(fraction_);
  if (step_ == json_step_ && percent == json_percent_) return;
  json_step_ = step_;
  json_percent_ = percent;
  nlohmann::ordered_json line;
  line["job"] = job_;
  line["step"] = step_;
  line["fraction"] = fraction_;
  console_.raw(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace planish::command
