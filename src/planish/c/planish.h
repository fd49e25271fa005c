#ifndef PLANISH_C_PLANISH_H
#define PLANISH_C_PLANISH_H

/* The library for C and for whatever calls C: a mesh in, the smooth surface through its vertices
 * out, on the CPU. C99.
 *
 * - Handles (planish_mesh, planish_options, planish_fit, planish_surface, planish_queries) are
 *   opaque; each *_free() takes NULL. What a handle was made from may be freed before it.
 * - Every function that can fail returns a status and leaves its outputs as they were unless it is
 *   PLANISH_OK or PLANISH_NOT_CONVERGED. Of every status but PLANISH_OK planish_last_error() says
 *   what, where, the value and the remedy. No C++ exception leaves the library.
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
  PLANISH_CANCELLED = 130 /**< progress() returned other than 0 */
} planish_status;

typedef struct planish_mesh planish_mesh;
typedef struct planish_options planish_options;
typedef struct planish_fit planish_fit;
typedef struct planish_surface planish_surface;
typedef struct planish_queries planish_queries;

/** "0.1.0", of the library that runs. */
const char* planish_version(void);

/** What the last call of this thread that failed has to say; "" if none has. Holds until the next
 * call of this thread fails. */
const char* planish_last_error(void);
/** Index of the face, vertex or byte that it speaks of; -1 for none. */
int64_t planish_last_error_element(void);

/* -- Meshes ---------------------------------------------------------------------------------- */

/** Numbers that each vertex has besides: linear on the surface. */
typedef struct planish_attribute {
  const char* name;    /**< letters, digits and '_', no digit first */
  int32_t width;       /**< numbers of each vertex: 1 to 1024 */
  const float* values; /**< `width` for each vertex, one vertex after another; finite */
} planish_attribute;

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
  /** Texture coordinates, uv_count u, v; face_uvs has the number of one for each corner of the
   * faces, -1: none there. Both NULL: none. */
  const double* uvs;
  size_t uv_count;
  const int32_t* face_uvs;
  const float* colors; /**< vertex_count linear R, G, B, A; NULL: none */
  /** Texts of group_count groups; a material may be "", and of a mesh that is created NULL; the
   * group of each face. */
  const char* const* group_names;
  const char* const* group_materials;
  size_t group_count;
  const int32_t* face_groups;
  const planish_attribute* attributes; /**< further numbers of the vertices */
  size_t attribute_count;
} planish_mesh_arrays;

void planish_mesh_arrays_init(planish_mesh_arrays* arrays, size_t struct_size);

/** Copies the arrays. Sizes and indices are checked here; what else may be wrong with a mesh is
 * mended or refused by planish_fit_create(). */
planish_status planish_mesh_create(const planish_mesh_arrays* arrays, planish_mesh** mesh);
/** OBJ, PLY, OFF, STL, glTF or GLB, by extension. */
planish_status planish_mesh_read(const char* path, planish_mesh** mesh);
/** What planish_mesh_read() passed over or mended, and where in the file; code and message belong
 * to the mesh, and either may be NULL. */
size_t planish_mesh_warning_count(const planish_mesh* mesh);
planish_status planish_mesh_warning(const planish_mesh* mesh, size_t index, const char** code,
                                    const char** message);
/** OBJ, PLY, OFF or USD text, by extension. PLANISH_INVALID_ARGUMENT for a file that
 * planish_mesh_read() read for it. */
planish_status planish_mesh_write(const planish_mesh* mesh, const char* path);
/** Views of the mesh; set struct_size first (by the *_init()). face_sizes is set, whatever the
 * faces; creases and corners are left out. */
planish_status planish_mesh_view(const planish_mesh* mesh, planish_mesh_arrays* arrays);
void planish_mesh_free(planish_mesh* mesh);

/* -- Options --------------------------------------------------------------------------------- */

