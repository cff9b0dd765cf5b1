# SPDX-License-Identifier: MIT
import pathlib
import pickle
import tempfile
import unittest

import numpy as np

import phymul
from phymul import Anchor, ErrorCode, Pose
from test_bodies import Refusals

SOFT = {"young": 10e3, "poisson": 0.4, "density": 1000}


# A triangle that does not move, and a tetrahedron of springs that hangs from it by a thread.
TWO_BODIES = """<physicalModel name="two"><atoms><structuralComponent>
<atom><atomProperties index="0" x="0" y="0" z="20"/></atom><atom><atomProperties index="1" x="9" y="0" z="20"/></atom>
<atom><atomProperties index="2" x="0" y="9" z="20"/></atom><atom><atomProperties index="3" x="0" y="0" z="10"/></atom>
<atom><atomProperties index="4" x="5" y="0" z="0"/></atom><atom><atomProperties index="5" x="-5" y="5" z="0"/></atom>
<atom><atomProperties index="6" x="-5" y="-5" z="0"/></atom>
</structuralComponent></atoms><exclusiveComponents><multiComponent name="bodies">
<structuralComponent name="hook" bodyType="rigid"><cell><cellProperties type="TRIANGLE"/>
<atomRef index="0"/><atomRef index="1"/><atomRef index="2"/></cell></structuralComponent>
<structuralComponent name="net" bodyType="stiffSpring" mass="1e-3" stiffness="20" damping="0.01">
<cell><cellProperties type="TETRAHEDRON"/><atomRef index="3"/><atomRef index="4"/><atomRef index="5"/>
<atomRef index="6"/></cell></structuralComponent>
<structuralComponent name="thread" bodyType="interaction" stiffness="5" damping="0.01" body1="hook" body2="net">
<cell><cellProperties type="LINE"/><atomRef index="0"/><atomRef index="3"/></cell></structuralComponent>
</multiComponent></exclusiveComponents></physicalModel>"""


def block(**options):
    options = {**SOFT, "backend": "cpu", "damping": 20, "threads": 1, **options}
    return phymul.Simulation(phymul.make_block((0.03, 0.03, 0.03), 3, 3, 3), **options)


