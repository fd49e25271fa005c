#include "prepare.h"

#include "planish/mesh/check.h"
#include "planish/mesh/detect_creases.h"

namespace planish::command {

RepairedMesh prepare(const PolygonMesh& mesh, RepairChoice choice, const CreaseChoice& creases) {
  RepairedMesh prepared;
  if (choice == RepairChoice::Safe) {
    prepared = repair(mesh);
  } else {
    prepared.mesh = mesh;
  }
  if (creases.dihedral_degrees && (choice == RepairChoice::Safe || check(mesh).empty())) {
    prepared.mesh =
        with_detected_creases(prepared.mesh, {.dihedral_degrees = *creases.dihedral_degrees});
  }
  return prepared;
}

}  // namespace planish::command
