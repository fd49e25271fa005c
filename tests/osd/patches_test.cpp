// EvalPatches in all its forms, recorded, cut into dispatches, refused, on drivers that differ.
#include <gmock/gmock.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include "osd/conformance.h"
#include "osd/fixture.h"
#include "osd/host_side.h"
#include "planish/osd/vk_compute_evaluator.h"
#include "planish/vulkan/device/driver.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {
namespace {

using namespace OpenSubdiv;
using Far::PatchTableFactory;
using Osd::BufferDescriptor;
using osd::VkComputeEvaluator;
using osd::VkPatchTable;
using osd::VkStencilTable;
using osd::VkVertexBuffer;

constexpr int kForms = 6;

RefineOptions adaptive_to(int level, PatchTableFactory::Options::EndCapType end_cap) {
  RefineOptions options;
  options.adaptive = true;
  options.level = level;
  options.patches = PatchTableFactory::Options(level);
  options.patches.SetEndCapType(end_cap);
  return options;
}

/// A prism's patches, points to evaluate them with and what Osd::CpuEvaluator makes of them: value,
/// du, dv, duu, duv, dvv.
struct Evaluation {
  Cage cage = prism(5);
  Refined refined;
  BufferDescriptor desc{0, 3, 3};
  std::vector<float> points;
  std::vector<Osd::PatchCoord> coords;
  std::array<std::vector<float>, kForms> expected;

  explicit Evaluation(const RefineOptions& options =
                          adaptive_to(2, PatchTableFactory::Options::ENDCAP_GREGORY_BASIS))
      : refined(refine(cage, options)) {
    const Far::StencilTable& table = *refined.vertices;
    const int coarse = table.GetNumControlVertices(), rows = table.GetNumStencils();
    points.resize(std::size_t(coarse + rows) * 3);
    for (int i = 0; i < coarse; ++i)
      std::copy(cage.positions[i].begin(), cage.positions[i].end(), points.begin() + 3 * i);
    Osd::CpuEvaluator::EvalStencils(points.data(), desc, points.data(),
                                    BufferDescriptor(3 * coarse, 3, 3), table.GetSizes().data(),
                                    table.GetOffsets().data(), table.GetControlIndices().data(),
                                    table.GetWeights().data(), 0, rows);
    for (int patch = 0, array = 0; array < refined.patches->GetNumPatchArrays(); ++array)
      for (int i = 0; i < refined.patches->GetNumPatches(array); ++i, ++patch) {
        Far::PatchTable::PatchHandle handle;
        handle.arrayIndex = array;
        handle.patchIndex = patch;
        handle.vertIndex = 0;
        float s = 0.25f, t = 0.625f;
        refined.patches->GetPatchParam(handle).Unnormalize(s, t);
        coords.emplace_back(handle, s, t);
      }
    evaluate();
  }

  void evaluate() {
    const Osd::CpuPatchTable table(refined.patches.get());
    for (std::vector<float>& result : expected) result.resize(coords.size() * 3);
    Osd::CpuEvaluator::EvalPatches(
        points.data(), desc, expected[0].data(), desc, expected[1].data(), desc, expected[2].data(),
        desc, expected[3].data(), desc, expected[4].data(), desc, expected[5].data(), desc, count(),
        coords.data(), table.GetPatchArrayBuffer(), table.GetPatchIndexBuffer(),
        table.GetPatchParamBuffer());
  }
  int count() const { return static_cast<int>(coords.size()); }
};

class OsdPatches : public OsdTest {
 protected:
  void TearDown() override {
    forget();
    OsdTest::TearDown();
  }
  void forget() {
    source_.reset();
    coords_.reset();
    table_.reset();
    for (auto& target : targets_) target.reset();
  }

