// EvalStencils in all its forms, recorded and submitted, cut into dispatches, and refused.
#include <gmock/gmock.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/mesh.h>

#include <numeric>
#include <thread>

#include "osd/conformance.h"
#include "osd/fixture.h"
#include "osd/host_side.h"
#include "planish/core/error.h"
#include "planish/osd/vk_compute_evaluator.h"
#include "planish/solve/far_tables.h"
#include "vulkan/pretended_driver.h"

namespace planish::testing {
namespace {

using namespace OpenSubdiv;
using Osd::BufferDescriptor;
using osd::VkComputeEvaluator;
using osd::VkStencilTable;
using osd::VkVertexBuffer;

BufferDescriptor unused() { return {}; }

/// A torus refined twice: the table, its points, and what Osd::CpuEvaluator makes of them.
struct Refinement {
  Cage cage = torus(6, 5);
  Refined refined = refine(cage, {.level = 2});
  const Far::StencilTable& table = *refined.vertices;
  int sources = table.GetNumControlVertices(), rows = table.GetNumStencils();
  BufferDescriptor desc{0, 3, 3};
  std::vector<float> points, expected;

  Refinement() {
    for (const auto& position : cage.positions)
      points.insert(points.end(), position.begin(), position.end());
    expected = evaluate(points);
  }

  std::vector<float> evaluate(const std::vector<float>& from) const {
    std::vector<float> result(std::size_t(rows) * 3);
    Osd::CpuEvaluator::EvalStencils(from.data(), desc, result.data(), desc, table.GetSizes().data(),
                                    table.GetOffsets().data(), table.GetControlIndices().data(),
                                    table.GetWeights().data(), 0, rows);
    return result;
  }
};

/// A table of planish's own: every row is its own source.
std::unique_ptr<const Far::StencilTable> identity(int rows) {
  StencilTable result;
  result.sizes.assign(rows, 1);
  result.indices.resize(rows);
  std::iota(result.indices.begin(), result.indices.end(), 0);
  result.weights.assign(rows, 1.0);
  result.close(rows);
  return to_far<float>(result.view());
}

class OsdStencils : public OsdTest {
 protected:
  std::unique_ptr<VkStencilTable> upload(const Far::StencilTable& table) {
    return std::unique_ptr<VkStencilTable>(VkStencilTable::Create(&table, device_context_.get()));
  }
};

TEST_F(OsdStencils, InstancesAndHandlesDoWhatTheStaticFunctionDoes) {
  const Refinement torus;
  const auto source = buffer_of(torus.points);
  const auto table = upload(torus.table);
  Osd::EvaluatorCacheT<VkComputeEvaluator> cache;
  const VkComputeEvaluator* instance =
      cache.GetEvaluator(torus.desc, torus.desc, device_context_.get());
  ASSERT_NE(instance, nullptr);
  BufferDescriptor moved = torus.desc;
  moved.offset = 30 * 3;
  EXPECT_EQ(cache.GetEvaluator(torus.desc, moved, device_context_.get()), instance);

  const std::vector<float> nothing(torus.expected.size(), 9.0f);
  const auto of_static = buffer_of(nothing), of_instance = buffer_of(nothing),
             of_handles = buffer_of(nothing);
  EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, of_static.get(),
                                               torus.desc, table.get(), instance,
                                               device_context_.get()));
  EXPECT_TRUE(
      instance->EvalStencils(source.get(), torus.desc, of_instance.get(), torus.desc, table.get()));
  EXPECT_TRUE(instance->EvalStencils(source->BindVBO(), torus.desc, of_handles->BindVBO(),
                                     torus.desc, table.get(), 0, torus.rows));
  EXPECT_EQ(floats_of(*of_static), torus.expected);
  EXPECT_EQ(floats_of(*of_instance), torus.expected);
  EXPECT_EQ(floats_of(*of_handles), torus.expected);
}

