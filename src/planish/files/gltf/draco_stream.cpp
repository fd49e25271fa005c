// Based on: Khronos Group, "KHR_draco_mesh_compression", 2018; Google, "Draco 3D Graphics
// Compression, Bitstream Specification 2.2", 2023.
#include "planish/files/gltf/gltf_source.h"

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

namespace planish {
namespace {

// Draco's own encoder packs up to 16 triangles of a plane grid in a byte, and 4 of a wavy one.
constexpr std::int64_t kMostPackedPerByte = 64;
// Each takes memory for every corner or point, named or not.
constexpr std::int64_t kMostAttributes = 32;
constexpr std::int64_t kMostNumbers = 64;  // of all attributes of a point

// Draco's decoder with looks at what it is about to take memory for.
template <class Decoder>
class BoundedDecoder : public Decoder {
 public:
  explicit BoundedDecoder(const DracoCounts& wanted) : wanted_(wanted) {}
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer ahead = *this->buffer();
    std::uint32_t triangle_count = 0, vertex_count = 0;
    std::uint8_t attribute_count = 0;
    const bool is_read = kIsSequential ? draco::DecodeVarint(&triangle_count, &ahead) &&
                                             draco::DecodeVarint(&vertex_count, &ahead)
                                       : draco::DecodeVarint(&vertex_count, &ahead) &&
                                             draco::DecodeVarint(&triangle_count, &ahead) &&
                                             ahead.Decode(&attribute_count);
    if (!is_read) return false;
    if (3 * std::int64_t{triangle_count} != wanted_.corner_count)
      return refuse(formatted("the stream has {} triangles, and the indices {} corners",
                              triangle_count, wanted_.corner_count));
    if (attribute_count > kMostAttributes) return refuse_attributes();
    return Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const auto point_count = std::int64_t{this->point_cloud()->num_points()};
    if (point_count != wanted_.point_count)
      return refuse(formatted("the stream has {} points, and the positions {}", point_count,
                              wanted_.point_count));
    if (this->point_cloud()->num_attributes() > kMostAttributes) return refuse_attributes();
    std::int64_t number_count = 0;
    for (int i = 0; i < this->point_cloud()->num_attributes(); ++i)
      number_count += this->point_cloud()->attribute(i)->num_components();
    if (number_count > kMostNumbers)
      return refuse(formatted("the attributes of a point have more than {} numbers", kMostNumbers));
    return Decoder::DecodeAllAttributes();
  }

 private:
  static constexpr bool kIsSequential = std::is_same_v<Decoder, draco::MeshSequentialDecoder>;

  bool refuse(std::string why) {
    refusal_ = std::move(why);
    return false;
  }
  bool refuse_attributes() {
    return refuse(formatted("the stream has more than {} attributes", kMostAttributes));
  }

  DracoCounts wanted_;
  std::string refusal_;
};

template <class Decoder>
void decode(const JsonPlace& extension, std::span<const std::byte> stream,
            const DracoCounts& wanted, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  const draco::DecoderOptions options;
  BoundedDecoder<Decoder> decoder(wanted);
  const draco::Status status = decoder.Decode(options, &buffer, &mesh);
  if (!decoder.refusal().empty()) extension.fail(decoder.refusal());
  if (!status.ok())
    extension.fail(std::string("the stream is no Draco mesh: ") + status.error_msg());
}

std::int64_t component_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return 5120;
    case draco::DT_UINT8:
      return 5121;
    case draco::DT_INT16:
      return 5122;
    case draco::DT_UINT16:
      return 5123;
    case draco::DT_UINT32:
      return 5125;
    case draco::DT_FLOAT32:
      return 5126;
    default:
      return 0;
  }
}

UnpackedElements corners_of(const JsonPlace& extension, const draco::Mesh& mesh) {
  UnpackedElements corners{.count = 3 * std::int64_t{mesh.num_faces()},
                           .number_count = 1,
                           .component = component_of(draco::DT_UINT32),
                           .bytes = {}};
  corners.bytes.resize(static_cast<std::size_t>(corners.count) * 4);
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      triangle[k] = mesh.face(draco::FaceIndex(f))[k].value();
      if (triangle[k] >= mesh.num_points())
        extension.fail("triangle {} of the stream names point {} of {}", f, triangle[k],
                       mesh.num_points());
    }
    std::memcpy(corners.bytes.data() + std::size_t{f} * 12, triangle.data(), 12);
  }
  return corners;
}

UnpackedElements elements_of(const JsonPlace& extension, const draco::Mesh& mesh,
                             const draco::PointAttribute& attribute) {
  UnpackedElements elements{.count = mesh.num_points(),
                            .number_count = attribute.num_components(),
                            .component = component_of(attribute.data_type()),
                            .bytes = {}};
  const auto size = static_cast<std::size_t>(attribute.byte_stride());
  elements.bytes.resize(static_cast<std::size_t>(elements.count) * size);
  for (std::uint32_t point = 0; point < mesh.num_points(); ++point) {
    const draco::AttributeValueIndex value = attribute.mapped_index(draco::PointIndex(point));
    if (value.value() >= attribute.size())
      extension.fail("point {} of the stream has no value", point);
    attribute.GetValue(value, elements.bytes.data() + point * size);
  }
  return elements;
}

}  // namespace

bool reads_draco() { return true; }

DracoMesh decode_draco(const JsonPlace& extension, std::span<const std::byte> stream,
                       const DracoCounts& wanted) {
  constexpr std::size_t kHeaderBytes = 11;
  constexpr std::byte kVersion{2}, kMesh{1}, kSequential{0}, kEdgebreaker{1};
  const auto is_mesh = [&](std::byte method) {
    return stream.size() >= kHeaderBytes && std::memcmp(stream.data(), "DRACO", 5) == 0 &&
           stream[5] == kVersion && stream[6] == kVersion && stream[7] == kMesh &&
           stream[8] == method;
  };
  if (!is_mesh(kSequential) && !is_mesh(kEdgebreaker))
    extension.fail("the stream is no mesh of Draco's bitstream 2.2");
  const auto most = kMostPackedPerByte * static_cast<std::int64_t>(stream.size());
  if (wanted.corner_count > 3 * most || wanted.point_count > most)
    extension.fail("{} corners of {} points cannot come from {} bytes", wanted.corner_count,
                   wanted.point_count, stream.size());
  draco::Mesh mesh;
  if (is_mesh(kSequential)) {
    decode<draco::MeshSequentialDecoder>(extension, stream, wanted, mesh);
  } else {
    decode<draco::MeshEdgebreakerDecoder>(extension, stream, wanted, mesh);
  }
  DracoMesh unpacked{.corners = corners_of(extension, mesh), .by_identifier = {}};
  for (int i = 0; i < mesh.num_attributes(); ++i) {
    const draco::PointAttribute& attribute = *mesh.attribute(i);
    unpacked.by_identifier.insert_or_assign(attribute.unique_id(),
                                            elements_of(extension, mesh, attribute));
  }
  return unpacked;
}

}  // namespace planish
