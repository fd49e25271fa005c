#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "planish/vulkan/device/fenced_commands.h"

namespace planish::osd {

/// A command buffer that is sent without waiting, used again once it is done.
class Submission {
 public:
  Submission(vulkan::Context& context, std::uint32_t queueFamily);
  /// Waits for it.
  ~Submission();
  Submission(Submission const&) = delete;
  Submission& operator=(Submission const&) = delete;

  /// Returns whether nothing is under way, after up to `nanoseconds`; then `resources` are let go.
  bool IsDone(std::uint64_t nanoseconds);

  /// Keeps a resource until it is done.
  void Hold(std::shared_ptr<void> const& resource) {
    if (_pending) _resources.push_back(resource);
  }

  /// Records, submits and returns. Must be done. What it does is ordered after, and sees, what
  /// earlier submissions to the queue did.
  void Submit(VkQueue queue, std::function<void(VkCommandBuffer)> const& record,
              std::shared_ptr<void> resources);

 private:
  vulkan::FencedCommands _commands;
  bool _pending = false;
  std::vector<std::shared_ptr<void>> _resources;
};

}  // namespace planish::osd