// So that no frame waits for a compiler.
TEST_F(OsdStencils, KernelsAreCompiledWithTheirEvaluator) {
  close();
  PretendedDriver::reset();
  make_device(PretendedDriver::get_proc());
  const auto compiled = [] { return PretendedDriver::count("vkCreateComputePipelines"); };
  const Refinement torus;
  const auto table = upload(torus.table);
  const BufferDescriptor from(0, 3, 5), to(0, 3, 7);
  const auto source = buffer_of(std::vector<float>(std::size_t(torus.sources) * 5));
  const auto target = buffer_of(std::vector<float>(std::size_t(torus.rows) * 7));
  const int before = compiled();
  const std::unique_ptr<VkComputeEvaluator> instance(
      VkComputeEvaluator::Create(from, to, unused(), unused(), device_context_.get()));
  const int with_evaluator = compiled();
  EXPECT_GT(with_evaluator, before);
  EXPECT_TRUE(
      instance->EvalStencils(source->BindVBO(), from, target->BindVBO(), to, table.get(), 0, 1));
  EXPECT_EQ(compiled(), with_evaluator);
}

TEST_F(OsdStencils, StartAndEndLeaveOtherElementsAlone) {
  const Refinement torus;
  const auto source = buffer_of(torus.points);
  const auto table = upload(torus.table);
  const std::unique_ptr<VkComputeEvaluator> instance(VkComputeEvaluator::Create(
      torus.desc, torus.desc, unused(), unused(), device_context_.get()));
  for (const auto& [start, end] : {std::pair{0, 1}, std::pair{5, 70}, std::pair{63, 65},
                                   std::pair{torus.rows - 1, torus.rows}, std::pair{7, 7}}) {
    std::vector<float> expected(torus.expected.size(), 9.0f);
    const auto target = buffer_of(expected);
    std::copy(torus.expected.begin() + 3 * start, torus.expected.begin() + 3 * end,
              expected.begin() + 3 * start);
    EXPECT_TRUE(instance->EvalStencils(source->BindVBO(), torus.desc, target->BindVBO(), torus.desc,
                                       table.get(), start, end));
    EXPECT_EQ(floats_of(*target), expected) << start << " to " << end;
  }
}

TEST_F(OsdStencils, ACommandBufferOfTheHostIsOnlyRecordedInto) {
  const Refinement torus;
  HostCommands host(*context_, device_->queue(), device_->capabilities().compute_family);
  const std::vector<float> nothing(torus.expected.size(), 9.0f);
  const auto target = buffer_of(nothing);
  osd::VkDeviceContext recording(*context_);
  host.begin();
  recording.SetCommandBuffer(host.commands());
  // Uploads are recorded too, and their data are free at once.
  std::unique_ptr<VkVertexBuffer> source(VkVertexBuffer::Create(3, torus.sources, &recording));
  std::vector<float> points = torus.points;
  source->UpdateData(points.data(), 0, torus.sources, &recording);
  points.assign(points.size(), 0.0f);
  std::unique_ptr<VkStencilTable> table(VkStencilTable::Create(&torus.table, &recording));
  EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, target.get(), torus.desc,
                                               table.get(), nullptr, &recording));
  // What the commands use may be deleted before they ran.
  source.reset();
  table.reset();
  VkComputeEvaluator::Synchronize(&recording);
  EXPECT_EQ(floats_of(*target), nothing);
  host.end_submit_wait();
  EXPECT_EQ(floats_of(*target), torus.expected);
  recording.Release(host.commands());
}

TEST_F(OsdStencils, ThreadsRecordWithContextsOfTheirOwn) {
  constexpr int kThreads = 4;
  const Refinement torus;
  const auto source = buffer_of(torus.points);
  const auto padded = buffer_of(std::vector<float>(8 * std::size_t(torus.sources), 0.5f));
  const auto table = upload(torus.table);
  device_context_->Synchronize();
  std::vector<std::unique_ptr<HostCommands>> hosts;
  std::vector<std::unique_ptr<osd::VkDeviceContext>> contexts;
  std::vector<std::unique_ptr<VkVertexBuffer>> targets;
  for (int i = 0; i < kThreads; ++i) {
    hosts.push_back(std::make_unique<HostCommands>(*context_, device_->queue(),
                                                   device_->capabilities().compute_family));
    contexts.push_back(std::make_unique<osd::VkDeviceContext>(*context_));
    targets.push_back(buffer_of(torus.expected));
  }
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&, i] {
      hosts[i]->begin();
      contexts[i]->SetCommandBuffer(hosts[i]->commands());
      // Strides that no other thread has: kernels are compiled side by side.
      const BufferDescriptor wide(0, 1, 4 + i);
      EXPECT_TRUE(VkComputeEvaluator::EvalStencils(padded.get(), wide, targets[i].get(), {0, 1, 3},
                                                   table.get(), nullptr, contexts[i].get()));
      EXPECT_TRUE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, targets[i].get(),
                                                   torus.desc, table.get(), nullptr,
                                                   contexts[i].get()));
    });
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < kThreads; ++i) hosts[i]->end_submit_wait();
  for (int i = 0; i < kThreads; ++i) EXPECT_EQ(floats_of(*targets[i]), torus.expected) << i;
}

