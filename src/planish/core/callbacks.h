#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "planish/core/error.h"

namespace planish {

/// Something the caller should know of although the work went on.
struct Warning {
  std::string code;         ///< stable, e.g. "unused-vertices"
  std::string message;      ///< one sentence with the remedy
  std::int64_t count = 1;   ///< how many elements it concerns
  std::int64_t first = -1;  ///< index of the first of them; -1 if none
};

/// How the library talks back. Every member may be empty. Called on the calling thread only.
struct Callbacks {
  /// What is being done, and the fraction of the whole call; it never falls and ends at 1.
  std::function<void(std::string_view step, double fraction)> progress;
  std::function<bool()> cancelled;
  std::function<void(const Warning&)> warning;

  /// Calls the member, if there is one. Should the host start a loop of its own in it, and take up
  /// a piece of the work meanwhile, nothing else is asked or told from there.
  void report(std::string_view step, double fraction) const;
  void warn(const Warning& what) const;
};

}  // namespace planish
