# SPDX-License-Identifier: MIT
import copy
import pathlib
import re
import tempfile
import unittest
from dataclasses import asdict

import numpy as np

import phymul
from phymul import ErrorCode, _library

FOLDER = pathlib.Path(phymul.__file__).parent
CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float) * 0.02
FACES = np.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
                  [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]])


class Refusals(unittest.TestCase):
    def refused(self, code, words, function, *arguments, **named):
        with self.assertRaisesRegex(phymul.Error, re.escape(words)) as caught:
            function(*arguments, **named)
        self.assertEqual(caught.exception.code, code)


class Library(unittest.TestCase):
    def test_every_function_and_constant_of_the_header_is_declared(self):
        text = "".join((FOLDER / name).read_text() for name in ("phymul_c.h", "phymul_c_interaction.h"))
        functions = set(re.findall(r"\b(phymul_\w+)\(", re.sub(r"//[^\n]*|typedef [^\n]*", "", text)))
        self.assertGreater(len(functions), 110)
        for name in functions:
            self.assertIsNotNone(getattr(_library.library, name).argtypes, name)
        arguments = _library.library.phymul_body_tetrahedral_block.argtypes
        self.assertEqual([kind.__name__ for kind in arguments],
                         ["c_void_p", "c_int", "c_int", "c_int", "c_double", "c_uint", "c_void_p"])
        for code in ErrorCode:
            self.assertEqual(_library.constants[code.name], code)
        structs = set(re.findall(r"typedef struct (\w+) \{", text))
        self.assertEqual(structs, set(_library.structs))

    def test_version_and_backends(self):
        self.assertRegex(phymul.__version__, r"^\d+\.\d+\.\d+$")
        self.assertIn("reference", phymul.backends())

    def test_functions_want_all_their_arguments_and_no_more(self):
        for arguments in ((None,), (None,) * 3):
            with self.assertRaisesRegex(TypeError, "phymul_body_masses: expected 2 arguments"):
                _library.library.phymul_body_masses(*arguments)


