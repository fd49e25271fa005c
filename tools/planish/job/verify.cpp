#include "job/verify.h"

namespace planish::command {

Verification verify(const Input& cage, const Input& given, const VerifyOptions& options) {
  return verify_cage(cage.file.mesh, given.file.mesh,
                     {.method = options.interpolation,
                      .scheme = options.scheme,
                      .weights = options.weights,
                      .sharp = {options.boundary, options.creases.use_tags},
                      .repairs = options.repair == RepairChoice::Safe,
                      .crease_degrees = options.creases.dihedral_degrees,
                      .weld = options.weld,
                      .smoothed_vertices = options.smoothed_vertices,
                      .tolerance = options.tolerance,
                      .cage_has_tags = info_of(cage.file.format).keeps_sharp_edges,
                      .cage_name = cage.name,
                      .given_name = given.name});
}

}  // namespace planish::command
