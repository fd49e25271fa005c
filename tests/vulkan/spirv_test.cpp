// What the kernels ask of a device, read from their SPIR-V: nothing beyond Vulkan 1.1 without any
// feature, within the limits that every device keeps. details.md of vulkan/ has the table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/driver.h"

namespace planish::testing {
namespace {

// Numbers of the SPIR-V specification.
constexpr std::uint32_t kMagic = 0x07230203;
constexpr std::uint32_t kVersion13 = 0x00010300;  // Vulkan 1.1 takes no later one
enum Op : std::uint32_t {
  OpExtension = 10,
  OpExtInstImport = 11,
  OpEntryPoint = 15,
  OpExecutionMode = 16,
  OpCapability = 17,
  OpTypeInt = 21,
  OpTypeFloat = 22,
  OpTypeImage = 25,
  OpDecorate = 71,
  OpFSub = 131,
  OpFMul = 133,
};
constexpr std::uint32_t kShader = 1, kSampledBuffer = 46;                   // capabilities
constexpr std::uint32_t kCompute = 5;                                       // execution model
constexpr std::uint32_t kLocalSize = 17;                                    // execution mode
constexpr std::uint32_t kBuiltIn = 11, kBinding = 33, kNoContraction = 42;  // decorations
// Built-ins that do not depend on the size of subgroups.
const std::set<std::uint32_t> kPlainBuiltIns = {24, 25, 26, 27, 28, 29};
constexpr std::uint32_t kSmallestGroupLimit = 128;  // maxComputeWorkGroupInvocations of any device

struct Instruction {
  std::uint32_t op;
  std::vector<std::uint32_t> operands;
};

struct Module {
  std::uint32_t version = 0;
  std::vector<Instruction> instructions;
};

Module read_module(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::uint32_t> words(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof words[0]);
  Module module;
  if (words.size() < 5 || words[0] != kMagic) return module;
  module.version = words[1];
  for (std::size_t at = 5; at < words.size();) {
    const std::size_t length = words[at] >> 16;
    if (length == 0 || at + length > words.size()) return {};
    module.instructions.push_back(
        {words[at] & 0xffff, {words.begin() + at + 1, words.begin() + at + length}});
    at += length;
  }
  return module;
}

std::map<std::string, Module> modules() {
  std::map<std::string, Module> all;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SHADER_FOLDER))
    if (entry.path().extension() == ".spv")
      all[entry.path().stem().string()] = read_module(entry.path());
  return all;
}

TEST(Spirv, EveryKernelIsThere) {
  const std::map<std::string, Module> all = modules();
  for (std::size_t i = 0; i < vulkan::kKernelCount; ++i) {
    // Debuggers are told "planish NAME".
    const std::string label = vulkan::source_of(static_cast<vulkan::Kernel>(i)).name;
    const std::string name = label.substr(label.find(' ') + 1);
    ASSERT_TRUE(all.count(name)) << name;
    EXPECT_GT(all.at(name).instructions.size(), 20u) << name;
  }
}

TEST(Spirv, KernelsNeedNoFeature) {
  for (const auto& [name, module] : modules()) {
    SCOPED_TRACE(name);
    EXPECT_LE(module.version, kVersion13);
    for (const Instruction& instruction : module.instructions) {
      const std::vector<std::uint32_t>& operands = instruction.operands;
      if (instruction.op == OpCapability) {
        // Neither subgroup operations nor 8, 16 or 64 bits, each of which has one of its own.
        EXPECT_TRUE(operands[0] == kShader || operands[0] == kSampledBuffer) << operands[0];
        if (operands[0] == kSampledBuffer) {
          EXPECT_TRUE(name.ends_with("_texel"));
        }
      }
      EXPECT_NE(instruction.op, OpExtension);
      if (instruction.op == OpEntryPoint) {
        EXPECT_EQ(operands[0], kCompute);
      }
      if (instruction.op == OpTypeInt || instruction.op == OpTypeFloat) {
        EXPECT_EQ(operands[1], 32u);
      }
    }
  }
}

TEST(Spirv, KernelsKeepToTheSmallestLimits) {
  for (const auto& [name, module] : modules()) {
    SCOPED_TRACE(name);
    std::set<std::uint32_t> bindings;
    std::uint32_t lanes = 0;
    for (const Instruction& instruction : module.instructions) {
      const std::vector<std::uint32_t>& operands = instruction.operands;
      if (instruction.op == OpExecutionMode && operands[1] == kLocalSize)
        lanes = operands[2] * operands[3] * operands[4];
      if (instruction.op != OpDecorate) continue;
      if (operands[1] == kBinding) bindings.insert(operands[2]);
      if (operands[1] == kBuiltIn) {
        EXPECT_TRUE(kPlainBuiltIns.count(operands[2])) << operands[2];
      }
    }
    EXPECT_GE(lanes, 1u);
    EXPECT_LE(lanes, kSmallestGroupLimit);
    EXPECT_LE(bindings.size(), vulkan::kMaxBindings);
  }
}

// A determinant that a device fuses with one of its products is not zero where the products are
// equal, but the rounding of the other: the fair kernels compare them with zero.
TEST(Spirv, FairKernelsNeverFuseDifferencesOfProducts) {
  int differences = 0;
  for (const auto& [name, module] : modules()) {
    if (!name.starts_with("fair_")) continue;
    std::set<std::uint32_t> exact, products;
    for (const Instruction& instruction : module.instructions) {
      const std::vector<std::uint32_t>& operands = instruction.operands;
      if (instruction.op == OpDecorate && operands[1] == kNoContraction) exact.insert(operands[0]);
      if (instruction.op == OpFMul) products.insert(operands[1]);
      if (instruction.op != OpFSub) continue;
      if (!products.count(operands[2]) || !products.count(operands[3])) continue;
      EXPECT_TRUE(exact.count(operands[1])) << name;
      ++differences;
    }
  }
  EXPECT_GT(differences, 20);
}

// Of VK_KHR_portability_subset all features are of images, samplers, events, vertex input and
// drawing: planish asks for no function that could use one.
TEST(Spirv, NoFunctionOfThePortabilitySubsetIsAskedFor) {
#define PLANISH_NAME(name) #name,
  const std::string_view asked[] = {PLANISH_VULKAN_DEVICE_FUNCTIONS(PLANISH_NAME)};
#undef PLANISH_NAME
  for (const std::string_view name : asked)
    for (const char* of : {"Image", "Sampler", "Event", "Graphics", "Draw", "RenderPass", "Vertex",
                           "Depth", "Stencil", "Blend"})
      EXPECT_EQ(name.find(of), std::string_view::npos) << name;
  EXPECT_GT(std::size(asked), 40u);
}

}  // namespace
}  // namespace planish::testing
