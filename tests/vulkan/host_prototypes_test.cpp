// What a host sees of Vulkan that includes planish before its own Vulkan header.
#include "planish/vulkan/embed.h"

#include <gtest/gtest.h>
#include <vulkan/vulkan.h>

#include <type_traits>

namespace planish::vulkan {
namespace {

// Named, but not called: nothing here links a loader.
TEST(HostPrototypes, StayDeclared) {
  EXPECT_TRUE((std::is_same_v<decltype(&vkCreateInstance), PFN_vkCreateInstance>));
}

}  // namespace
}  // namespace planish::vulkan
