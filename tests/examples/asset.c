/* A whole glTF by one call of C, as src/planish/c/README.md shows it. */
#include <stdio.h>

#include "planish/c/planish.h"

// README begins
static planish_status smooth_asset(const char* from, const char* to) {
  planish_options* options = NULL;
  planish_status status = planish_options_create(&options);
  if (status == PLANISH_OK) status = planish_options_set(options, "compress", "meshopt");
  if (status == PLANISH_OK) status = planish_options_set(options, "page", "smooth.html");
  if (status == PLANISH_OK) status = planish_options_set(options, "report", "smooth.json");
  if (status == PLANISH_OK) status = planish_fit_file(from, to, options, NULL);
  planish_options_free(options);
  return status;
}
// README ends

int main(void) {
  const planish_status status = smooth_asset("chair.gltf", "smooth.glb");
  if (status != PLANISH_OK) fprintf(stderr, "%s\n", planish_last_error());
  return (int)status;
}
