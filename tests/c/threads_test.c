/* What planish.h says of threads: several read the same handles at once and get the bits of one
 * alone, and each has its own last error. */
#define _POSIX_C_SOURCE 200809L

#include <planish/c/editor.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "torus.h"

enum { kThreads = 4, kRounds = 2, kPoints = 100 };

static planish_mesh* mesh;
static planish_fit* fit;
static planish_editor* editor;
static planish_queries *queries, *edited;
static pthread_barrier_t beginning;

typedef struct {
  int number, failures;
  uint64_t seen;
} reader;

/* FNV-1a. */
static void see(reader* self, const void* values, size_t size) {
  const unsigned char* byte = values;
  size_t i;
  for (i = 0; i < size; ++i) self->seen = (self->seen ^ byte[i]) * 1099511628211u;
}

static void see_surface(reader* self, planish_surface* surface) {
  planish_surface_arrays arrays;
  planish_surface_arrays_init(&arrays, sizeof arrays);
  self->failures += planish_surface_view(surface, &arrays) != PLANISH_OK;
  see(self, arrays.positions, 3 * arrays.vertex_count * sizeof *arrays.positions);
  see(self, arrays.normals, 3 * arrays.vertex_count * sizeof *arrays.normals);
  see(self, arrays.face_vertices, arrays.corner_count * sizeof *arrays.face_vertices);
  planish_surface_free(surface);
}

static void see_cage(reader* self, const planish_fit* of) {
  planish_mesh_arrays arrays;
  planish_mesh* cage = NULL;
  planish_mesh_arrays_init(&arrays, sizeof arrays);
  self->failures += planish_fit_cage(of, &cage) != PLANISH_OK;
  self->failures += planish_mesh_view(cage, &arrays) != PLANISH_OK;
  see(self, arrays.positions, 3 * arrays.vertex_count * sizeof *arrays.positions);
  planish_mesh_free(cage);
}

static void see_closest(reader* self, const planish_queries* asked) {
  double points[3 * kPoints], positions[3 * kPoints];
  planish_closest_answers answers;
  int i;
  for (i = 0; i < 3 * kPoints; ++i) points[i] = sin(1.0 + i * i);
  planish_closest_answers_init(&answers, sizeof answers);
  answers.positions = positions;
  self->failures += planish_queries_closest(asked, points, kPoints, &answers) != PLANISH_OK;
  see(self, positions, sizeof positions);
}

static void see_file(reader* self) {
  char name[64], bytes[4096];
  size_t count;
  FILE* file;
  sprintf(name, "threads_test_%d.ply", self->number);
  self->failures += planish_fit_write(fit, 1, name) != PLANISH_OK;
  file = fopen(name, "rb");
  self->failures += file == NULL;
  if (file == NULL) return;
  while ((count = fread(bytes, 1, sizeof bytes, file)) > 0) see(self, bytes, count);
  fclose(file);
  remove(name);
}

static void read_all(reader* self) {
  char wrong[16];
  planish_fit* other = NULL;
  planish_surface* surface = NULL;
  planish_editor_arrays rows;
  self->seen = 14695981039346656037u;
  sprintf(wrong, "%d", 100 + self->number);
  self->failures +=
      planish_fit_evaluate(fit, 100 + self->number, &surface) != PLANISH_INVALID_ARGUMENT;
  self->failures += planish_fit_evaluate(fit, 2, &surface) != PLANISH_OK;
  see_surface(self, surface);
  self->failures += planish_fit_tessellate(fit, 1e-3, 0, &surface) != PLANISH_OK;
  see_surface(self, surface);
  see_cage(self, fit);
  see_closest(self, queries);
  see_closest(self, edited);
  see_file(self);
  self->failures += planish_fit_create(mesh, NULL, &other) != PLANISH_OK;
  see_cage(self, other);
  planish_fit_free(other);
  self->failures += planish_editor_fit(editor, &other) != PLANISH_OK;
  see_cage(self, other);
  planish_fit_free(other);
  planish_editor_arrays_init(&rows, sizeof rows);
  self->failures += planish_editor_view(editor, &rows) != PLANISH_OK;
  see(self, rows.positions, 3 * rows.row_count * sizeof *rows.positions);
  self->failures += strstr(planish_last_error(), wrong) == NULL;
}

static void* run(void* self) {
  pthread_barrier_wait(&beginning);
  read_all(self);
  return NULL;
}

static void make_handles(void) {
  const int32_t moved = 7;
  const double to[3] = {1.5, 0.1, 0.1};
  mesh = torus();
  fit = fitted(mesh, NULL);
  EXPECT(planish_queries_create(fit, &queries) == PLANISH_OK);
  EXPECT(planish_editor_create(fit, 1, &editor) == PLANISH_OK);
  EXPECT(planish_editor_queries(editor, &edited) == PLANISH_OK);
  EXPECT(planish_editor_move(editor, &moved, to, 1, NULL) == PLANISH_OK);
}

int main(void) {
  reader alone = {kThreads, 0, 0}, readers[kThreads];
  pthread_t threads[kThreads];
  int i, round;
  make_handles();
  read_all(&alone);
  EXPECT(alone.failures == 0);
  pthread_barrier_init(&beginning, NULL, kThreads);
  for (round = 0; round < kRounds; ++round) {
    for (i = 0; i < kThreads; ++i) {
      readers[i].number = i;
      readers[i].failures = 0;
      EXPECT(pthread_create(&threads[i], NULL, run, &readers[i]) == 0);
    }
    for (i = 0; i < kThreads; ++i) {
      EXPECT(pthread_join(threads[i], NULL) == 0);
      EXPECT(readers[i].failures == 0 && readers[i].seen == alone.seen);
    }
  }
  pthread_barrier_destroy(&beginning);
  planish_queries_free(edited);
  planish_queries_free(queries);
  planish_editor_free(editor);
  planish_fit_free(fit);
  planish_mesh_free(mesh);
  return failures != 0;
}
