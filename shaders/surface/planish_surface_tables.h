// What a surface's tables are, for planish_surface.glsl; part of shared.h.
#ifndef PLANISH_SURFACE_TABLES
#define PLANISH_SURFACE_TABLES
#ifndef __cplusplus
#define PLANISH_SHARED_CONSTANT const uint
#endif

// No corner, vertex or word.
PLANISH_SHARED_CONSTANT kNone = 0xffffffffu;
// A point of level 1 is held as its offset from a given vertex, whose number stands in the fourth
// float: with this bit, every number is that of a normal float, which nothing flushes to zero.
PLANISH_SHARED_CONSTANT kVertexTag = 0x40000000u;
// Words: the first corner of each face and of none; two of each corner, where its class's words are
// and where the list of its points is, or kNone; those of the classes; the lists. Words of a class
// of corners: columns without the own one, ring, face, first weight, flags.
PLANISH_SHARED_CONSTANT kPlaceClassWords = 5u;
PLANISH_SHARED_CONSTANT kOnePolynomial = 1u;     // all of the patch
PLANISH_SHARED_CONSTANT kSingularAtVertex = 2u;  // no polynomial ends at V
PLANISH_SHARED_CONSTANT kSingularAtFace = 4u;    // nor at F
// Halvings towards V or F until its own limit stands in: as many as a float has digits.
PLANISH_SHARED_CONSTANT kPlaceHalvings = 24u;
// A class's weights, cell by cell, column by column, kCellVectors of four: of the coefficients of
// s^i t^j in the cell's own (s, t), in the order 00 10 01 20 | 11 02 21 12 | 22. One cell where the
// patch is one polynomial. Else a cell for each quarter, then where V is singular three for each
// further halving (quarters 1 to 3 there) and one of V itself, whose rows are the point, two
// tangents that span its plane, and the derivatives along both edges; then the same of F.
PLANISH_SHARED_CONSTANT kCellVectors = 3u;
PLANISH_SHARED_CONSTANT kQuarterCells = 4u;
PLANISH_SHARED_CONSTANT kChainCells = 70u;  // 3 (kPlaceHalvings - 1) + 1
#endif