TEST_F(OsdStencils, BuffersOfTheHostNeedNoMoreThanTheUsageStated) {
  const Refinement torus;
  const auto table = upload(torus.table);
  const auto source = buffer_of(torus.points);
  const std::unique_ptr<VkComputeEvaluator> instance(VkComputeEvaluator::Create(
      torus.desc, torus.desc, unused(), unused(), device_context_.get()));
  // From ours to the host's, and back by a table that copies.
  HostBuffer host(*context_, torus.expected.size() * sizeof(float),
                  device_context_->GetBufferUsage());
  EXPECT_TRUE(instance->EvalStencils(source->BindVBO(), torus.desc, host.handle(), torus.desc,
                                     table.get(), 0, torus.rows));
  const auto copies = identity(torus.rows);
  const std::unique_ptr<VkStencilTable> copy(
      VkStencilTable::Create(copies.get(), device_context_.get()));
  const auto result = buffer_of(std::vector<float>(torus.expected.size(), 9.0f));
  EXPECT_TRUE(instance->EvalStencils(host.handle(), torus.desc, result->BindVBO(), torus.desc,
                                     copy.get(), 0, torus.rows));
  EXPECT_EQ(floats_of(*result), torus.expected);
}

TEST_F(OsdStencils, SeveralMeshesAndFramesAreInFlight) {
  constexpr int kMeshes = 4, kFrames = 5;
  const Refinement torus;
  std::vector<std::unique_ptr<VkStencilTable>> tables;
  std::vector<std::unique_ptr<VkVertexBuffer>> buffers;
  BufferDescriptor target = torus.desc;
  target.offset = 3 * torus.sources;
  for (int mesh = 0; mesh < kMeshes; ++mesh) {
    tables.push_back(upload(torus.table));
    buffers.emplace_back(
        VkVertexBuffer::Create(3, torus.sources + torus.rows, device_context_.get()));
  }
  std::vector<std::vector<float>> points(kMeshes, torus.points);
  for (int frame = 0; frame < kFrames; ++frame)
    for (int mesh = 0; mesh < kMeshes; ++mesh) {
      for (float& coordinate : points[mesh]) coordinate *= 1.0f + 0.125f * mesh;
      buffers[mesh]->UpdateData(points[mesh].data(), 0, torus.sources, device_context_.get());
      EXPECT_TRUE(VkComputeEvaluator::EvalStencils(buffers[mesh].get(), torus.desc,
                                                   buffers[mesh].get(), target, tables[mesh].get(),
                                                   nullptr, device_context_.get()));
    }
  VkComputeEvaluator::Synchronize(device_context_.get());
  for (int mesh = 0; mesh < kMeshes; ++mesh) {
    const std::vector<float> result = floats_of(*buffers[mesh]);
    const std::vector<float> expected = torus.evaluate(points[mesh]);
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), result.begin() + target.offset))
        << mesh;
  }
}

TEST_F(OsdStencils, LowLimitsCutDispatchesAndChangeNothing) {
  const Cage cage = torus(12, 10);
  const Refined refined = refine(cage, {.level = 4});
  for (const vulkan::PipelineVariant& variant :
       {vulkan::kHardwareVariant, vulkan::kSoftwareVariant}) {
    vulkan::ContextOptions options;
    options.max_storage_range = 128 << 10;
    options.max_group_count = 40;
    options.variant = variant;
    make_context(options);
    Conformance conformance{*device_context_, {}};
    for (const Layout& layout : all_layouts())
      conformance.stencils("limits", cage, *refined.vertices, layout);
    EXPECT_GT(conformance.tally.floats, 1000000);
  }
}

