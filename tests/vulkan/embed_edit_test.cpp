// Edits on a device: against solves of all points, against the CPU's Editor, and what they cost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "planish/edit/editor.h"
#include "planish/solve/backend.h"
#include "planish/vulkan/device/commands.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/edit_host.h"
#include "vulkan/large_rings.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// Of the diagonal: what single precision leaves, beside a solve's tolerance.
constexpr double kSinglesError = 4e-7;

PolygonMesh in_singles(PolygonMesh mesh) {
  for (glm::dvec3& p : mesh.positions) p = glm::dvec3(glm::vec3(p));
  return mesh;
}

class EmbedEdit : public Embedding {
 protected:
  std::vector<test::NamedMesh> meshes() const {
    std::vector<test::NamedMesh> all = {
        {"sphere", test::icosphere(2)},
        {"torus", test::torus(30, 20, 1, 0.4)},
        {"closed", test::random_closed_mesh(3)},
        {"creased", test::with_random_creases(test::random_open_mesh(2), 0.1, 3)},
        {"sheet", test::random_open_mesh(5)}};
    const auto rings = large_rings();
    all.insert(all.end(), rings.begin(), rings.end());
    return all;
  }
};

// The CPU's Editor takes the same moves: both are within the tolerance of a solve from scratch.
TEST_F(EmbedEdit, AgreesWithTheEditor) {
  with_both_variants([&] {
    for (const auto& [name, given] : meshes()) {
      SCOPED_TRACE(name);
      const PolygonMesh mesh = in_singles(given);
      const auto backend = make_cpu_backend();
      EditorOptions options;
      options.fit.tolerance = 1e-6;
      const Fit first = fit(mesh, *backend, options.fit);
      ASSERT_TRUE(first.interpolation.converged);
      Editor editor(mesh, first, options);
      EditHost host(*context_, *submitter_, mesh);
      const double diagonal = host.system.diagonal();
      std::mt19937 random(5);
      std::uniform_int_distribution<std::size_t> any(0, host.system.used_vertices().size() - 1);
      for (int i = 0; i < 8; ++i) {
        std::vector<std::int32_t> vertices;
        std::vector<glm::dvec3> to;
        const double way = (i % 2 == 0 ? 0.01 : 0.1) * diagonal;
        for (int k = 0; k < (i % 3 == 2 ? 3 : 1); ++k) {
          vertices.push_back(host.system.used_vertices()[any(random)]);
          const glm::vec3 place(editor.points()[vertices.back()] +
                                way * glm::dvec3(std::sin(i), std::cos(2 * i), std::sin(3 * i)));
          to.push_back(glm::dvec3(place));
          host.set_point(vertices.back(), place);
        }
        editor.move(vertices, to);
        host.list({vertices.begin(), vertices.end()}, static_cast<std::uint32_t>(vertices.size()));
        host.edit();
        EXPECT_EQ(host.status().state, SolveState::Converged) << host.status().residual;
        EXPECT_LE(host.status().residual, host.stop_error);
        const std::vector<Vertex> found = host.vertices();
        ASSERT_EQ(found.size(), editor.positions().size());
        double farthest = 0;
        for (std::size_t v = 0; v < found.size(); ++v)
          farthest = std::max(farthest,
                              glm::length(glm::dvec3(found[v].position) - editor.positions()[v]));
        EXPECT_LE(farthest, (2e-6 + kSinglesError) * diagonal) << i;
        // What was not made anew is what it would be.
        EXPECT_TRUE(same_bits(found, host.evaluated())) << i;
      }
      // Solves go on from there: nothing is left to do.
      host.solve_all(true);
      EXPECT_EQ(host.status().iterations, 0u) << host.status().residual;
    }
  });
}