  /// Patches in all forms and the stencils before them, on a driver that differs, against
  /// OpenSubdiv's own evaluator.
  void expect_on_pretended_driver(const Evaluation& from) {
    forget();
    make_device(PretendedDriver::get_proc());
    upload(from);
    const BufferDescriptor& d = from.desc;
    EXPECT_TRUE(VkComputeEvaluator::EvalPatches(
        source_.get(), d, targets_[0].get(), d, targets_[1].get(), d, targets_[2].get(), d,
        targets_[3].get(), d, targets_[4].get(), d, targets_[5].get(), d, from.count(),
        coords_.get(), table_.get(), nullptr, device_context_.get()));
    expect(from, kForms);
    const Far::StencilTable& stencils = *from.refined.vertices;
    const auto first = from.points.begin() + 3 * stencils.GetNumControlVertices();
    const std::unique_ptr<VkStencilTable> table(
        VkStencilTable::Create(&stencils, device_context_.get()));
    const auto target = buffer_of(std::vector<float>(from.points.end() - first, 9.0f));
    EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source_.get(), d, target.get(), d, table.get(),
                                                 nullptr, device_context_.get()));
    EXPECT_EQ(floats_of(*target), std::vector<float>(first, from.points.end()));
  }

  void upload(const Evaluation& from) {
    source_ = buffer_of(from.points);
    table_.reset(VkPatchTable::Create(from.refined.patches.get(), device_context_.get()));
    coords_ = upload_coords(from.coords);
    for (auto& target : targets_)
      target = buffer_of(std::vector<float>(from.coords.size() * 3, 9.0f));
  }
  std::unique_ptr<VkVertexBuffer> upload_coords(const std::vector<Osd::PatchCoord>& coords) {
    const int count = static_cast<int>(coords.size());
    std::unique_ptr<VkVertexBuffer> buffer(VkVertexBuffer::Create(5, count, device_context_.get()));
    buffer->UpdateData(reinterpret_cast<const float*>(coords.data()), 0, count,
                       device_context_.get());
    return buffer;
  }
  void expect(const Evaluation& from, int forms) {
    const std::vector<float> untouched(from.coords.size() * 3, 9.0f);
    for (int i = 0; i < kForms; ++i) {
      EXPECT_EQ(floats_of(*targets_[i]), i < forms ? from.expected[i] : untouched) << i;
      targets_[i] = buffer_of(untouched);
    }
  }

  std::unique_ptr<VkVertexBuffer> source_, coords_;
  std::unique_ptr<VkPatchTable> table_;
  std::array<std::unique_ptr<VkVertexBuffer>, kForms> targets_;
};

TEST_F(OsdPatches, AllFormsDoTheSame) {
  const Evaluation prism;
  upload(prism);
  const BufferDescriptor& d = prism.desc;
  const std::unique_ptr<VkComputeEvaluator> instance(
      VkComputeEvaluator::Create(d, d, d, d, device_context_.get()));
  VkVertexBuffer* const to[] = {targets_[0].get(), targets_[1].get(), targets_[2].get(),
                                targets_[3].get(), targets_[4].get(), targets_[5].get()};
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(source_.get(), d, to[0], d, prism.count(),
                                              coords_.get(), table_.get(), nullptr,
                                              device_context_.get()));
  expect(prism, 1);
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(
      source_.get(), d, targets_[0].get(), d, targets_[1].get(), d, targets_[2].get(), d,
      prism.count(), coords_.get(), table_.get(), nullptr, device_context_.get()));
  expect(prism, 3);
  EXPECT_TRUE(instance->EvalPatches(source_.get(), d, targets_[0].get(), d, prism.count(),
                                    coords_.get(), table_.get()));
  expect(prism, 1);
  EXPECT_TRUE(instance->EvalPatches(source_.get(), d, targets_[0].get(), d, targets_[1].get(), d,
                                    targets_[2].get(), d, targets_[3].get(), d, targets_[4].get(),
                                    d, targets_[5].get(), d, prism.count(), coords_.get(),
                                    table_.get()));
  expect(prism, 6);
  EXPECT_TRUE(instance->EvalPatches(source_->BindVBO(), d, targets_[0]->BindVBO(), d,
                                    targets_[1]->BindVBO(), d, targets_[2]->BindVBO(), d,
                                    prism.count(), coords_->BindVBO(), table_->GetPatches()));
  expect(prism, 3);
}