/** The defaults, on all cores. */
planish_status planish_options_create(planish_options** options);
/** Sets an option by the name that it has in scene files of `planish run`, to the text that its
 * flag of `planish fit` takes: "polish" to "8", "creases" to "auto:40", "weld" to "1e-6"; `planish
 * fit --help` lists them. The order does not matter; "preset" gives way to what is set besides.
 * PLANISH_INVALID_ARGUMENT for unknown names and for values that the command refuses, too: what was
 * set before stays. Options that contradict each other are refused where they are used, and so are
 * those of files and points that are read ("textures", "outliers") by all but planish_fit_file().
 * - "levels", "chord_errors", "angle", "faces", "edge_lengths" and "pixels": of files, and what
 *   PLANISH_LEVEL_AUTO stands for. Several are levels of detail of one glTF, for which "lods" has
 *   to be "msft".
 * - "report" (JSON), "page" (HTML), "cage" and "source" (a mesh that the surface is compared with):
 *   paths of further files of planish_fit_file(), as jobs of scene files name them; "page" of
 *   planish_fit_files(), too.
 * - "device": "cpu".
 * - "memory_limit" (bytes), "point_limit" (of an input), "output_limit" (bytes of all files),
 *   "time_limit" (seconds of processor time): of planish_fit_file(), for hosts that run the work of
 *   others, and of this interface alone; 0, the default: none. Work that would need more fails with
 *   PLANISH_NO_MEMORY, PLANISH_UNWRITABLE_OUTPUT or PLANISH_CANCELLED, and leaves no file.
 * - "threads", which is of this interface alone: how many, the caller's included, work on all that
 *   is done with what is made by the options: 1 to 4096; 0, the default: all cores. */
planish_status planish_options_set(planish_options* options, const char* name, const char* value);
/** What an option is set to now, its default included; "" where it has none. The text belongs to
 * the options until one of them is set. */
planish_status planish_options_get(const planish_options* options, const char* name,
                                   const char** value);
/** `progress` is called on the calling thread and no other, every few hundredths of a second, with
 * what is being done and the fraction of the whole call that is done: it never falls and ends at 1.
 * Another result than 0 cancels. NULL: none. `user` is given to it, here and below. */
void planish_options_on_progress(planish_options* options,
                                 int (*progress)(void* user, const char* step, double fraction),
                                 void* user);
/** `warning` is called on the calling thread with a stable code and a sentence. NULL: none. */
void planish_options_on_warning(planish_options* options,
                                void (*warning)(void* user, const char* code, const char* message),
                                void* user);
/** For planish_verify() of a surface with found creases: what planish_fit_sharp() gives, which is
 * copied. NULL and NULL, as at first: they are looked for once more. */
planish_status planish_options_set_sharp(planish_options* options, const int32_t* edges,
                                         size_t edge_count, const int32_t* corners,
                                         size_t corner_count);
void planish_options_free(planish_options* options);

/* -- Fits ------------------------------------------------------------------------------------ */

typedef struct planish_fit_info {
  size_t struct_size;
  int32_t converged;
  int32_t iterations;        /**< 0 for the fair method */
  const char* interpolation; /**< that was taken: "progressive" or "fair" */
  double max_error;          /**< of a vertex from the surface, of the diagonal */
  double rms_error;
  double diagonal;      /**< of the vertices' bounding box, in the mesh's unit */
  size_t vertex_count;  /**< of the mesh as it was fitted, after repair */
  size_t face_count;    /**< the same */
  size_t warning_count; /**< of repair and fit */
  /** By which creases were found; 0: none were. planish_verify() then wants "creases" to be "auto:"
   * and this. */
  double crease_degrees;
  /** Whether sharp features were found by the shape: planish_verify() then wants "creases" to be
   * "auto". */
  int32_t finds_features;
  double within; /**< how far the surface might leave vertices, of the diagonal; the same */
} planish_fit_info;

void planish_fit_info_init(planish_fit_info* info, size_t struct_size);

/** Fits the surface; `options` may be NULL: the defaults. PLANISH_NOT_CONVERGED sets *fit, too. */
planish_status planish_fit_create(const planish_mesh* mesh, const planish_options* options,
                                  planish_fit** fit);
