#include "planish/osd/vk_stencil_table.h"

#include <numeric>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/stencil/stencil_table.h"
#include "planish/vulkan/tables/device_table.h"

namespace planish::osd {

namespace {

using OpenSubdiv::Far::LimitStencilTable;
using OpenSubdiv::Far::StencilTable;
using AnyStencilTable = OpenSubdiv::Far::StencilTableReal<float>;

/// A table's rows without weights. Offsets are made: OpenSubdiv's factories leave them out on
/// request.
class Rows {
 public:
  explicit Rows(AnyStencilTable const& table) {
    _view.source_count = table.GetNumControlVertices();
    _view.sizes = table.GetSizes();
    _view.indices = table.GetControlIndices();
    _offsets.resize(_view.sizes.size());
    std::exclusive_scan(_view.sizes.begin(), _view.sizes.end(), _offsets.begin(), 0);
    _view.offsets = _offsets;
    for (std::size_t i = 0; i < _view.indices.size(); ++i)
      if (_view.indices[i] < 0 || _view.indices[i] >= _view.source_count)
        throw Error(ErrorCode::InvalidArgument,
                    formatted("stencil table: entry {} reads vertex {} of {} control vertices; set "
                              "factorizeIntermediateLevels",
                              i, _view.indices[i], _view.source_count),
                    static_cast<std::int64_t>(i));
  }

  /// Null where there are no such weights.
  std::unique_ptr<vulkan::DeviceTable> Upload(std::vector<float> const& weights,
                                              VkDeviceContext& deviceContext) {
    // OpenSubdiv may leave more weights than entries.
    if (weights.size() < _view.indices.size()) return nullptr;
    _view.weights = std::span(weights).first(_view.indices.size());
    vulkan::DeviceTableOptions options;
    // Strides are known to evaluators only: they cut rows where a binding would span too much.
    options.source_stride = options.target_stride = sizeof(float);
    auto table = std::make_unique<vulkan::DeviceTable>(deviceContext.GetContext(), _view, options);
    for (std::size_t i = 0; i < table->slices().size(); ++i) {
      vulkan::DeviceTable::Slice const& slice = table->slices()[i];
      vulkan::PackedSlice const packed = table->pack(i, _view);
      deviceContext.Upload(slice.chunks.handle(), 0, std::as_bytes(std::span(packed.chunks)));
      deviceContext.Upload(slice.entries.handle(), 0, std::as_bytes(std::span(packed.entries)));
    }
    table->finish_packing();
    return table;
  }

 private:
  StencilView<float> _view;
  std::vector<int> _offsets;
};

}  // namespace

VkStencilTable::VkStencilTable(AnyStencilTable const& table, VkDeviceContext& deviceContext)
    : _numStencils(table.GetNumStencils()),
      _numControlVertices(table.GetNumControlVertices()),
      _deviceContext(deviceContext) {}

VkStencilTable::~VkStencilTable() {
  for (auto const& weights : _weights)
    if (weights) _deviceContext.Retire(weights);
}

vulkan::DeviceTable const* VkStencilTable::GetWeights(StencilWeights weights) const {
  return _weights[static_cast<std::size_t>(weights)].get();
}

VkStencilTable* VkStencilTable::Create(StencilTable const* table, VkDeviceContext* deviceContext) {
  std::unique_ptr<VkStencilTable> result(new VkStencilTable(*table, *deviceContext));
  result->_weights[0] = Rows(*table).Upload(table->GetWeights(), *deviceContext);
  return result.release();
}

VkStencilTable* VkStencilTable::Create(LimitStencilTable const* table,
                                       VkDeviceContext* deviceContext) {
  std::unique_ptr<VkStencilTable> result(new VkStencilTable(*table, *deviceContext));
  Rows rows(*table);
  std::vector<float> const* const weights[] = {&table->GetWeights(),    &table->GetDuWeights(),
                                               &table->GetDvWeights(),  &table->GetDuuWeights(),
                                               &table->GetDuvWeights(), &table->GetDvvWeights()};
  for (int i = 0; i < kStencilWeightsCount; ++i)
    result->_weights[i] = rows.Upload(*weights[i], *deviceContext);
  return result.release();
}

}  // namespace planish::osd