TEST_F(EmbedEdit, WeightsAndLevelsAreTheSystems) {
  const PolygonMesh mesh = in_singles(test::with_random_creases(test::random_open_mesh(4), 0.1, 7));
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged})
    for (const int level : {0, 1, 3}) {
      EditHost host(*context_, *submitter_, mesh, {.level = level, .weights = weights});
      PolygonMesh moved = mesh;
      std::vector<std::uint32_t> words;
      for (const std::int32_t v : {3, 11, 12}) {
        moved.positions[v] =
            glm::dvec3(glm::vec3(moved.positions[v] + glm::dvec3(0.1, -0.05, 0.2)));
        host.set_point(v, glm::vec3(moved.positions[v]));
        words.push_back(static_cast<std::uint32_t>(v));
      }
      host.list(words, 3);
      host.edit();
      const std::vector<Vertex> found = host.vertices();
      EXPECT_LT(difference(found, surface_by_cpu(moved, mesh, {.level = level, .weights = weights}))
                    .distance,
                (1e-6 + kSinglesError) * host.system.diagonal());
      EXPECT_TRUE(same_bits(found, host.evaluated()));
    }
}

TEST_F(EmbedEdit, AnEmptyListChangesNothing) {
  EditHost host(*context_, *submitter_, test::torus(30, 20, 1, 0.4));
  const std::vector<Vertex> before = host.vertices();
  // A point that moved without being listed waits.
  host.set_point(7, glm::vec3(2, 2, 2));
  host.list({7}, 0);
  const EditReach reach = host.edit();
  EXPECT_EQ(reach.points, 0u);
  EXPECT_EQ(reach.patches, 0u);
  EXPECT_EQ(reach.listed, 0u);
  EXPECT_TRUE(same_bits(host.vertices(), before));
}

TEST_F(EmbedEdit, AllPointsMayMove) {
  const PolygonMesh mesh = test::torus(30, 20, 1, 0.4), pose = in_singles(posed(mesh, 3));
  with_both_variants([&] {
    EditHost host(*context_, *submitter_, mesh);
    std::vector<std::uint32_t> words;
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      words.push_back(v);
      host.set_point(static_cast<std::int32_t>(v), glm::vec3(pose.positions[v]));
    }
    std::reverse(words.begin(), words.end());
    host.list(words, static_cast<std::uint32_t>(words.size()));
    EXPECT_EQ(host.edit().points, words.size());
    EXPECT_EQ(host.status().state, SolveState::Converged);
    const std::vector<Vertex> found = host.vertices();
    EXPECT_LT(difference(found, surface_by_cpu(pose, mesh, {})).distance,
              (1e-6 + kSinglesError) * host.system.diagonal());
    EXPECT_TRUE(same_bits(found, host.evaluated()));
  });
}