class Steps(Refusals):
    def test_a_falling_body_falls_as_it_should(self):
        sim = block(damping=0.0).gravity((0, 0, -2))
        report = sim.advance(0.1)
        self.assertAlmostEqual(sim.time, 0.1)
        self.assertGreater(report.steps, 1)
        np.testing.assert_allclose(sim.displacements[:, 2], -0.01, rtol=0.05)
        np.testing.assert_allclose(sim.velocities[:, 2], -0.2, rtol=1e-3)
        self.assertAlmostEqual(sim.energy.gravity, sim.body.masses.sum() * 2 * sim.displacements[:, 2].mean())
        self.assertLess(np.abs(sim.forces).max(), 1e-6)

    def test_loads_rest_and_static_solve_agree(self):
        places = []
        for way in ("run_to_rest", "solve_static"):
            sim = block(backend="reference").fix("z0")
            load = sim.add_load("force", "z1", (1, 0, 0), 1e-3)
            load.set(np.float32(1))
            load.set(np.array(2e-3))
            report = getattr(sim, way)()
            self.assertTrue(report.converged, report.message)
            self.assertEqual(report.folded, -1)
            places.append(sim.displacements)
            force, side, young = 16 * 2e-3, 0.03, 10e3
            beam = force * side / (5 / 6 * young / 2.8 * side**2) + force * side**3 / (3 * young * side**4 / 12)  # m
            self.assertAlmostEqual(places[-1][sim.body.group("z1"), 0].mean() / beam, 1, delta=0.25)
        np.testing.assert_allclose(places[0], places[1], atol=1e-4 * np.abs(places[0]).max())

    def test_materials_become_softer_and_dissipate(self):
        body = phymul.make_block((0.03, 0.03, 0.03), 3, 3, 3)
        tissue = body.set_material(**SOFT)
        sim = phymul.Simulation(body, backend="reference").fix("z0").gravity((0, 0, -0.1))
        self.assertTrue(sim.solve_static().converged)
        self.assertTrue(sim.solve_static(predict=True).converged)
        before, forces, step = sim.displacements.copy(), sim.forces.copy(), sim.stable_step
        self.assertTrue(sim.scale_stiffness(0.5, tissue).solve_static().converged)
        np.testing.assert_allclose(sim.displacements, 2 * before, atol=1e-3 * np.abs(before).max())
        self.assertAlmostEqual(sim.stable_step / step, 2**0.5)
        np.testing.assert_allclose(sim.forces, forces, atol=1e-3 * np.abs(forces).max())  # they carry the same weight
        with self.assertRaisesRegex(phymul.Error, "a material of the model"):
            sim.scale_stiffness(0.5, phymul.Material(1e3, 0.4, 1000))
        body.set_material(**SOFT, relaxation_strength=1, relaxation_time=0.1)
        self.assertAlmostEqual(phymul.Simulation(body, backend="reference").stable_step / step, 0.5**0.5)

    def test_values_of_loads_follow_time(self):
        sim = block().fix("z0")
        sim.add_load("translation", sim.body.rest[:, 2] > 0.029, (0, 0, 1), [(0, 0), (0.1, 3e-3)])
        sim.advance(0.05)
        np.testing.assert_allclose(sim.displacements[sim.body.group("z1"), 2], 1.5e-3, rtol=1e-3)
        sim = block().fix("z0")
        sim.set_state(time=-1)
        sim.add_load("force", "z1", (1, 0, 0), 1e-3)  # from before the beginning
        sim.advance(0.05)
        self.assertGreater(sim.displacements[:, 0].max(), 1e-4)

    def test_failures_of_steps_carry_the_report(self):
        sim = block()
        with self.assertRaises(phymul.StepError) as caught:
            sim.step(5, 1.0)
        self.assertEqual(caught.exception.code, ErrorCode.STEP_FAILED)
        self.assertEqual(caught.exception.report.steps, 0)
        self.assertIn(str(caught.exception), caught.exception.report.message)
        sent = pickle.loads(pickle.dumps(caught.exception))  # as between processes
        self.assertEqual((str(sent), sent.report), (str(caught.exception), caught.exception.report))
        self.assertEqual(sim.step(2, 0.5 * sim.stable_step).steps, 2)
        free = block().gravity((0, 0, -1))
        self.refused(ErrorCode.STEP_FAILED, "", free.solve_static)
        self.assertTrue(any("hold" in warning for warning in free.warnings), free.warnings)

    def test_several_bodies_touch(self):
        lower = phymul.make_block((0.03, 0.03, 0.02), 3, 3, 2)
        sim = phymul.Simulation({"lower": lower, "upper": lower.moved((0, 0, 0.022))}, **SOFT, damping=20)
        sim.fix("lower/z0").gravity((0, 0, -9.81)).contacts(friction=0.4)
        sim.advance(0.4)
        self.assertGreater(sim.positions[sim.body.group("upper"), 2].min(), 0.017)

    def test_misuse_is_refused_with_reasons(self):
        sim, invalid = block(), ErrorCode.INVALID_ARGUMENT
        self.refused(ErrorCode.UNKNOWN_NAME, "x0", sim.fix, "tumour")
        self.refused(ErrorCode.UNKNOWN_NAME, "reference", lambda: block(backend="abacus").time)
        self.refused(invalid, "(64,), got the shape (3,)", sim.fix, [True, False, True])
        self.refused(invalid, "64", sim.fix, [64])
        self.refused(invalid, "(3,)", sim.gravity, 9.81)
        self.refused(invalid, "pressure", sim.add_load, "push", "z1")
        self.refused(ErrorCode.UNKNOWN_NAME, "x0", sim.constrain_volume, "")
        self.refused(invalid, "front: expected a point and a normal", sim.cut, (0, 0, 0), (1, 0, 0), front=np.eye(3))
        for name, function in (("rest_tolerance", block), ("tolerance", sim.solve_static),
                               ("most_evaluations", sim.solve_static), ("budget", phymul.plan),
                               ("head_room", phymul.plan)):
            rest = {"build": block, "max_error": 0.1, "rate": 50} if function is phymul.plan else {}
            self.refused(invalid, f"{name}: expected a number other than 0", function, **rest, **{name: 0})
        anchors = Anchor(particles="z1"), Anchor(point=(0, 0, 1))
        self.refused(invalid, "breaking_force: expected", sim.add_joint, *anchors, 1.0, breaking_force=0)
        self.refused(invalid, "breaking_stress: expected", sim.attach, "z1", stiffness=1.0, breaking_stress=0)
        self.refused(invalid, "(n, 2)", sim.add_load, "force", "z1", (0, 0, 1), [1.0, 2.0])
        self.refused(invalid, "(64, 3), got the shape (3, 3)", sim.set_state, np.zeros((3, 3)))
        self.refused(invalid, "is closed", sim.restore, self.closed(sim.snapshot()))
        self.refused(invalid, "a snapshot: expected a Snapshot", sim.restore, sim)
        for partner in ([1, 2], b"x0", sim):
            self.refused(invalid, "a partner: expected a Tool", sim.attach, "z1", partner, stiffness=1.0)
        self.refused(invalid, "orientation other than 0", sim.add_tool, phymul.Sphere(1.0), Pose(orientation=(0,) * 4))
        sim.close()
        self.refused(invalid, "Simulation is closed", sim.advance, 0.1)
        self.refused(invalid, "Simulation is closed", lambda: sim.positions)

    @staticmethod
    def closed(owner):
        owner.close()
        return owner