planish_status planish_fit_get_info(const planish_fit* fit, planish_fit_info* info);
/** What was found to be sharp, tags aside: edges, two vertices each, and corners, of the mesh as it
 * was fitted; the arrays belong to the fit. */
planish_status planish_fit_sharp(const planish_fit* fit, const int32_t** edges, size_t* edge_count,
                                 const int32_t** corners, size_t* corner_count);
/** The control cage, a mesh of its own. Of the fair method it is the mesh of level 1. */
planish_status planish_fit_cage(const planish_fit* fit, planish_mesh** cage);
/** A level that is not named: the finest of the option "levels"; unset, 2 splits, of a dense mesh
 * 1: 20,000 vertices or more, and faces of 3/4 of its area turn by less than 20 degrees to each
 * neighbour. */
#define PLANISH_LEVEL_AUTO (-1)

/** Evaluates and writes the surface as glTF, GLB, OBJ, PLY, OFF, STL, USD text, 3D Tiles or STEP,
 * which has no level, by extension, as the options say of files. `level`: 0 to 6 splits, or
 * PLANISH_LEVEL_AUTO. PLANISH_NOT_CONVERGED also where STEP does not keep limits that options set.
 * PLANISH_INVALID_ARGUMENT for a file that was read for the mesh. An existing file is replaced once
 * the new one is whole. */
planish_status planish_fit_write(const planish_fit* fit, int32_t level, const char* path);
void planish_fit_free(planish_fit* fit);

/** From file to file, as `planish fit INPUT -o OUTPUT`: a mesh, points (which need the program
 * planish-reconstruct) or a glTF, each of whose meshes is fitted; glTF, OBJ, PLY, OFF, STL, USD, 3D
 * Tiles or STEP by extension. `options` and `info` may be NULL. An existing output is replaced once
 * the new one is whole. */
planish_status planish_fit_file(const char* input, const char* output,
                                const planish_options* options, planish_fit_info* info);

/** Many files one after another, each as planish_fit_file() makes it, into `folder` under its name
 * with that extension; NULL: "glb". The option "page" names a folder here, for a page of each and
 * index.html, a contact sheet, the worst first; "report", "cage" and "source" are refused. An input
 * that cannot be fitted does not stop the others: `failed`, which may be NULL, is called on the
 * calling thread with its number and a sentence. PLANISH_INVALID_ARGUMENT for two inputs of one
 * name. */
planish_status planish_fit_files(const char* const* inputs, size_t input_count, const char* folder,
                                 const char* extension, const planish_options* options,
                                 void (*failed)(void* user, size_t input, const char* message),
                                 void* user);

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
  /** Texture coordinates, uv_count u, v; face_uvs has the number of one for each corner of the
   * faces, -1: none there. Both NULL: none. */
  const double* uvs;
  size_t uv_count;
  const int32_t* face_uvs;
  const float* colors; /**< vertex_count linear R, G, B, A; NULL: none */
  /** Texts of group_count groups, each may be ""; the group of each face. */
  const char* const* group_names;
  const char* const* group_materials;
  size_t group_count;
  const int32_t* face_groups;
  const planish_attribute* attributes; /**< further numbers of the vertices */
  size_t attribute_count;
} planish_surface_arrays;

void planish_surface_arrays_init(planish_surface_arrays* arrays, size_t struct_size);

/** The surface after `level` splits, 0 to 6, or PLANISH_LEVEL_AUTO. */
planish_status planish_fit_evaluate(const planish_fit* fit, int32_t level,
                                    planish_surface** surface);
/** Triangles as fine as a Doo-Sabin surface is curved: within `chord_error` of it, a fraction of
 * the fit's diagonal, its normals turning by at most `angle` degrees beneath each but where a
 * warning says so; 0: any, but not both. Watertight where the mesh is. */
planish_status planish_fit_tessellate(const planish_fit* fit, double chord_error, double angle,
                                      planish_surface** surface);