TEST_F(OsdPatches, TablesAreThoseOfOpenSubdiv) {
  const Evaluation prism;
  upload(prism);
  EXPECT_EQ(table_->GetPatchArrays().size(),
            std::size_t(prism.refined.patches->GetNumPatchArrays()));
  EXPECT_NE(table_->GetPatchIndexBuffer(), VkBuffer(VK_NULL_HANDLE));
  EXPECT_NE(table_->GetPatchParamBuffer(), VkBuffer(VK_NULL_HANDLE));
  EXPECT_NE(table_->GetVaryingPatchIndexBuffer(), VkBuffer(VK_NULL_HANDLE));
  EXPECT_EQ(table_->GetNumFVarChannels(), 0);
  EXPECT_TRUE(table_->GetFVarPatchArrays(0).empty());
}

TEST_F(OsdPatches, ACommandBufferOfTheHostIsOnlyRecordedInto) {
  const Evaluation prism;
  upload(prism);
  HostCommands host(*context_, device_->queue(), device_->capabilities().compute_family);
  osd::VkDeviceContext recording(*context_);
  host.begin();
  recording.SetCommandBuffer(host.commands());
  const BufferDescriptor& d = prism.desc;
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(source_.get(), d, targets_[0].get(), d, prism.count(),
                                              coords_.get(), table_.get(), nullptr, &recording));
  EXPECT_THAT(floats_of(*targets_[0]), ::testing::Each(9.0f));
  host.end_submit_wait();
  expect(prism, 1);
  recording.Release(host.commands());
}

TEST_F(OsdPatches, LowLimitsCutDispatchesAndChangeNothing) {
  vulkan::ContextOptions options;
  options.max_storage_range = 64 << 10;
  options.max_group_count = 3;
  make_context(options);
  Evaluation prism;
  const std::vector<Osd::PatchCoord> once = prism.coords;
  while (prism.coords.size() < 3000)
    prism.coords.insert(prism.coords.end(), once.begin(), once.end());
  prism.evaluate();
  upload(prism);
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(
      source_.get(), prism.desc, targets_[0].get(), prism.desc, targets_[1].get(), prism.desc,
      targets_[2].get(), prism.desc, prism.count(), coords_.get(), table_.get(), nullptr,
      device_context_.get()));
  expect(prism, 3);
}

// Windows begin at multiples of an alignment: one that begins in the middle shares bytes with the
// one before.
TEST_F(OsdPatches, DispatchesWhoseWindowsShareBytesWaitForEachOther) {
  vulkan::ContextOptions options;
  options.max_group_count = 1;
  make_context(options);
  Evaluation prism;
  while (prism.coords.size() < 200) prism.coords.push_back(prism.coords[prism.coords.size() / 2]);
  prism.evaluate();
  upload(prism);
  std::vector<float> wanted = prism.expected[0];
  wanted.insert(wanted.begin(), 9.0f);
  targets_[0] = buffer_of(std::vector<float>(wanted.size(), 9.0f));
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(
      source_.get(), prism.desc, targets_[0].get(), BufferDescriptor(1, 3, 3), prism.count(),
      coords_.get(), table_.get(), nullptr, device_context_.get()));
  EXPECT_EQ(floats_of(*targets_[0]), wanted);
}

TEST_F(OsdPatches, CoordinatesWithoutAPatchGiveZero) {
  Evaluation prism;
  prism.coords.resize(4);
  prism.evaluate();
  prism.coords[1].handle.arrayIndex = 1000;
  prism.coords[2].handle.patchIndex = -1;
  prism.coords[3].handle.patchIndex = 1 << 30;
  std::fill(prism.expected[0].begin() + 3, prism.expected[0].end(), 0.0f);
  upload(prism);
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(source_.get(), prism.desc, targets_[0].get(),
                                              prism.desc, prism.count(), coords_.get(),
                                              table_.get(), nullptr, device_context_.get()));
  expect(prism, 1);
}