class Views(Refusals):
    def test_are_one_buffer_without_copies(self):
        sim = block().gravity((0, 0, -2))
        first = sim.positions
        self.assertFalse(first.flags.writeable)
        self.assertFalse(first.flags.owndata)
        before, energy = first.copy(), sim.velocities
        sim.advance(0.01)
        np.testing.assert_array_equal(first, before)  # only reading brings it up to date
        second = sim.positions
        self.assertEqual(first.ctypes.data, second.ctypes.data)
        self.assertNotEqual(energy.ctypes.data, second.ctypes.data)
        self.assertTrue((first[:, 2] < before[:, 2]).all())

    def test_stay_valid_after_restore_rest_and_close(self):
        sim = block().fix("z0").gravity((0, 0, -2))
        view = sim.positions
        start = sim.snapshot()
        sim.run_to_rest()
        sim.restore(start)
        sim.set_state(positions=sim.body.rest + [0, 0, 1e-3])
        np.testing.assert_allclose(sim.positions[:, 2], sim.body.rest[:, 2] + 1e-3, atol=1e-8)
        last = view.copy()
        with sim.body:
            pass
        self.assertEqual(sim.body.particles, 64)
        sim.close()
        del sim
        np.testing.assert_array_equal(view, last)


class States(Refusals):
    def test_go_back_bit_by_bit_in_memory_and_files(self):
        sim = block().fix("z0").gravity((1, 0, -2))
        sim.advance(0.02)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "now.state"
            start = sim.snapshot()
            sim.save(path)
            sim.advance(0.02)
            there = sim.positions.copy()
            for back in (lambda: sim.restore(start), lambda: sim.load(path)):
                back()
                self.assertAlmostEqual(sim.time, 0.02)
                self.assertFalse(np.array_equal(sim.positions, there))
                sim.advance(0.02)
                np.testing.assert_array_equal(sim.positions, there)
            sim.write_vtu(pathlib.Path(folder) / "now.vtu")
            self.assertIn("displacement", (pathlib.Path(folder) / "now.vtu").read_text(errors="replace"))
            other = phymul.Simulation(phymul.make_block((1, 1, 1), 2, 2, 2), **SOFT)
            with self.assertRaises(phymul.Error):
                other.load(path)

    def test_removed_cells_come_back(self):
        sim = block().fix("z0").gravity((1, 0, -2))
        start, whole = sim.snapshot(), sim.body.masses
        top = sim.body.cell_centres[:, 2] > sim.body.rest[:, 2].max() / 2
        sim.remove_cells(top)
        self.assertLess(sim.body.masses.sum(), 0.7 * whole.sum())
        self.assertEqual(sim.advance(0.01).steps > 0, True)
        self.refused(phymul.ErrorCode.INVALID_ARGUMENT, "1000000", sim.remove_cells, [1_000_000])
        sim.restore(start)
        np.testing.assert_array_equal(sim.body.masses, whole)

    def test_cut_bodies_open(self):
        body = phymul.make_tetrahedral_block((0.1, 0.1, 0.05), 6, 6, 3)
        body.set_material(1e4, 0.4, 1000.0)
        cut = body.cut((0.05, 0, 0), (1, 0, 0), front=((0, 0.05, 0), (0, 1, 0)))
        self.assertGreater(cut.particles, body.particles)
        self.assertAlmostEqual(cut.masses.sum() / body.masses.sum(), 1.0)
        self.refused(phymul.ErrorCode.NOT_SUPPORTED, "tetrahedra", phymul.make_block((1, 1, 1), 2, 2, 2).cut,
                     (0.5, 0, 0), (1, 0, 0))
        self.assertGreater(cut.cut((0, 0.05, 0), (0, 1, 0)).particles, cut.particles)
        self.assertEqual(body.cut((1, 0, 0), (1, 0, 0)).particles, body.particles)

    def test_simulations_are_cut(self):
        body = phymul.make_tetrahedral_block((0.1, 0.1, 0.05), 6, 6, 3)
        body.set_material(1e4, 0.4, 1000.0)
        self.refused(phymul.ErrorCode.NOT_SUPPORTED, "spare", phymul.Simulation(body, backend="cpu").cut,
                     (0.05, 0, 0), (1, 0, 0))
        sim = phymul.Simulation(body.with_spare_particles(300), backend="cpu").fix("x0").gravity((0, 0, -9.81))
        start, cells = sim.snapshot(), len(sim.body.cells)
        self.assertFalse(sim.cut((1, 0, 0), (1, 0, 0)))
        self.assertTrue(sim.cut((0.05, 0, 0), (1, 0, 0), front=((0, 0.05, 0), (0, 1, 0))))
        self.assertGreater(len(sim.body.cells), cells)
        for wrong in ({"belly": 0.2}, {"bow": 0.2}, {"height": -1.0}, {"friction": -1.0}, {"toughness": -1.0}):
            self.refused(phymul.ErrorCode.INVALID_ARGUMENT, *wrong, sim.add_tool, phymul.Blade(width=0.2, **wrong))
        edge = sim.add_tool(phymul.Blade(width=0.2), phymul.Pose((0.08, 0.0, 0.0), (0.5, 0.5, 0.5, 0.5)))
        sim.advance(0.01)
        self.assertGreater(np.count_nonzero(sim.body.masses), body.particles)
        self.assertEqual(edge.force.particles, 0)
        sim.restore(start)
        self.assertEqual(len(sim.body.cells), cells)

    def test_masks_of_places_leave_spare_particles_out(self):
        body = phymul.make_tetrahedral_block((0.06, 0.04, 0.02), 6, 4, 3)
        body.set_material(1e4, 0.45, 1000)
        body = body.with_spare_particles(200)
        body.add_group("left", body.rest[:, 0] < 1e-3)
        np.testing.assert_array_equal(body.group("left"), body.group("x0"))
        np.testing.assert_array_equal(np.flatnonzero(body.within((0, 0, 0), 1e-3)), [0])

        def cut(left):
            sim = phymul.Simulation(body, damping=20, backend="cpu", threads=1).gravity((0, 0, -1))
            sim.fix(left(sim)).cut((0.031, 0, 0), (1, 0, 0))
            sim.advance(0.1)
            return sim.displacements

        by_group = cut(lambda sim: "x0")
        self.assertGreater(np.abs(by_group).max(), 2e-3)  # what is cut off falls
        np.testing.assert_array_equal(by_group, cut(lambda sim: sim.body.rest[:, 0] < 1e-3))

    def test_recordings_repeat(self):
        sim = block().fix("z0").gravity((0, 0, -2))
        sim.record()
        sim.advance(0.01)
        sim.step(5, 1e-4)
        there = sim.positions.copy()
        with tempfile.TemporaryDirectory() as folder:
            sim.save_recording(pathlib.Path(folder) / "run")
            again = block()
            push = again.add_load("force", "z1", (0, 0, 1), 1.0)
            self.refused(ErrorCode.FILE_ACCESS, "none", again.replay, pathlib.Path(folder) / "none")
            push.set(2.0)  # the scene is as it was
            other = block(damping=3)
            kept = other.add_load("force", "z1", (0, 0, 1), 1.0)
            self.refused(ErrorCode.INVALID_ARGUMENT, "damping", other.replay, pathlib.Path(folder) / "run")
            kept.set(2.0)
            again.replay(pathlib.Path(folder) / "run")
            self.refused(ErrorCode.UNKNOWN_NAME, "load is gone", push.set, 0.0)
        np.testing.assert_array_equal(again.positions, there)
        self.refused(ErrorCode.INVALID_ARGUMENT, "", again.save_recording, "nowhere")


