#ifndef PLANISH_C_PLANISH_H
#define PLANISH_C_PLANISH_H

/* The library for C and for whatever calls C: a mesh in, the smooth surface through its vertices
 * out, on the CPU. C99.
 *
 * - Handles (planish_mesh, planish_fit, planish_surface) are opaque; each *_free() takes NULL. What
 *   a handle was made from may be freed before it.
 * - Every function that can fail returns a status and leaves its outputs as they were unless it is
 *   PLANISH_OK or PLANISH_NOT_CONVERGED. planish_last_error() then says what, where, the value and
 *   the remedy. No C++ exception leaves the library.
 * - Structs begin with their size. Their *_init(&it, sizeof it) sets it and the defaults. A caller
 *   that was compiled with an older header passes a smaller size; what it does not know takes its
 *   default.
 * - Arrays that functions hand out belong to the handle and hold until it is freed.
 * - Different handles may be used from different threads at once, and one handle by several threads
 *   that only read it. Texts are UTF-8. Results are the same bits for any number of threads, and
 *   those of `planish fit --device cpu`. */

/* NOLINTBEGIN(modernize-*): this is C */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The command's exit codes where there is one of the same meaning. */
typedef enum planish_status {
  PLANISH_OK = 0,
  PLANISH_INTERNAL_ERROR = 1,   /**< a bug of planish's */
  PLANISH_INVALID_ARGUMENT = 2, /**< NULL, a size or an option that is out of range */
  PLANISH_UNREADABLE_INPUT = 3, /**< a file is missing or malformed */
  PLANISH_UNUSABLE_MESH = 4,    /**< no surface can be made of the mesh */
  PLANISH_NOT_CONVERGED = 5,    /**< a result all the same: outputs are set, files written */
  PLANISH_NO_MEMORY = 6,        /**< thrown before it is taken */
  PLANISH_UNWRITABLE_OUTPUT = 7,
  PLANISH_CANCELLED = 130 /**< planish_fit_options::progress returned other than 0 */
} planish_status;

typedef enum planish_method {
  PLANISH_METHOD_AUTO = 0, /**< the better one by measurement */
  PLANISH_METHOD_PROGRESSIVE = 1,
  PLANISH_METHOD_FAIR = 2
} planish_method;

typedef enum planish_scheme {
  PLANISH_SCHEME_DOO_SABIN = 0,
  PLANISH_SCHEME_CATMULL_CLARK = 1,
  PLANISH_SCHEME_LOOP = 2 /**< triangles only */
} planish_scheme;

typedef struct planish_mesh planish_mesh;
typedef struct planish_fit planish_fit;
typedef struct planish_surface planish_surface;

/** "0.1.0", of the library that runs. */
const char* planish_version(void);

/** What the last call of this thread that failed has to say; "" if none has. Holds until the next
 * call of this thread fails. */
const char* planish_last_error(void);
/** Index of the face, vertex or byte that it speaks of; -1 for none. */
int64_t planish_last_error_element(void);

/* -- Meshes ---------------------------------------------------------------------------------- */

/** Polygons of any size, counter-clockwise seen from outside. */
typedef struct planish_mesh_arrays {
  size_t struct_size;
  const double* positions; /**< vertex_count x, y, z */
  size_t vertex_count;
  const int32_t* face_sizes; /**< corners of each face; NULL: all have corners_per_face */
  size_t face_count;
  int32_t corners_per_face;
  const int32_t* face_vertices; /**< of all faces, one after another, from 0 */
  size_t corner_count;          /**< length of face_vertices */
  const int32_t* crease_edges;  /**< pairs of vertices whose edge stays sharp; may be NULL */
  size_t crease_count;
  const int32_t* corner_vertices; /**< vertices that stay sharp; may be NULL */
  size_t sharp_corner_count;
} planish_mesh_arrays;

void planish_mesh_arrays_init(planish_mesh_arrays* arrays, size_t struct_size);

/** Copies the arrays. Sizes and indices are checked here; what else may be wrong with a mesh is
 * mended or refused by planish_fit_create(). */
planish_status planish_mesh_create(const planish_mesh_arrays* arrays, planish_mesh** mesh);
/** OBJ, PLY, OFF, STL, glTF or GLB, by extension. */
planish_status planish_mesh_read(const char* path, planish_mesh** mesh);
/** OBJ, PLY, OFF or USD text, by extension. */
planish_status planish_mesh_write(const planish_mesh* mesh, const char* path);
/** Views of the mesh; set struct_size first (by the *_init()). face_sizes is set, whatever the
 * faces; creases and corners are left out. */
planish_status planish_mesh_view(const planish_mesh* mesh, planish_mesh_arrays* arrays);
void planish_mesh_free(planish_mesh* mesh);

/* -- Fits ------------------------------------------------------------------------------------ */

