"""The interface for C from a language that is not C: arguments are the shared library and a mesh."""

import ctypes
import sys


class FitOptions(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("method", ctypes.c_int32),
        ("scheme", ctypes.c_int32),
        ("tolerance", ctypes.c_double),
        ("max_iterations", ctypes.c_int32),
        ("repairs", ctypes.c_int32),
        ("uses_creases", ctypes.c_int32),
        ("crease_degrees", ctypes.c_double),
        ("thread_count", ctypes.c_int32),
        ("progress", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p,
                                      ctypes.c_double)),
        ("warning", ctypes.c_void_p),
        ("user", ctypes.c_void_p),
        ("weld", ctypes.c_double),
    ]


class SurfaceArrays(ctypes.Structure):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("positions", ctypes.POINTER(ctypes.c_double)),
        ("normals", ctypes.POINTER(ctypes.c_float)),
        ("vertex_count", ctypes.c_size_t),
        ("face_vertices", ctypes.POINTER(ctypes.c_int32)),
        ("corner_count", ctypes.c_size_t),
        ("face_offsets", ctypes.POINTER(ctypes.c_int32)),
        ("face_count", ctypes.c_size_t),
        ("base_vertices", ctypes.POINTER(ctypes.c_int32)),
        ("base_count", ctypes.c_size_t),
    ]


def main(library_path, mesh_path):
    library = ctypes.CDLL(library_path)
    library.planish_last_error.restype = ctypes.c_char_p
    library.planish_version.restype = ctypes.c_char_p
    assert library.planish_version().count(b".") == 2

    mesh, fit, surface = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
    assert library.planish_mesh_read(mesh_path.encode(), ctypes.byref(mesh)) == 0
    options = FitOptions()
    library.planish_fit_options_init(ctypes.byref(options), ctypes.c_size_t(ctypes.sizeof(options)))
    assert options.tolerance == 1e-6 and options.max_iterations == 200 and options.repairs == 1
    steps = []

    def note(_user, step, fraction):
        steps.append((step, fraction))
        return 0

    options.progress = type(options.progress)(note)
    assert library.planish_fit_create(mesh, ctypes.byref(options), ctypes.byref(fit)) == 0
    assert steps and all(0 <= fraction <= 1 for _, fraction in steps)
    assert library.planish_fit_evaluate(fit, 2, ctypes.byref(surface)) == 0
    arrays = SurfaceArrays()
    library.planish_surface_arrays_init(ctypes.byref(arrays), ctypes.c_size_t(ctypes.sizeof(arrays)))
    assert library.planish_surface_view(surface, ctypes.byref(arrays)) == 0
    assert arrays.corner_count == 4 * arrays.face_count > 0
    assert max(arrays.face_vertices[: arrays.corner_count]) == arrays.vertex_count - 1
    lengths = [sum(n * n for n in arrays.normals[3 * i : 3 * i + 3]) for i in range(100)]
    assert all(abs(length - 1) < 1e-5 for length in lengths)

    assert library.planish_mesh_read(b"none.obj", ctypes.byref(mesh)) == 3
    assert b"none.obj" in library.planish_last_error()
    library.planish_surface_free(surface)
    library.planish_fit_free(fit)
    library.planish_mesh_free(mesh)


if __name__ == "__main__":
    main(*sys.argv[1:])
