#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/files/formats.h"
#include "planish/files/mesh_file.h"
#include "planish/files/shared/text_lines.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// STL, text or binary (recognised by its size of 84 + 50 n bytes), welded by position, at open
/// edges within two steps of float32 where that closes them, with a warning; triangles without area
/// are left out with a warning, colours too, and, unless the file is strict, lines of other words
/// outside facets and zeros behind a binary file's triangles. The result does not depend on
/// `part_bytes`, of which a thread reads about so many at a time of text. Conditions and exceptions
/// as read_mesh().
[[nodiscard]] MeshFile read_stl(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// Geomview OFF with the prefixes ST, C and N: positions, colours (sRGB, three or four numbers from
/// 0 to 1 or from 0 to 255: see settle_colors()), texture coordinates; normals are passed over,
/// colours of faces and numbers that the keyword does not promise left out with a warning. Text has
/// a line for each vertex and face, or is read as words where it is whole so, with a warning unless
/// the file is strict. `OFF BINARY` has numbers of 32 bits, big endian, or as the counts fit,
/// with a warning. The result does not depend on `part_bytes`, of which a thread reads about so
/// many at a time of text. Conditions and exceptions as read_mesh().
[[nodiscard]] MeshFile read_off(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// Columns behind x, y and z that are read.
inline constexpr std::size_t kMaxPointColumns = 40;

/// What the columns of points as text are: a first line may name them, else number and values tell
/// intensity, normals of unit length and colours from 0 to 255 apart, which a warning says.
struct PointColumns {
  std::vector<std::string> names;  ///< of all; empty: nobody names them
  std::size_t further = 0;         ///< behind x, y and z
  /// Where intensity, or intensity and colours, behind the place are the format's own.
  bool is_pts = false;
};

/// What is not as it should be in some columns of some points.
struct ColumnFaults {
  std::uint64_t columns = 0;  ///< by bit, those that lack a number somewhere
  std::int64_t line = 0;      ///< the first
  std::string what;

  void add(std::size_t column, std::int64_t at_line, std::string_view found);
};

/// Gives a cloud the numbers behind the places of its points, `columns.further` of each, as its
/// colours, normals and attributes. Warnings: "columns" where nobody names them, or they are left
/// out; "left-out-properties".
void add_columns(const PointColumns& columns, std::span<const float> values,
                 const ColumnFaults& faults, std::string_view file, PointCloud& cloud);

/// The words of a line that names columns, in small letters; empty unless x, y and z are among
/// them.
[[nodiscard]] std::vector<std::string> column_names(std::string_view line);

/// The next column of a line, behind which the line goes on; empty at its end. Quotes around it are
/// no part of it.
[[nodiscard]] std::string_view take_column(std::string_view& line);

/// A number with a comma in a line whose columns other signs separate, as `1,5 2,5 3,5` or
/// `1,5;2;3` have: the comma stands for a decimal point, or between thousands. Empty: there is
/// none, so that commas separate columns.
[[nodiscard]] std::string_view number_with_comma(std::string_view line);

/// Points as text: x y z separated by blanks, commas or semicolons, then what PointColumns says;
/// lines of x, y and z with a `nan` are counted as missing. A first line of words or a comment
/// before the points may name the columns; other such lines are passed over. The result does not
/// depend on `part_bytes`, which a thread reads at a time. Exceptions as read_points().
[[nodiscard]] PointCloud read_xyz(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// The same, where a line of one integer stands before the points that it counts, and one column
/// behind x, y and z is intensity, four are intensity, red, green and blue.
[[nodiscard]] PointCloud read_pts(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// Expands LZF data of LibLZF's format to `size` bytes. Empty when the data would read or write
/// out of bounds or gives another size. A size above what the data can expand to is refused before
/// memory is taken.
[[nodiscard]] std::vector<std::byte> expand_lzf(std::span<const std::byte> data, std::size_t size);

/// PCD (Point Cloud Library) up to version 0.7: ascii, binary and binary_compressed; x, y and z of
/// any scalar type, normal_x, normal_y and normal_z as floats, rgb or rgba packed in 32 bits of
/// sRGB; the file's byte order is little endian. The viewpoint tells where the sensor stood and
/// moves nothing. Points with a nan are counted as missing. Lines of the header that begin with
/// other words are passed over with a warning, unless the file is strict or they may be a misspelt
/// count. The result does not depend on `part_bytes`, of which a thread reads about so many at a
/// time of text. Exceptions as read_points().
[[nodiscard]] PointCloud read_pcd(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// What a scanner's file says besides its points.
struct ScanContents {
  /// Names as the file, or its format, has them, with what they count, in the file's order.
  using Counts = std::vector<std::pair<std::string, std::int64_t>>;

  std::string version;            ///< "LAS 1.2, point format 3, 34 bytes a point"
  std::string software;           ///< that wrote it
  std::string coordinate_system;  ///< as text; empty: not said
  Counts scans;                   ///< places or flight lines, with their points
  Counts classes;                 ///< of points
};

/// LAS 1.0 to 1.4, not compressed: positions by the file's scale and offset, colours of 16 bits
/// (of 8, where none is above 255; none where all are 0), sRGB. Points that are withheld or
/// classified as noise are left out, with the warning "noise-points". Exceptions as read_points().
[[nodiscard]] PointCloud read_las(const FileBytes& file);

/// Flight lines by their number, classes by the standard's names. Exceptions as read_points().
[[nodiscard]] ScanContents las_contents(const FileBytes& file);

/// Scans of a PTX one after another, each point moved by its scan's matrix; points at the scanner
/// (0 0 0), where it saw nothing, are counted as missing. Colours are read where all points of all
/// scans have them. The result does not depend on `part_bytes`, which a thread reads at a time.
/// Exceptions as read_points().
[[nodiscard]] PointCloud read_ptx(const FileBytes& file, std::size_t part_bytes = kTextPartBytes);

/// Scans by their number, size and place. Exceptions as read_points().
[[nodiscard]] ScanContents ptx_contents(const FileBytes& file);

}  // namespace planish