// A host's words may be anything, and name vertices that no face names.
TEST_F(EmbedEdit, ListsMayHoldAnything) {
  PolygonMesh mesh = test::torus(30, 20, 1, 0.4);
  // Unused vertices, so that rows are not the mesh's numbers.
  mesh.positions.insert(mesh.positions.begin(), 5, glm::dvec3(0));
  for (std::int32_t& v : mesh.face_vertices) v += 5;
  const auto edited = [&](const std::vector<std::uint32_t>& words, std::uint32_t count) {
    EditHost host(*context_, *submitter_, mesh);
    host.set_point(40, glm::vec3(mesh.positions[40]) + glm::vec3(0.1f));
    host.set_point(300, glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    host.list(words, count);
    const EditReach reach = host.edit();
    EXPECT_EQ(reach.listed, std::min(count, kMostMoves));
    return host.vertices();
  };
  const std::vector<Vertex> once = edited({40}, 1);
  EXPECT_TRUE(same_bits(edited({40, 40, 40, 0, 4, 605, 0xffffffff, 40}, 8), once));
  EXPECT_TRUE(same_bits(edited({300, 40}, 2), once));
  std::vector<std::uint32_t> all(kMostMoves, 40);
  EXPECT_TRUE(same_bits(edited(all, 0xffffffff), once));
  for (const Vertex& v : once) ASSERT_TRUE(std::isfinite(v.position.x));
}

TEST_F(EmbedEdit, InstancesGetTheBitsOfTheirOwnEdits) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  constexpr std::uint32_t kCount = 4;
  with_both_variants([&] {
    EditHost together(*context_, *submitter_, mesh, {}, kCount);
    const auto count = static_cast<std::uint32_t>(mesh.positions.size());
    std::vector<std::unique_ptr<EditHost>> alone;
    for (std::uint32_t i = 0; i < kCount; ++i)
      alone.push_back(std::make_unique<EditHost>(*context_, *submitter_, mesh));
    for (int round = 0; round < 3; ++round) {
      std::vector<std::uint32_t> words;
      std::uint32_t points = 0;
      for (const std::uint32_t i : {3u, 0u, 2u}) {
        const std::uint32_t vertex = (7 * i + 5 * static_cast<std::uint32_t>(round)) % count;
        // Each stops by itself.
        const glm::vec3 to = glm::vec3(mesh.positions[vertex]) +
                             glm::vec3(0.1f * std::pow(0.03f, static_cast<float>(i)));
        together.set_point(static_cast<std::int32_t>(vertex), to, i);
        alone[i]->set_point(static_cast<std::int32_t>(vertex), to);
        words.push_back(i * count + vertex);
        alone[i]->list({vertex}, 1);
        points += alone[i]->edit().points;
      }
      together.list(words, 3);
      EXPECT_EQ(together.edit().points, points);
      for (std::uint32_t i = 0; i < kCount; ++i) {
        EXPECT_TRUE(same_bits(together.vertices(i), alone[i]->vertices())) << i;
        if (i != 1) {
          EXPECT_EQ(bits_of(together.status(i)), bits_of(alone[i]->status())) << i;
        }
      }
    }
  });
}

// By count: rows and patches, which are what is read and written, do not grow with the mesh.
TEST_F(EmbedEdit, CostDoesNotGrowWithTheMesh) {
  constexpr std::uint32_t kSteps = 6, kSide = 2 * kSteps + 3;
  std::vector<EditReach> all;
  std::vector<std::map<std::string, int>> calls;
  for (const int size : {1, 4}) {
    const PolygonMesh mesh = test::torus(60 * size, 30 * size, 1, 0.4);
    EditHost host(*context_, *submitter_, mesh);
    host.set_point(900, glm::vec3(mesh.positions[900]) + glm::vec3(0.01f));
    host.list({900}, 1);
    const std::vector<Vertex> before = host.vertices();
    std::map<std::string, int>& since = calls.emplace_back();
    HostCommands commands(*own_);
    commands.record([&](VkCommandBuffer buffer) {
      const std::map<std::string, int> earlier = PretendedDriver::counts();
      host.record(buffer, {.iterations = kSteps});
      for (const auto& [name, count] : PretendedDriver::counts()) {
        const auto found = earlier.find(name);
        const int more = count - (found == earlier.end() ? 0 : found->second);
        if (more > 0) since[name] = more;
      }
    });
    for (const auto& [name, count] : since) EXPECT_THAT(name, StartsWith("vkCmd"));
    commands.submit();
    commands.wait();
    all.push_back(host.reach());
    const std::vector<Vertex> after = host.vertices();
    std::uint32_t changed = 0;
    for (std::size_t v = 0; v < after.size(); ++v)
      changed += std::memcmp(&after[v], &before[v], sizeof(Vertex)) != 0;
    // Of level 2, between the outermost control points that moved and the next ones.
    constexpr std::uint32_t kRows = (4 * kSide - 1) * (4 * kSide - 1);
    EXPECT_LE(changed, kRows);
    EXPECT_GT(changed, kRows * 9 / 10);
  }
  EXPECT_EQ(all[0].points, kSide * kSide);
  EXPECT_EQ(all[0].patches, 8 * kSide * kSide);
  EXPECT_EQ(std::memcmp(&all[0], &all[1], sizeof all[0]), 0);
  EXPECT_EQ(calls[0], calls[1]);
  EXPECT_GT(calls[0]["vkCmdDispatchIndirect"], 2 * int(kSteps));
  // The count of the list, and the status.
  EXPECT_EQ(calls[0]["vkCmdDispatch"], 2);
}