class Bodies(Refusals):
    def test_shapes_and_groups(self):
        block = phymul.make_block((0.04, 0.02, 0.01), 4, 2, 1)
        self.assertEqual(block.rest.shape, (5 * 3 * 2, 3))
        np.testing.assert_allclose(block.rest.max(axis=0), [0.04, 0.02, 0.01])
        self.assertEqual(block.particles, 30)
        self.assertIn("x0", block.groups)
        np.testing.assert_array_equal(block.rest[block.group("x1")][:, 0], 0.04)
        self.assertEqual(len(block.cells), 8)
        self.assertTrue(all(len(cell) == 8 for cell in block.cells))
        self.assertEqual(block.triangles.shape, (2 * 2 * (4 * 2 + 2 * 1 + 4 * 1), 3))
        self.assertEqual(phymul.make_cylinder(0.010, 0.040, 3, 8, 11).particles, 275)
        self.assertTrue(all(len(cell) == 4 for cell in phymul.make_tetrahedral_block((1, 1, 1), 2, 2, 2).cells))
        np.testing.assert_array_equal(block.moved((1, 0, 0)).rest, block.rest + [1, 0, 0])

    def test_groups_by_mask_rows_and_ball(self):
        block = phymul.make_block((0.04, 0.02, 0.01), 4, 2, 1)
        block.add_group("low", block.rest[:, 2] == 0)
        np.testing.assert_array_equal(block.group("low"), block.group("z0"))
        block.add_group("two", [7, 3])
        np.testing.assert_array_equal(block.group("two"), [3, 7])
        inside = block.within((0, 0, 0), 0.0101)
        np.testing.assert_array_equal(np.flatnonzero(inside), np.flatnonzero((block.rest**2).sum(axis=1) < 0.0101**2))
        self.assertGreater(inside.sum(), 1)
        for name in ("a\rb", "c\x85d", "\udcff"):  # neither the end of a line, nor UTF-8
            block.add_group(name, [1])
            self.assertIn(name, block.groups)
            np.testing.assert_array_equal(block.group(name), [1])
        self.refused(ErrorCode.UNKNOWN_NAME, "\udcff", block.group, "x9")

    def test_materials_give_masses_to_their_cells(self):
        block = phymul.make_block((0.04, 0.02, 0.01), 4, 2, 1)
        block.add_cell_group("right", block.cell_centres[:, 0] > 0.02)
        block.set_material(5e3, 0.4, 1000)
        self.assertAlmostEqual(block.masses.sum(), 1000 * 8e-6, places=12)
        block.set_material(5e3, 0.4, 3000, group="right")
        self.assertAlmostEqual(block.masses.sum(), 2000 * 8e-6, places=12)

    def test_materials_are_fitted_to_tests(self):
        known = phymul.Material(6e3, 0.49, 1000, exponential=0.4, exponent=12, second=2, second_fades=5)
        stretches = [0.8, 0.9, 0.95, 1.05, 1.1, 1.2]
        fit = phymul.fit_material([(s, 1e3 * (s - 1)) for s in stretches], [(0.2, 400)], poisson=0.49, density=1000)
        again = phymul.fit_material(np.transpose([stretches, fit.stress[:-1]]), [(0.2, fit.stress[-1])], poisson=0.49,
                                    density=1000, goal="largest_error")
        self.assertLess(again.largest_error, 1e-4)
        self.assertAlmostEqual(again.material.young / fit.material.young, 1, delta=0.01)
        block = phymul.make_block((0.04, 0.02, 0.01), 4, 2, 1)
        self.assertEqual(block.set_material(**asdict(known)), known)
        with self.assertRaisesRegex(phymul.Error, "point 0: expected a stretch from 0.6 to 1.7"):
            phymul.fit_material([(3, 100)] * 6, poisson=0.49, density=1000)
        with self.assertRaisesRegex(phymul.Error, "goal"):
            phymul.fit_material([(1.1, 100)], poisson=0.49, density=1000, goal="best")
        with self.assertRaisesRegex(phymul.Error, "stress rises"):
            block.set_material(5e3, 0.45, 1000, second=6)

    def test_surfaces_are_filled(self):
        ball = phymul.make_body(CUBE, FACES, 0.006)
        self.assertIn("surface", ball.groups)
        ball.set_material(5e3, 0.4, 1000)
        self.assertAlmostEqual(ball.masses.sum() / (1000 * 0.02**3), 1, delta=0.05)
        finer = phymul.make_body(CUBE, FACES, 0.006, fine=[((0, 0, 0), 0.004, 0.0015)])
        near = [np.linalg.norm(body.rest, axis=1) < 0.004 for body in (ball, finer)]
        self.assertGreater(near[1].sum(), 3 * near[0].sum())
        with self.assertRaisesRegex(phymul.Error, "fine <= coarse|fine"):
            phymul.make_body(CUBE, FACES, 0.006, fine=[((0, 0, 0), 0.004, 0.01)])

    def test_walls_and_capsules_weigh_their_thickness(self):
        skin = phymul.Material(1e5, 0.4, 1000, thickness=0.5e-3)
        wall = phymul.make_wall(CUBE, FACES, skin, spacing=0.006)
        self.assertGreater(len(wall.rest), 50)
        self.assertAlmostEqual(wall.masses.sum(), 1000 * 0.5e-3 * 6 * 0.02**2, delta=1e-9)
        with phymul.Simulation(wall, backend="cpu") as simulation:
            self.assertTrue(simulation.advance(1e-3))
        block = phymul.make_block((0.02, 0.02, 0.02), 2, 2, 2)
        block.set_material(5e3, 0.4, 1000)
        cells = len(block.cells)
        block.add_capsule(skin)
        self.assertEqual(len(block.cells), cells + len(block.triangles))
        self.assertAlmostEqual(block.masses.sum(), 1000 * 0.02**3 + 1000 * 0.5e-3 * 6 * 0.02**2, delta=1e-9)
        with self.assertRaisesRegex(phymul.Error, "a thickness above 0"):
            block.add_capsule(phymul.Material(1e5, 0.4, 1000))

    def test_arrays_come_back(self):
        block = phymul.make_tetrahedral_block((0.02, 0.02, 0.02), 2, 2, 2)
        again = phymul.body_from_arrays(block.rest, {"tetrahedron": np.array(block.cells)})
        np.testing.assert_array_equal(again.rest, block.rest)
        np.testing.assert_array_equal(again.cells, block.cells)
        mixed = phymul.body_from_arrays(np.vstack([CUBE, [0.01, 0.01, 0.04]]),
                                        {"hexahedron": [[0, 1, 3, 2, 4, 5, 7, 6]], "pyramid": [[4, 5, 7, 6, 8]]})
        self.assertEqual([len(cell) for cell in mixed.cells], [8, 5])
        cloud = phymul.body_from_arrays(phymul.make_block((1, 1, 1), 3, 3, 3).rest)
        self.assertEqual((cloud.particles, cloud.cells), (64, []))

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "one.vtk"
            path.write_text("# vtk DataFile Version 3.0\none\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
                            "0 0 0 10 0 0 0 10 0 0 0 10\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n")
            body = phymul.read_body(path, 1e-3)
            np.testing.assert_allclose(body.rest.max(axis=0), [0.01] * 3)
            self.assertTrue(any("mass" in note for note in body.notes))
            path = pathlib.Path(folder) / "broken.vtk"
            path.write_text("nonsense")
            self.refused(ErrorCode.FILE_FORMAT, "broken.vtk", phymul.read_body, path)
            self.refused(ErrorCode.FILE_ACCESS, "absent.msh", phymul.read_body, "absent.msh")
            stl = "solid cube\n" + "".join(
                "facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % tuple(CUBE[i]) for i in face) +
                "endloop\nendfacet\n" for face in FACES) + "endsolid\n"
            path = pathlib.Path(folder) / "cube.stl"
            path.write_text(stl)
            vertices, triangles = phymul.read_surface(path, 2.0)
            self.assertEqual((vertices.shape, triangles.shape), ((8, 3), (12, 3)))
            np.testing.assert_allclose(vertices.max(axis=0), [0.04] * 3, rtol=1e-6)

    def test_misuse_is_refused_with_reasons(self):
        block = phymul.make_block((0.04, 0.02, 0.01), 4, 2, 1)
        invalid = ErrorCode.INVALID_ARGUMENT
        self.refused(ErrorCode.UNKNOWN_NAME, "x1", block.group, "x9")  # and lists the known ones
        self.refused(invalid, "(n, 3), got the shape (8, 2)", phymul.make_body, CUBE[:, :2], FACES, 0.01)
        self.refused(invalid, "integers of shape (n, 3), got float64", phymul.make_body, CUBE, FACES * 1.0, 0.01)
        self.refused(invalid, "expected numbers", phymul.body_from_arrays, [["a", "b", "c"]])
        self.refused(invalid, "(3,), got the shape (2,)", phymul.make_block, (1, 1), 2, 2, 2)
        self.refused(invalid, "(30,), got the shape (29,)", block.add_group, "g", np.ones(29, bool))
        self.refused(invalid, "float64", block.add_group, "g", [0.0, 1.0])
        self.refused(invalid, "999", block.add_group, "g", [999])
        self.refused(invalid, "32 bits", block.add_group, "g", [2**40])
        self.refused(invalid, "name", block.add_group, "", [1])
        self.refused(invalid, "0 to 7, got 8", block.add_cell_group, "g", [8])
        self.refused(invalid, "nx: expected an integer from -2147483648 to 2147483647, got 4294967298",
                     phymul.make_block, (1, 1, 1), 2**32 + 2, 2, 2)
        self.refused(invalid, "seed: expected an integer from 0", phymul.make_tetrahedral_block, (1, 1, 1), 2, 2, 2,
                     seed=-1)
        self.refused(invalid, "nx: expected an integer", phymul.make_block, (1, 1, 1), 2.0, 2, 2)
        self.refused(invalid, "threads: expected an integer", phymul.Simulation, block, threads=2**32 + 1)
        self.refused(invalid, "a name or path, got 3", phymul.Simulation, block, backend=3)  # C would take an address
        self.refused(invalid, "a name or path, got 1", phymul.Simulation, {1: block})
        self.refused(invalid, "a body: expected a Body", phymul.Simulation, {"a": phymul.Simulation(block)})
        self.refused(invalid, "a size: expected numbers", phymul.make_block, (1j, 1, 1), 2, 2, 2)
        self.refused(invalid, "a size: expected numbers", phymul.make_block, ("1", "1", "1"), 2, 2, 2)
        self.refused(invalid, '"brick"', phymul.body_from_arrays, CUBE, {"brick": [[0]]})
        self.refused(invalid, "over 99", phymul.body_from_arrays, CUBE, {"tetrahedron": [[0, 1, 2, 99]]})
        self.refused(invalid, "", block.set_material, -1, 0.4, 1000)
        self.refused(ErrorCode.UNKNOWN_NAME, "x0", block.set_material, 5e3, 0.4, 1000, group="")
        self.refused(invalid, "front: expected a point and a normal", block.cut, (0, 0, 0), (1, 0, 0), front=CUBE[:3])
        self.refused(invalid, "without a zero", block.group, "x0\0")
        self.refused(invalid, "without a zero", phymul.read_body, "x.msh\0")
        self.refused(invalid, "other than 0", phymul.read_body, "x.msh", 0)
        self.assertNotIn("g", block.groups)

    def test_views_outlive_their_body_and_nothing_else_does(self):
        block = phymul.make_block((0.04, 0.02, 0.01), 4, 2, 1)
        rest, before = block.rest, block.rest.copy()
        with self.assertRaises(ValueError):
            rest[0, 0] = 1.0
        block.add_group("more", [1])
        block.set_material(5e3, 0.4, 1000)
        self.assertIs(rest.base.owner, block._own)
        np.testing.assert_array_equal(rest, before)
        with self.assertRaisesRegex(TypeError, "body of the library cannot be copied"):
            copy.deepcopy(block)
        with block:
            pass
        self.refused(ErrorCode.INVALID_ARGUMENT, "Body is closed", lambda: block.rest)
        self.refused(ErrorCode.INVALID_ARGUMENT, "Body is closed", phymul.Simulation, block)
        del block
        np.testing.assert_array_equal(rest, before)


if __name__ == "__main__":
    unittest.main()