typedef struct planish_fit_options {
  size_t struct_size;
  int32_t method;         /**< a planish_method */
  int32_t scheme;         /**< a planish_scheme */
  double tolerance;       /**< of the largest error, of the bounding box's diagonal: 1e-6 */
  int32_t max_iterations; /**< 200 */
  int32_t repairs;        /**< not 0: mends what can be mended */
  int32_t uses_creases;   /**< not 0: edges and vertices that the mesh tags stay sharp */
  double crease_degrees;  /**< edges whose faces turn by more are sharp, too; 0: none */
  int32_t thread_count;   /**< 0: all cores */
  /** Called on the calling thread with the step's name and the fraction of it that is done, 0 to 1.
   * Another result than 0 cancels. May be NULL. */
  int (*progress)(void* user, const char* step, double fraction);
  /** Called on the calling thread with a stable code and a sentence. May be NULL. */
  void (*warning)(void* user, const char* code, const char* message);
  void* user;  /**< given to both */
  double weld; /**< vertices within this fraction of the diagonal become one, first; 0: none */
} planish_fit_options;

void planish_fit_options_init(planish_fit_options* options, size_t struct_size);

typedef struct planish_fit_info {
  size_t struct_size;
  int32_t converged;
  int32_t iterations; /**< 0 for the fair method */
  int32_t method;     /**< the planish_method that was taken */
  double max_error;   /**< of a vertex from the surface, of the diagonal */
  double rms_error;
  double diagonal;      /**< of the vertices' bounding box, in the mesh's unit */
  size_t vertex_count;  /**< of the mesh as it was fitted, after repair */
  size_t face_count;    /**< the same */
  size_t warning_count; /**< of repair and fit */
} planish_fit_info;

void planish_fit_info_init(planish_fit_info* info, size_t struct_size);

/** Fits the surface; `options` may be NULL: the defaults. PLANISH_NOT_CONVERGED sets *fit, too. */
planish_status planish_fit_create(const planish_mesh* mesh, const planish_fit_options* options,
                                  planish_fit** fit);
planish_status planish_fit_get_info(const planish_fit* fit, planish_fit_info* info);
/** The control cage, a mesh of its own. Of the fair method it is the mesh of level 1. */
planish_status planish_fit_cage(const planish_fit* fit, planish_mesh** cage);
/** Evaluates and writes the surface as glTF, GLB, OBJ, PLY, OFF, STL or USD text, by extension. */
planish_status planish_fit_write(const planish_fit* fit, int32_t level, const char* path);
void planish_fit_free(planish_fit* fit);

/** From file to file, as `planish fit INPUT -o OUTPUT`; `options` and `info` may be NULL. An
 * existing output is replaced once the new one is whole. */
planish_status planish_fit_file(const char* input, const char* output, int32_t level,
                                const planish_fit_options* options, planish_fit_info* info);

/* -- Surfaces -------------------------------------------------------------------------------- */

/** A tessellation whose every vertex lies on the limit surface. */
typedef struct planish_surface_arrays {
  size_t struct_size;
  const double* positions; /**< vertex_count x, y, z in the mesh's unit */
  const float* normals;    /**< vertex_count x, y, z of unit length */
  size_t vertex_count;
  const int32_t* face_vertices; /**< corner_count */
  size_t corner_count;
  const int32_t* face_offsets; /**< face_count + 1; NULL: every face has four corners */
  size_t face_count;
  /** The first base_count positions are the limit points of the fitted mesh's vertices of these
   * numbers. */
  const int32_t* base_vertices;
  size_t base_count;
} planish_surface_arrays;

void planish_surface_arrays_init(planish_surface_arrays* arrays, size_t struct_size);

/** The surface after `level` splits, 0 to 6. */
planish_status planish_fit_evaluate(const planish_fit* fit, int32_t level,
                                    planish_surface** surface);
planish_status planish_surface_view(const planish_surface* surface, planish_surface_arrays* arrays);
void planish_surface_free(planish_surface* surface);

/* -- Verification ---------------------------------------------------------------------------- */

typedef struct planish_verification {
  size_t struct_size;
  int32_t confirmed; /**< max_error is at most the options' tolerance */
  double max_error;  /**< of a given vertex from the cage's surface, of the diagonal */
  double rms_error;
  int64_t worst_vertex;
  int64_t vertex_count;
} planish_verification;

void planish_verification_init(planish_verification* verification, size_t struct_size);

/** How far the vertices of `given` are from the surface of `cage`, by limit points in double; of
 * the options, which may be NULL, method (auto: progressive), scheme, tolerance, repairs and
 * creases count. Not confirming is PLANISH_OK. */
planish_status planish_verify(const planish_mesh* cage, const planish_mesh* given,
                              const planish_fit_options* options,
                              planish_verification* verification);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-*) */

#endif