TEST_F(EmbedEdit, KernelsMayWriteTheList) {
  const PolygonMesh mesh = test::icosphere(2);
  EditHost host(*context_, *submitter_, mesh);
  const Buffer device(*context_, host.moves.size() + 256, MemoryUse::Device);
  const Buffer output(*context_, host.output.size(), MemoryUse::Device);
  const vulkan::Solve solve(*context_, host.tables,
                            {.given = {host.points.handle()},
                             .vertices = {output.handle()},
                             .moved = {device.handle(), 12, kMostMoves}});
  SolveParameters parameters = iterations(60);
  parameters.stop_error = host.stop_error;
  submitter_->run([&](VkCommandBuffer commands) {
    solve.record_solve(commands, parameters);
    solve.record_evaluate(commands);
  });
  host.set_point(17, glm::vec3(mesh.positions[17]) * 1.1f);
  host.list({17}, 1);
  host.edit();
  const std::vector<Vertex> expected = host.vertices();
  submitter_->run([&](VkCommandBuffer commands) {
    const VkBufferCopy copy{0, 12, host.moves.size()};
    context_->vk().vkCmdCopyBuffer(commands, host.moves.handle(), device.handle(), 1, &copy);
    record_barrier(*context_, commands, kCopyScope, kEntryScope);
    solve.record_edit(commands, {.iterations = 40, .stop_error = host.stop_error});
    record_barrier(*context_, commands, kExitScope, kEntryScope);
    const VkBufferCopy back{0, 0, output.size()};
    context_->vk().vkCmdCopyBuffer(commands, output.handle(), host.output.handle(), 1, &back);
  });
  EXPECT_TRUE(same_bits(host.vertices(), expected));
}

// Residuals are made from the points each time, so that nothing adds up.
TEST_F(EmbedEdit, ThousandsOfEditsKeepTheTolerance) {
  const PolygonMesh mesh = in_singles(test::torus(24, 14, 2, 0.7));
  EditHost host(*context_, *submitter_, mesh);
  PolygonMesh moved = mesh;
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    host.record(buffer, {.iterations = 24, .stop_error = host.stop_error});
  });
  std::mt19937 random(2);
  std::uniform_int_distribution<std::uint32_t> any(0, 24 * 14 - 1);
  std::uniform_real_distribution<float> way(-0.03f, 0.03f);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t v = any(random);
    const glm::vec3 to =
        glm::vec3(mesh.positions[v]) + glm::vec3(way(random), way(random), way(random));
    moved.positions[v] = glm::dvec3(to);
    host.set_point(static_cast<std::int32_t>(v), to);
    host.list({v}, 1);
    commands.submit();
    commands.wait();
    ASSERT_EQ(host.status().state, SolveState::Converged) << i;
  }
  EXPECT_LT(difference(host.vertices(), surface_by_cpu(moved, mesh, {})).distance,
            (1e-6 + kSinglesError) * host.system.diagonal());
  host.solve_all(true);
  EXPECT_EQ(host.status().iterations, 0u) << host.status().residual;
}