TEST_F(OsdStencils, ElementsThatNoBindingSpansAreRefusedByName) {
  const Refinement torus;
  vulkan::ContextOptions options;
  options.max_storage_range = 64 << 10;
  make_context(options);
  const auto table = upload(torus.table);
  const BufferDescriptor wide{0, 3, 1000};
  const auto source = buffer_of(std::vector<float>(30000, 0.0f)),
             target = buffer_of(torus.expected);
  try {
    VkComputeEvaluator::EvalStencils(source.get(), wide, target.get(), torus.desc, table.get(),
                                     nullptr, device_context_.get());
    FAIL() << "the source spans 120 kB";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("maxStorageBufferRange is 65536"));
  }
}

TEST_F(OsdStencils, WhatDoesNotFitIsRefused) {
  const Refinement torus;
  const auto source = buffer_of(torus.points), target = buffer_of(torus.expected);
  const auto table = upload(torus.table);
  const auto eval = [&](const BufferDescriptor& from, const BufferDescriptor& to) {
    return VkComputeEvaluator::EvalStencils(source.get(), from, target.get(), to, table.get(),
                                            nullptr, device_context_.get());
  };
  EXPECT_TRUE(eval({0, 3, 3}, {0, 3, 3}));
  EXPECT_FALSE(eval({0, 3, 3}, {0, 2, 3})) << "lengths differ";
  EXPECT_FALSE(eval({0, 3, 2}, {0, 3, 3})) << "stride below length";
  EXPECT_FALSE(eval({0, 0, 3}, {0, 0, 3})) << "no floats";
  EXPECT_FALSE(eval({-3, 3, 3}, {0, 3, 3})) << "before the buffer";
  VkVertexBuffer* const none = nullptr;
  EXPECT_FALSE(VkComputeEvaluator::EvalStencils(none, torus.desc, target.get(), torus.desc,
                                                table.get(), nullptr, device_context_.get()));
  EXPECT_FALSE(VkComputeEvaluator::EvalStencils(source.get(), torus.desc, target.get(), torus.desc,
                                                target.get(), torus.desc, target.get(), torus.desc,
                                                table.get(), nullptr, device_context_.get()))
      << "the table has no derivatives";
  const std::unique_ptr<VkComputeEvaluator> instance(VkComputeEvaluator::Create(
      torus.desc, torus.desc, unused(), unused(), device_context_.get()));
  const auto range = [&](int start, int end) {
    return instance->EvalStencils(source->BindVBO(), torus.desc, target->BindVBO(), torus.desc,
                                  table.get(), start, end);
  };
  EXPECT_FALSE(range(-1, 3));
  EXPECT_FALSE(range(0, torus.rows + 1));
  EXPECT_EQ(
      VkComputeEvaluator::Create({0, 3, 3}, {0, 4, 4}, unused(), unused(), device_context_.get()),
      nullptr);
  EXPECT_THROW(source->UpdateData(torus.points.data(), 1, 90, device_context_.get()), Error);
  EXPECT_THROW(static_cast<void>(VkVertexBuffer::Create(0, 3, device_context_.get())), Error);
}

TEST_F(OsdStencils, StencilsThatReadEachOtherAreRefused) {
  const auto refiner = make_refiner(cube());
  refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(3));
  Far::StencilTableFactory::Options options;
  options.factorizeIntermediateLevels = false;
  options.generateIntermediateLevels = true;
  options.generateOffsets = true;
  const std::unique_ptr<const Far::StencilTable> table(
      Far::StencilTableFactory::Create(*refiner, options));
  try {
    upload(*table);
    FAIL() << "stencils of level 2 read those of level 1";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("factorizeIntermediateLevels"));
  }
}

TEST_F(OsdStencils, AContextWithoutQueueNeedsACommandBuffer) {
  osd::VkDeviceContext recording(*context_);
  const std::unique_ptr<VkVertexBuffer> buffer(VkVertexBuffer::Create(3, 1, &recording));
  const float point[3] = {};
  EXPECT_THROW(buffer->UpdateData(point, 0, 1, &recording), Error);
}

}  // namespace
}  // namespace planish::testing