/** What could not be kept, an angle where the surface folds for one; code and message belong to the
 * surface, and either may be NULL. */
size_t planish_surface_warning_count(const planish_surface* surface);
planish_status planish_surface_warning(const planish_surface* surface, size_t index,
                                       const char** code, const char** message);
planish_status planish_surface_view(const planish_surface* surface, planish_surface_arrays* arrays);
void planish_surface_free(planish_surface* surface);

/* -- Questions to the surface ---------------------------------------------------------------- */

/** A place on a face of the mesh as it was fitted, as OpenSubdiv's Bfr::Parameterization has it: of
 * faces of four, corner i at (0, 0), (1, 0), (1, 1), (0, 1); others are tiles of half a unit, one a
 * corner, at (i % d, i / d) with d = 2 up to four corners, 3 up to nine, then
 * 1 + floor(sqrt(m - 1)): its origin at the corner, u along the edge to the next one, (1/2, 1/2)
 * the face's centre. */
typedef struct planish_place {
  int32_t face; /**< -1 in results: none */
  double u, v;
} planish_place;

/** Of a Doo-Sabin surface, exact to rounding, in the mesh's unit. Takes seconds for millions of
 * faces; then asked as often as wanted, by several threads at once. */
planish_status planish_queries_create(const planish_fit* fit, planish_queries** queries);
void planish_queries_free(planish_queries* queries);

/** The caller's arrays for answers, each of one entry (x, y, z for vectors) a question; what is
 * NULL is not answered. */
typedef struct planish_place_answers {
  size_t struct_size;
  double* positions;
  double* normals;            /**< unit */
  double *du, *dv;            /**< derivatives by the place's u and v */
  double *duu, *duv, *dvv;    /**< 0 where they have no limit: see has_second */
  double *mean, *gaussian;    /**< curvatures, positive where it bends away from the normal */
  double *largest, *smallest; /**< principal ones */
  double* largest_directions; /**< unit tangents along which they are */
  double* smallest_directions;
  /** 1, or 0 at vertices and face centres of other valence or size than 4, where second derivatives
   * grow without limit and curvatures are 0, too. */
  int32_t* has_second;
} planish_place_answers;

typedef struct planish_closest_answers {
  size_t struct_size;
  planish_place* places;
  double* positions;
  double* normals;
  double* distances;
} planish_closest_answers;

typedef struct planish_ray_answers {
  size_t struct_size;
  planish_place* places; /**< face -1 where nothing is hit; the others' entries are 0 then */
  double* positions;
  double* normals;
  double* t;           /**< position = origin + t direction */
  int32_t* is_tangent; /**< 1: the ray touches the surface here, as nearly as can be told */
} planish_ray_answers;

void planish_place_answers_init(planish_place_answers* answers, size_t struct_size);
void planish_closest_answers_init(planish_closest_answers* answers, size_t struct_size);
void planish_ray_answers_init(planish_ray_answers* answers, size_t struct_size);

planish_status planish_queries_evaluate(const planish_queries* queries, const planish_place* places,
                                        size_t count, const planish_place_answers* answers);
/** `points`: count x, y, z. */
planish_status planish_queries_closest(const planish_queries* queries, const double* points,
                                       size_t count, const planish_closest_answers* answers);
/** The first hit of each ray with t_min <= t <= t_max: 0 and 1e300 for all in front. `origins`,
 * `directions` (of any length above 0): count x, y, z. */
planish_status planish_queries_first_hit(const planish_queries* queries, const double* origins,
                                         const double* directions, size_t count, double t_min,
                                         double t_max, const planish_ray_answers* answers);

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
 * the options, which may be NULL, those that shape the surface count, as they were given to the
 * fit ("interpolation" auto: progressive), with what is set to be sharp, and "tolerance". Not
 * confirming is PLANISH_OK. */
planish_status planish_verify(const planish_mesh* cage, const planish_mesh* given,
                              const planish_options* options, planish_verification* verification);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(modernize-*) */

#endif