TEST_F(OsdPatches, LegacyGregoryPatchesGiveWhatTheCpuGives) {
  const Evaluation prism(adaptive_to(2, PatchTableFactory::Options::ENDCAP_LEGACY_GREGORY));
  upload(prism);
  EXPECT_TRUE(VkComputeEvaluator::EvalPatches(source_.get(), prism.desc, targets_[0].get(),
                                              prism.desc, prism.count(), coords_.get(),
                                              table_.get(), nullptr, device_context_.get()));
  EXPECT_THAT(prism.expected[0], ::testing::Contains(0.0f)) << "none of them is legacy";
  expect(prism, 1);
}

TEST_F(OsdPatches, WhatDoesNotFitIsRefused) {
  RefineOptions uniform;
  const Evaluation prism(uniform);
  upload(prism);
  const auto eval = [&](const BufferDescriptor& from, const BufferDescriptor& to, int count,
                        const VkPatchTable* table) {
    return VkComputeEvaluator::EvalPatches(source_.get(), from, targets_[0].get(), to, count,
                                           coords_.get(), table, nullptr, device_context_.get());
  };
  EXPECT_TRUE(eval({0, 3, 3}, {0, 3, 3}, 0, table_.get()));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 2, 3}, 1, table_.get()));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 3, 3}, -1, table_.get()));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 3, 3}, 1, nullptr));
  EXPECT_FALSE(VkComputeEvaluator::EvalPatchesVarying(source_.get(), prism.desc, targets_[0].get(),
                                                      prism.desc, 1, coords_.get(), table_.get(),
                                                      nullptr, device_context_.get()))
      << "uniform tables have no varying patches";
  for (const int channel : {-1, 0, 7})
    EXPECT_FALSE(VkComputeEvaluator::EvalPatchesFaceVarying(
        source_.get(), prism.desc, targets_[0].get(), prism.desc, 1, coords_.get(), table_.get(),
        channel, nullptr, device_context_.get()));
}

TEST_F(OsdPatches, DriversThatDifferGiveTheSame) {
  const Evaluation prism;
  using Pretence = PretendedDriver::Pretence;
  const std::vector<std::pair<const char*, void (*)(Pretence&)>> drivers = {
      {"as it is", [](Pretence&) {}},
      {"1 lane", [](Pretence& p) { p.subgroup_size = 1; }},
      {"128 lanes", [](Pretence& p) { p.subgroup_size = 128; }},
      {"no subgroups", [](Pretence& p) { p.no_subgroup_operations = true; }},
      {"not coherent", [](Pretence& p) { p.split_memory = true; }},
      {"small heap",
       [](Pretence& p) {
         p.bar_bytes = 4096;
         p.host_bytes = 1u << 20;
       }},
      {"small ranges", [](Pretence& p) { p.storage_range = 128u << 20; }},
      {"no timestamps", [](Pretence& p) { p.no_timestamps = true; }},
      {"portability subset", [](Pretence& p) { p.portability_subset = true; }},
      {"queue that only computes", [](Pretence& p) { p.separate_compute = true; }}};
  for (const auto& [name, differ] : drivers) {
    SCOPED_TRACE(name);
    forget();
    close();
    PretendedDriver::reset();
    differ(PretendedDriver::pretence());
    expect_on_pretended_driver(prism);
    EXPECT_GT(PretendedDriver::count("vkCmdDispatch"), 1);
    EXPECT_EQ(PretendedDriver::illegal_maps(), 0);
  }
  forget();
  close();
  EXPECT_TRUE(PretendedDriver::alive().empty());
  PretendedDriver::reset();
}

TEST_F(OsdPatches, ADeviceThatIsLostInTheMiddleIsReported) {
  const Evaluation prism;
  close();
  PretendedDriver::reset();
  int lost = 0;
  for (bool done = false; !done; lost += lost < 2 ? 1 : 6) {
    ASSERT_LT(lost, 100);
    PretendedDriver::pretence().submissions_left = lost;
    try {
      expect_on_pretended_driver(prism);
      done = true;
    } catch (const vulkan::VulkanError& error) {
      EXPECT_EQ(error.code(), ErrorCode::DeviceLost);
    }
    forget();
    close();
    ASSERT_TRUE(PretendedDriver::alive().empty()) << "after " << lost << " submissions";
  }
  EXPECT_GT(lost, 5);
  PretendedDriver::reset();
}

}  // namespace
}  // namespace planish::testing