// Recording cannot fail; the host hears of it, once for each call.
TEST_F(EmbedEdit, WithoutAListAHostIsTold) {
  std::vector<std::string> lines;
  bool throws = false;
  HostDevice host = own_->host_device();
  host.log = [&](std::string_view line) {
    lines.emplace_back(line);
    if (throws) throw Error(ErrorCode::Cancelled, "of the host's log");
  };
  Context context(host);
  const System system(test::icosphere(1));
  const DeviceSystem tables(context, system, {.takes_edits = true});
  const Buffer list(context, 4096, MemoryUse::Device), points(context, 4096, MemoryUse::Device);
  const vulkan::Solve none(context, tables, {.given = {points.handle()}}),
      one(context, tables, {.further_slots = {{.moved = {list.handle(), 0, 9}}}});
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    const auto told = [&](const auto& record) {
      lines.clear();
      const std::map<std::string, int> before = PretendedDriver::counts();
      record();
      EXPECT_EQ(PretendedDriver::counts() == before, !lines.empty());
      return lines;
    };
    for (const bool is_thrown : {false, true}) {
      throws = is_thrown;
      const auto no_list = ElementsAre(
          "planish: record_edit does nothing, as its slot has no list; set SolveOptions::moved, or "
          "FrameSlot::moved");
      EXPECT_THAT(told([&] { none.record_edit(buffer, {}); }), no_list);
      EXPECT_THAT(told([&] { one.record_edit(buffer, {.slot = 0}); }), no_list);
      EXPECT_THAT(told([&] { none.record_reach(buffer, list.handle(), 0); }),
                  ElementsAre(HasSubstr("record_reach does nothing")));
      EXPECT_THAT(told([&] { none.record_given(buffer, list.handle(), 0); }),
                  ElementsAre(HasSubstr("record_given does nothing")));
    }
    EXPECT_THAT(told([&] { one.record_reach(buffer, list.handle(), 0); }), IsEmpty());
    EXPECT_THAT(told([&] { one.record_given(buffer, points.handle(), 0); }), IsEmpty());
  });
}

TEST_F(EmbedEdit, WhatCannotBeHadIsRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);
  const auto expect_refusal = [&](ErrorCode code, const std::string& words, const auto& action) {
    const auto alive = [] {
      std::map<std::string, int> all = PretendedDriver::alive();
      all.erase("Pipeline");  // a Context keeps them
      return all;
    };
    const std::map<std::string, int> before = alive();
    try {
      action();
      ADD_FAILURE() << "nothing thrown: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
    EXPECT_EQ(alive(), before);
  };
  const DeviceSystemOptions edits{.takes_edits = true};
  const System fair(mesh, {.method = InterpolationMethod::Fair}), apart(mesh, {.within = 0.01});
  const System system(mesh);
  using enum ErrorCode;
  expect_refusal(InvalidArgument, "edits are of the progressive method",
                 [&] { const DeviceSystem tables(*context_, fair, edits); });
  expect_refusal(InvalidArgument, "edits take surfaces through their points",
                 [&] { const DeviceSystem tables(*context_, apart, edits); });
  {
    const DeviceSystem plain(*context_, system), tables(*context_, system, edits);
    const Buffer list(*context_, 4096, MemoryUse::Device);
    const auto solve_with = [&](const DeviceSystem& of, const MovedPoints& moved) {
      const vulkan::Solve solve(*context_, of, {.moved = moved});
    };
    expect_refusal(InvalidArgument, "make it with takes_edits", [&] {
      solve_with(plain, {list.handle(), 0, 9});
    });
    expect_refusal(InvalidArgument, "max_count of 0", [&] { solve_with(tables, {list.handle()}); });
    expect_refusal(InvalidArgument, "begins at 6, which is no multiple of 4", [&] {
      solve_with(tables, {list.handle(), 6, 9});
    });
  }
  // 4,800 corners' points of level 1; rows of 1,271 vertices.
  const System sheet(test::flat_grid(40, 30), {.level = 0});
  const auto expect_limit = [&](std::uint32_t range, const std::string& words) {
    PretendedDriver::pretence().storage_range = range;
    open();
    const Buffer moves(*context_, 4096, MemoryUse::Device);
    expect_refusal(OutOfMemory, words, [&] {
      const DeviceSystem cut(*context_, sheet, {24, false, true});
      const vulkan::Solve solve(*context_, cut, {.moved = {moves.handle(), 0, 9}});
    });
  };
  expect_limit(80000,
               "points of level 1 take 81280 bytes of one binding, but "
               "maxStorageBufferRange is 80000");
  expect_limit(85000, "the limit masks are in 2 slices, edits take one");
}

}  // namespace
}  // namespace planish::testing
