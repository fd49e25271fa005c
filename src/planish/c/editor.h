#ifndef PLANISH_C_EDITOR_H
#define PLANISH_C_EDITOR_H

/* Moving vertices of a fitted mesh: only what they reach is solved and evaluated again. The rules
 * of planish.h hold; besides, one thread at a time may change an editor, and none reads it
 * meanwhile. */

/* NOLINTBEGIN(modernize-*): this is C */
#include "planish/c/planish.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct planish_editor planish_editor;

/** Rows `first` to `first + count - 1`. */
typedef struct planish_row_range {
  int64_t first, count;
} planish_row_range;

/** What a call has changed. The arrays hold until the editor's next call that changes it. */
typedef struct planish_edit_change {
  size_t struct_size;
  const int32_t* vertices; /**< that moved, ascending */
  size_t vertex_count;
  /** Vertices whose control points moved along, in any order; of the fair method those around which
   * control points of level 1 did. */
  const int32_t* control_points;
  size_t control_point_count;
  const planish_row_range* rows; /**< ascending; all other rows are as they were, to the bit */
  size_t range_count;
  int64_t row_count; /**< in all ranges */
  int32_t is_whole;  /**< 1: everything was solved and evaluated */
} planish_edit_change;

void planish_edit_change_init(planish_edit_change* change, size_t struct_size);

/** An editor's own memory, changed in place by moves. Positions and normals are the rows of the
 * editor's level: those of planish_fit_evaluate() of that level, whose faces they have. */
typedef struct planish_editor_arrays {
  size_t struct_size;
  const double* points; /**< point_count x, y, z: the mesh's vertices where they are now */
  size_t point_count;
  const double* positions; /**< row_count x, y, z in the mesh's unit */
  const float* normals;    /**< row_count x, y, z of unit length */
  size_t row_count;
  double error_bound; /**< the surface is no farther from any vertex, of the diagonal */
  int32_t can_undo, can_redo;
} planish_editor_arrays;

void planish_editor_arrays_init(planish_editor_arrays* arrays, size_t struct_size);

/** Keeps the rows of `level`, 0 to 6 or PLANISH_LEVEL_AUTO. For fits of Doo-Sabin that have
 * converged with `within` 0; vertices are those of the mesh as it was fitted, after repair. 64
 * moves can be taken back. */
planish_status planish_editor_create(const planish_fit* fit, int32_t level,
                                     planish_editor** editor);
void planish_editor_free(planish_editor* editor);

/** Moves vertices to count x, y, z in the mesh's unit; of a vertex that is named twice the last
 * counts. Refused moves change nothing; where memory runs out, vertices may have moved, and the
 * next call makes all rows. `change` may be NULL, here and below. */
planish_status planish_editor_move(planish_editor* editor, const int32_t* vertices,
                                   const double* positions, size_t count,
                                   planish_edit_change* change);
/** The vertices within `radius` of some others by the shortest way along edges, and a weight each:
 * 1 there, falling smoothly to 0 at the radius. The arrays hold until the editor's next call of
 * this function. */
planish_status planish_editor_select(planish_editor* editor, const int32_t* vertices, size_t count,
                                     double radius, const int32_t** selected,
                                     const double** weights, size_t* selected_count);
/** Moves vertices by an affine map, `matrix` three rows of four numbers, each by its weight of the
 * way; `weights` NULL: all the way. */
planish_status planish_editor_transform(planish_editor* editor, const int32_t* vertices,
                                        const double* weights, size_t count, const double* matrix,
                                        planish_edit_change* change);
/** Makes crease_count edges, pairs of vertices, and corner_count vertices sharp, or smooth again
 * where is_sharp is 0. That is another system with other rows: it is solved from where it is and
 * evaluated whole. Arrays that the editor gave before end; queries that it gave answer for the
 * surface as it was. Moves can still be taken back, this by its opposite. Refused where the mesh
 * has no such edge or vertex, and where the new system is not solved: nothing has changed. */
planish_status planish_editor_set_sharp(planish_editor* editor, const int32_t* crease_edges,
                                        size_t crease_count, const int32_t* corner_vertices,
                                        size_t corner_count, int32_t is_sharp,
                                        planish_edit_change* change);
/** Takes back the last move that was not yet taken back, or makes it again; nothing where there is
 * none. */
planish_status planish_editor_undo(planish_editor* editor, planish_edit_change* change);
planish_status planish_editor_redo(planish_editor* editor, planish_edit_change* change);
/** Solves the whole mesh from where it is; of the fair method builds the net anew, by what the fit
 * decided. */
planish_status planish_editor_settle(planish_editor* editor, planish_edit_change* change);
/** Makes what planish_fit_mesh() makes of the mesh as it is now by the same method, with all that
 * is decided anew. The rows keep their numbers, and moves can still be taken back; arrays that the
 * editor gave before end, queries that it gave answer for the surface as it was. Refused where the
 * fit misses its tolerance: nothing has changed. */
planish_status planish_editor_refit(planish_editor* editor, planish_edit_change* change);

planish_status planish_editor_view(const planish_editor* editor, planish_editor_arrays* arrays);
/** The mesh and its surface as they are now, for all that takes a fit; later moves do not change
 * it. */
planish_status planish_editor_fit(const planish_editor* editor, planish_fit** fit);
/** Questions to the surface as it is at the time of each, for picking while vertices are dragged.
 * The first call takes time for all of the mesh; moves keep it right at the cost of what they
 * reach. None may be asked while another thread moves vertices. */
planish_status planish_editor_queries(planish_editor* editor, planish_queries** queries);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-*) */

#endif