class ToolsJointsSkins(Refusals):
    def test_a_ball_presses_is_felt_and_grasps(self):
        sim = block().fix("z0")
        ball = sim.add_tool(phymul.Sphere(0.012), Pose((0.015, 0.015, 0.042)), friction=0.2)
        for tick in range(1, 21):
            ball.move_to(Pose((0.015, 0.015, 0.042 - 3e-4 * tick)))
            sim.advance(2e-3)
        np.testing.assert_allclose(ball.pose.position, [0.015, 0.015, 0.036])
        self.assertGreater(ball.force.force[2], 0.01)
        self.assertGreater(ball.force.particles, 0)
        ball.grasp(2e-3)
        sim.advance(2e-3)
        self.assertGreater(ball.force.held, 0)
        ball.release()
        sim.advance(2e-3)
        self.assertEqual(ball.force.held, 0)
        ball.teleport(Pose((0, 0, 1), orientation=(0, 1, 0, 0)))
        sim.advance(2e-3)
        self.assertEqual(ball.force.particles, 0)
        np.testing.assert_allclose(ball.pose.orientation, [0, 1, 0, 0])
        ball.remove()
        self.refused(ErrorCode.UNKNOWN_NAME, "tool", lambda: ball.force)

    def test_every_shape_and_contact(self):
        for shape, height in ((phymul.Capsule(0.012, 0.05), 0.038), (phymul.Box((0.01, 0.01, 0.005)), 0.034),
                              (phymul.HalfSpace(), 0.001)):
            for contact in ("particles", "surface"):
                sim = block()
                tool = sim.add_tool(shape, Pose((0.015, 0.015, height)), contact=contact, margin=1e-4)
                sim.advance(0.01)
                moved = np.abs(sim.displacements).max()
                self.assertGreater(moved, 1e-4, (shape, contact))
                self.assertIsInstance(tool.pose, Pose)
        self.refused(ErrorCode.INVALID_ARGUMENT, "Sphere", block().add_tool, "ball")
        self.refused(ErrorCode.INVALID_ARGUMENT, "contact", block().add_tool, phymul.Sphere(1.0), contact="all")
        self.refused(ErrorCode.INVALID_ARGUMENT, "", block().add_tool, phymul.Sphere(-1.0))
        self.refused(ErrorCode.INVALID_ARGUMENT, "position: expected numbers of shape (3,)", block().add_tool,
                     phymul.Sphere(1.0), Pose((0, 0)))

    def test_springs_carry_the_weight(self):
        weight = 1000 * 0.03**3 * 9.81
        sim = block(damping=30).gravity((0, 0, -9.81))
        patch = sim.attach("z1", stiffness=1e6, damping=100, offset=(0, 0, 0.01))
        sim.run_to_rest()
        self.assertAlmostEqual(patch.report.force[2], weight, delta=0.01 * weight)
        self.assertEqual((patch.report.springs, patch.report.broken), (16, 0))

        sim = block(damping=30).gravity((0, 0, -9.81))
        thread = sim.add_joint(Anchor(particles="z1"), Anchor(point=(0.015, 0.015, 0.05)), 200, rest_length=0.02)
        sim.run_to_rest()
        self.assertAlmostEqual(thread.report.largest, weight, delta=0.01 * weight)
        thread.set_stiffness(0.0)
        sim.advance(2e-3)
        self.assertEqual(thread.report.largest, 0.0)
        thread.remove()
        self.refused(ErrorCode.UNKNOWN_NAME, "joint", lambda: thread.report)

    def test_springs_begin_where_the_particles_are(self):
        def pulled():
            sim = block(backend="reference").fix("z0")
            sim.add_load("translation", "z1", (0, 0, 1), 3e-3)
            return sim

        there = pulled()
        there.advance(0.01)
        there = there.snapshot()
        for way in (lambda sim: sim.advance(0.01), lambda sim: sim.step(1, 1e-4), lambda sim: sim.run_to_rest(10),
                    lambda sim: sim.solve_static(), lambda sim: sim.restore(there),
                    lambda sim: sim.set_state(positions=sim.body.rest + [0, 0, 3e-3])):
            sim = pulled()
            way(sim)
            tool = sim.add_tool(phymul.Sphere(1e-3), Pose((0.015, 0.015, 0.06)))
            springs = [sim.add_joint(Anchor(particles="z1"), Anchor(point=(0.015, 0.015, 0.06)), 10),
                       sim.attach("z1", stiffness=1e4), sim.attach("z1", tool, stiffness=1e4)]
            sim.step(1, 1e-5)
            for spring in springs:
                self.assertLess(np.abs(spring.report.force).max(), 1e-9)

    def test_a_part_of_a_surface_is_held(self):
        body = phymul.make_block((0.03, 0.03, 0.03), 3, 3, 3)
        sim = phymul.Simulation(body, **SOFT, damping=30).gravity((0, 0, -9.81))
        patch = sim.hold_near(body.rest, body.triangles, (0.015, 0.015, 0.03), 0.012, 0.01 / 3)
        sim.run_to_rest()
        self.assertAlmostEqual(patch.report.force[2], 1000 * 0.03**3 * 9.81, delta=0.003)
        self.refused(ErrorCode.INVALID_ARGUMENT, "inside", sim.hold_near, body.rest, body.triangles, (1, 1, 1), 0.1,
                     0.01)

    def test_bodies_of_a_pml_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "two.pml"
            path.write_text(TWO_BODIES)
            sim = phymul.Simulation(phymul.read_body(path), backend="reference", damping=20).gravity((0, 0, -9.81))
        self.assertEqual(sim.add_body_types(), [
            'component "hook" (bodyType "rigid"): its 3 particle(s) are held',
            'component "net" (bodyType "stiffSpring"): 6 spring(s) of 20 N/m',
            'component "thread" (bodyType "interaction"): 1 spring(s) of 5 N/m'])
        sim.run_to_rest()
        np.testing.assert_array_equal(sim.displacements[:3], np.zeros((3, 3)))
        weight = 4 * 1e-3 * 9.81
        self.assertAlmostEqual(sim.displacements[3, 2], -weight / 5, delta=1e-2 * weight / 5)

    def test_glue_and_tools_as_partners(self):
        lower = phymul.make_block((0.03, 0.03, 0.02), 3, 3, 2)
        sim = phymul.Simulation({"lower": lower, "upper": lower.moved((0, 0, 0.021))}, **SOFT, damping=20)
        sim.fix("lower/z0").gravity((0, 0, 5))
        glue = sim.attach("upper/z0", "lower", stiffness=1e6, breaking_stress=1e6)
        sim.run_to_rest()
        self.assertAlmostEqual(glue.report.force[2], -1000 * 0.03 * 0.03 * 0.02 * 5, delta=1e-3)
        tool = sim.add_tool(phymul.Sphere(0.001), Pose((0.015, 0.015, 0.06)))
        held = sim.attach("upper/z1", tool, stiffness=1e6)
        tied = sim.add_joint(Anchor(particles=[0], tool=None), Anchor(tool=tool), 1.0)
        tool.move_to(Pose((0.015, 0.015, 0.065)))
        sim.run_to_rest()
        self.assertGreater(held.report.force[2], 0.01)
        self.assertGreater(tied.report.largest, 0.0)
        self.refused(ErrorCode.INVALID_ARGUMENT, "of another", block().attach, "z1", tool, stiffness=1.0)
        self.refused(ErrorCode.INVALID_ARGUMENT, "particles or a tool", Anchor, particles=[0], tool=tool)

    def test_skins_follow(self):
        sim = block()
        points = [[0.004, 0.004, 0.03], [0.022, 0.004, 0.03], [0.004, 0.022, 0.03]]
        skin = sim.bind(points, [[0, 1, 2]])
        stretch = np.diag([1.0, 1.0, 1.5])
        sim.set_state(positions=sim.body.rest @ stretch + [0, 0, 1])
        places, normals = skin.deform()
        np.testing.assert_allclose(places, points @ stretch + [0, 0, 1], atol=1e-7)
        np.testing.assert_allclose(normals, [[0, 0, 1]] * 3, atol=1e-6)
        invalid = ErrorCode.INVALID_ARGUMENT
        self.refused(invalid, "", sim.bind, points, [[0, 1, 3]])
        self.refused(invalid, "", sim.bind, np.array(points) + 10)
        sim.close()
        self.refused(invalid, "Simulation is closed", skin.deform)
        np.testing.assert_allclose(normals, [[0, 0, 1]] * 3, atol=1e-6)


