#include "planish/osd/submission.h"

#include <utility>

#include "planish/vulkan/device/result.h"

namespace planish::osd {

Submission::Submission(vulkan::Context& context, std::uint32_t queueFamily)
    : _commands(context, queueFamily) {}

Submission::~Submission() {
  if (_pending) (void)_commands.wait(UINT64_MAX);
}

bool Submission::IsDone(std::uint64_t nanoseconds) {
  if (!_pending) return true;
  VkResult const result = _commands.wait(nanoseconds);
  if (result == VK_TIMEOUT) return false;
  vulkan::check(result, "vkWaitForFences");
  _pending = false;
  _resources.clear();
  return true;
}

void Submission::Submit(VkQueue queue, std::function<void(VkCommandBuffer)> const& record,
                        std::shared_ptr<void> resources) {
  _commands.submit(queue, record);
  _pending = true;
  _resources.push_back(std::move(resources));
}

}  // namespace planish::osd
