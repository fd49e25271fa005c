// The bits of a sum of squares, in the order of the numbers: what is no number counts as infinite.
uint square_bits(float square) { return min(floatBitsToUint(square) & 0x7fffffffu, 0x7f800000u); }
