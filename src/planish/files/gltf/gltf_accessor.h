#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "planish/files/gltf/draco_stream.h"
#include "planish/files/gltf/gltf_source.h"

namespace planish {

/// A typed array whose every element lies within its buffer view.
class GltfAccessor {
 public:
  /// Vectors: of one to four numbers each. Matrices: of 4 by 4, by columns.
  enum class Use {
    Positions,
    Normals,
    Indices,
    TextureCoordinates,
    Colors,
    Numbers,
    Vectors,
    Matrices
  };

  /// Checks everything before any element can be asked for: component and element type for the
  /// use, count, offset, stride, and the same of the elements that a sparse accessor has in the
  /// place of others. The elements come from `unpacked` where it is given, which must live longer
  /// and cannot be sparse. Without a buffer view they are zeros, where the format has it so;
  /// indices of zero alone are refused. Throws Error{UnreadableInput}.
  GltfAccessor(const JsonPlace& root, std::int64_t index, Use use, GltfSource& source,
               const UnpackedElements* unpacked = nullptr);

  [[nodiscard]] std::int64_t count() const { return count_; }
  /// Of Use::Positions and Use::Normals; normalised integers are scaled. May not be finite.
  [[nodiscard]] glm::dvec3 position(std::int64_t index) const;
  /// Of Use::TextureCoordinates. May not be finite.
  [[nodiscard]] glm::dvec2 texture_coordinate(std::int64_t index) const;
  /// Of Use::Colors, opaque where there is no alpha. May not be finite.
  [[nodiscard]] glm::vec4 color(std::int64_t index) const;
  /// Of Use::Numbers. May not be finite.
  [[nodiscard]] double value(std::int64_t index) const { return number(index, 0); }
  /// Of Use::Vectors and Use::Matrices: the k-th of number_count().
  [[nodiscard]] double value(std::int64_t index, std::int64_t k) const { return number(index, k); }
  [[nodiscard]] std::int64_t number_count() const { return number_count_; }
  /// Whole numbers that are not scaled to parts of 1.
  [[nodiscard]] bool is_integer() const { return component_ != Float && !normalized_; }
  /// Those without a sign, below 2^16.
  [[nodiscard]] bool is_short() const {
    return !normalized_ && (component_ == UByte || component_ == UShort);
  }
  /// Of Use::Indices.
  [[nodiscard]] std::uint32_t index(std::int64_t index) const;

 private:
  enum Component {
    Byte = 5120,
    UByte = 5121,
    Short = 5122,
    UShort = 5123,
    UInt = 5125,
    Float = 5126
  };

  void use_view(const JsonPlace& root, const JsonPlace& place, GltfSource& source);
  void use_elements(const JsonPlace& place, const UnpackedElements& unpacked);
  void use_sparse(const JsonPlace& root, const JsonPlace& place, std::int64_t index,
                  GltfSource& source);
  void require_ascending(const JsonPlace& indices) const;
  [[nodiscard]] std::uint32_t sparse_index(std::int64_t place) const;
  [[nodiscard]] std::span<const std::byte> element(std::int64_t index) const;
  [[nodiscard]] double component(std::span<const std::byte> bytes) const;
  // The k-th number of an element.
  [[nodiscard]] double number(std::int64_t index, std::int64_t k) const;

  std::span<const std::byte> bytes_;  // empty: zeros, but for sparse elements
  // Elements in the place of others: their numbers, ascending, and the elements, packed tightly.
  std::span<const std::byte> sparse_indices_, sparse_values_;
  std::int64_t sparse_count_ = 0, sparse_index_bytes_ = 0;
  std::int64_t count_ = 0, stride_ = 0, component_bytes_ = 0, number_count_ = 0;
  Component component_ = Float;
  bool normalized_ = false;
};

}  // namespace planish
