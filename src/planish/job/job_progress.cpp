#include "planish/job/job_progress.h"

#include <algorithm>
#include <cmath>

namespace planish {

// A step comes again for every level: one that starts anew is the next of its name.
void JobProgress::advance() {
  if (steps_.empty()) {
    share_ = fraction_;
    return;
  }
  const auto from = steps_.begin() + static_cast<std::ptrdiff_t>(std::min(place_, steps_.size()));
  const auto found = std::ranges::find(from, steps_.end(), step_, &PlannedStep::name);
  if (found != steps_.end()) place_ = static_cast<std::size_t>(found - steps_.begin());
  if (place_ >= steps_.size()) return;
  double before = 0, all = 0;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    if (i < place_) before += steps_[i].weight;
    all += steps_[i].weight;
  }
  const double share = (before + fraction_ * steps_[place_].weight) / all;
  share_ = std::clamp(share, share_, 1.0);
}

void JobProgress::update(std::string_view step, double fraction) {
  const double sane =
      std::lerp(begin_, end_, std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0);
  const bool is_planned = place_ < steps_.size() && steps_[place_].name == step;
  if (is_planned && step == step_ && sane < fraction_) ++place_;
  step_ = step;
  fraction_ = sane;
  advance();
  if (visit_) visit_(step_, fraction_, share_);
}

}  // namespace planish
