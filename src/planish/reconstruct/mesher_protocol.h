#pragma once

#include <array>
#include <cstdint>

namespace planish {

// What a program and the mesher that it starts say to each other over the mesher's standard input
// and output, in the machine's own byte order.
//
// Input: kMesherMagic, the number of points as int64, then x, y, z of each as double.
// Output: messages, each a byte and 8 bytes of payload:
//   kMesherProgress   the fraction that is done, double;
//   kMesherTriangles  their number as int64; then three int32 each; the last message;
//   kMesherFailure    the length of the text as int64; then an int32 ErrorCode and the text; the
//                     last message.

inline constexpr std::array<char, 8> kMesherMagic = {'p', 'l', 'n', 'm', 's', 'h', '0', '1'};
inline constexpr char kMesherProgress = 'P';
inline constexpr char kMesherTriangles = 'T';
inline constexpr char kMesherFailure = 'F';

}  // namespace planish
