#include "osd/layouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace planish::testing {

namespace {

using OpenSubdiv::Osd::BufferDescriptor;

// Of the largest magnitude in a buffer.
constexpr double kTolerance = 1e-6;
constexpr float kMark = 0.75f;

Layout apart(const std::string& name, BufferDescriptor source, BufferDescriptor destination) {
  Layout layout{name};
  layout.source = source;
  for (int i = 0; i < kDestinations; ++i) {
    layout.destinations[i] = destination;
    layout.destinations[i].offset += 3 * i;
    layout.destinations[i].stride += i;
  }
  return layout;
}

Layout together(const std::string& name, BufferDescriptor source, bool in_place) {
  Layout layout{name, true, in_place};
  layout.source = source;
  const int length = source.length;
  const int stride = in_place ? source.stride : kDestinations * length + 1;
  for (int i = 0; i < kDestinations; ++i)
    layout.destinations[i] = {i * length + (in_place ? length : 1), length, stride};
  return layout;
}

std::size_t end_of(const BufferDescriptor& desc, int count) {
  return count > 0 ? place(desc, count - 1, desc.length) : 0;
}

}  // namespace

std::vector<Layout> all_layouts() {
  return {apart("tight 3", {0, 3, 3}, {0, 3, 3}),  apart("gaps 3", {2, 3, 8}, {5, 3, 11}),
          apart("tight 4", {0, 4, 4}, {0, 4, 4}),  apart("one float", {0, 1, 1}, {3, 1, 4}),
          apart("far 7", {70, 7, 9}, {131, 7, 7}), together("one destination 5", {1, 5, 6}, false),
          together("in place 2", {0, 2, 14}, true)};
}

std::vector<Layout> patch_layouts() {
  const std::vector<Layout> all = all_layouts();
  return {all[1], all[5], all[6]};
}

Floats::Floats(const Layout& layout, const Cage& cage, int sources, int rows, int count) {
  std::size_t source_end = end_of(layout.source, sources);
  buffers.resize(1);
  for (int i = 0; i < count; ++i) {
    destination[i] = layout.in_place ? 0 : layout.one_destination ? 1 : 1 + std::size_t(i);
    buffers.resize(std::max(buffers.size(), destination[i] + 1));
    std::vector<float>& buffer = buffers[destination[i]];
    buffer.resize(std::max(buffer.size(), end_of(layout.destinations[i], rows)), kMark);
  }
  buffers[0].resize(std::max(buffers[0].size(), source_end), kMark);
  for (int i = 0; i < sources; ++i)
    for (int c = 0; c < layout.source.length; ++c) {
      const std::size_t vertex = i % cage.positions.size();
      const int copy = c / 3;
      buffers[0][place(layout.source, i, c)] =
          cage.positions[vertex][c % 3] + 0.25f * static_cast<float>(copy) * (vertex % 5);
    }
}

DeviceFloats::DeviceFloats(const Floats& floats, osd::VkDeviceContext& context) {
  for (const std::vector<float>& buffer : floats.buffers) {
    const int size = static_cast<int>(buffer.size());
    buffers.emplace_back(osd::VkVertexBuffer::Create(1, size, &context));
    buffers.back()->UpdateData(buffer.data(), 0, size, &context);
  }
}

std::vector<std::vector<float>> DeviceFloats::read(osd::VkDeviceContext& context) const {
  std::vector<std::vector<float>> result;
  for (const auto& buffer : buffers) {
    result.emplace_back(buffer->GetNumVertices());
    buffer->ReadData(result.back().data(), 0, buffer->GetNumVertices(), &context);
  }
  return result;
}

void Tally::compare(const std::string& name, const std::vector<std::vector<float>>& expected,
                    const std::vector<std::vector<float>>& got) {
  ++evaluations;
  ASSERT_EQ(expected.size(), got.size()) << name;
  for (std::size_t b = 0; b < expected.size(); ++b) {
    ASSERT_EQ(expected[b].size(), got[b].size()) << name;
    double magnitude = 0, difference = 0;
    for (std::size_t i = 0; i < expected[b].size(); ++i) {
      ASSERT_TRUE(std::isfinite(expected[b][i])) << name << ", buffer " << b << ", float " << i;
      magnitude = std::max(magnitude, std::abs(double(expected[b][i])));
      // Not-a-numbers compare to nothing: count them as far off.
      const double off = std::abs(double(expected[b][i]) - double(got[b][i]));
      difference = std::max(difference, std::isnan(off) ? HUGE_VAL : off);
      if (off == 0) {
        ASSERT_EQ(std::signbit(expected[b][i]), std::signbit(got[b][i])) << name << i;
      }
    }
    floats += static_cast<long long>(expected[b].size());
    EXPECT_LE(difference, kTolerance * magnitude) << name << ", buffer " << b;
    if (magnitude > 0) largest = std::max(largest, difference / magnitude);
  }
}

void Tally::print() const {
  std::printf(
      "%d meshes, %lld evaluations, %lld floats compared, largest difference %.3g of the "
      "largest magnitude in the buffer\n",
      cages, evaluations, floats, largest);
}

}  // namespace planish::testing