class Planning(Refusals):
    @staticmethod
    def build(candidate):
        n = max(1, round(0.05 / candidate.spacing))
        sim = phymul.Simulation(phymul.make_block((0.1, 0.05, 0.05), 2 * n, n, n), **SOFT, **candidate.options)
        return sim.fix("x0").gravity((0, 0, -0.1))

    def test_finds_a_body_and_makes_it(self):
        plan = phymul.plan(self.build, max_error=0.2, rate=50, budget=2, most_threads=1)
        self.assertIsNotNone(plan.chosen, plan.report)
        self.assertIsNone(plan.cheapest)
        self.assertIn(plan.chosen, plan.trials)
        self.assertTrue(plan.chosen.error < 0.2 and plan.chosen.keeps_error and plan.chosen.keeps_time)
        self.assertIn("Chosen", plan.report)
        sim = plan.make()
        self.assertEqual(sim.body.particles, plan.chosen.particles)
        self.refused(ErrorCode.INVALID_ARGUMENT, "no offer", plan.make, "most_accurate")
        self.assertGreater(sim.advance(0.01).steps, 0)
        self.refused(ErrorCode.INVALID_ARGUMENT, "cheapest", plan.make, "best")

    def test_what_the_builder_throws_comes_out(self):
        def broken(candidate):
            raise KeyError("a mistake")

        def viewed(candidate):
            sim = self.build(candidate)
            sim.kept = sim.positions
            return sim

        def unmoved(candidate):
            if not tried:
                tried.append(candidate)
                raise phymul.Error("too coarse")
            return self.build(candidate).gravity((0, 0, 0))

        tried = []
        with self.assertRaises(KeyError):
            phymul.plan(broken, max_error=0.2, rate=50)
        self.refused(ErrorCode.INVALID_ARGUMENT, "nothing moves", phymul.plan, unmoved, max_error=0.2, rate=50)
        with self.assertRaisesRegex(ValueError, "handed over"):
            phymul.plan(viewed, max_error=0.2, rate=50)
        with self.assertRaisesRegex(TypeError, "must return a Simulation"):
            phymul.plan(lambda candidate: self.build(candidate).body, max_error=0.2, rate=50)
        self.refused(ErrorCode.UNKNOWN_NAME, "x0", phymul.plan, lambda candidate: self.build(candidate).fix("x9"),
                     max_error=0.2, rate=50)
        self.refused(ErrorCode.INVALID_ARGUMENT, "max_error", phymul.plan, self.build, max_error=2.0, rate=50)


if __name__ == "__main__":
    unittest.main()
