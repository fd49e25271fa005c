#pragma once

#include <optional>
#include <string>

#include "planish/files/obj/obj_part.h"

namespace planish {

/// The names that lines of an OBJ file have given; what none has given holds on from before.
struct ObjNames {
  std::optional<std::string> object, group, material;

  /// An object ends the group before it.
  void take(const ObjPart::Naming& naming) {
    switch (naming.what) {
      case ObjPart::Naming::What::Object:
        object = naming.name;
        group = std::string();
        break;
      case ObjPart::Naming::What::Group:
        group = naming.name;
        break;
      case ObjPart::Naming::What::Material:
        material = naming.name;
        break;
    }
  }
  /// That of the faces that follow: a face without a group has its object's name.
  [[nodiscard]] FaceGroup face_group() const {
    const std::string own = group.value_or("");
    return {.name = own.empty() ? object.value_or("") : own, .material = material.value_or("")};
  }
};

}  // namespace planish
