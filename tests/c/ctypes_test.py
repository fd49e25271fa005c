"""The interface for C from a language that is not C: arguments are the shared library and a mesh."""

import ctypes
import sys


PROGRESS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_double)


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

    mesh, options, fit, surface = (ctypes.c_void_p() for _ in range(4))
    assert library.planish_mesh_read(mesh_path.encode(), ctypes.byref(mesh)) == 0
    assert library.planish_options_create(ctypes.byref(options)) == 0
    value = ctypes.c_char_p()
    for name, default in [(b"tolerance", b"1e-06"), (b"max_iterations", b"200"), (b"repair", b"safe")]:
        assert library.planish_options_get(options, name, ctypes.byref(value)) == 0
        assert value.value == default
    assert library.planish_options_set(options, b"tolerance", b"1e-7") == 0
    assert library.planish_options_set(options, b"tolerance", b"small") == 2
    assert b"options.tolerance" in library.planish_last_error()
    steps = []

    def note(_user, step, fraction):
        steps.append((step, fraction))
        return 0

    progress = PROGRESS(note)
    library.planish_options_on_progress(options, progress, None)
    assert library.planish_fit_create(mesh, options, ctypes.byref(fit)) == 0
    library.planish_options_free(options)
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
