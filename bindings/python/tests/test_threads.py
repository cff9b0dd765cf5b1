# SPDX-License-Identifier: MIT
"""Threads, needles, clips, jaws, fluids and tearing against laws. (Same bits as in C++: bindings/c/c_test.cpp.)"""
import math
import unittest

import numpy as np

import phymul
from phymul import Anchor, Clip, ErrorCode, Fluid, Needle, Pose, Thread
from test_bodies import Refusals
from test_simulation import SOFT, block


class Threads(Refusals):
    def test_lies_on_a_floor_and_is_drawn_by_suction(self):
        sim = block(damping=50.0).fix(np.ones(64, bool)).gravity((0, 0, -9.81))
        sim.add_tool(phymul.HalfSpace(), Pose((0, 0, -0.05)))
        wire = sim.add_thread(Thread(length=0.1, damping=5, touches=True), (0, 0.1, -0.045), (1, 0, 0))
        self.assertIsNone(wire.state.touch)
        sim.step(800, 5e-4)
        weight = 9.81 * 920 * math.pi * 0.15e-3**2 * 0.1
        np.testing.assert_allclose(wire.state.touch.sum(axis=0), (0, 0, weight), atol=1e-6 * weight)
        free = block(damping=50.0)
        tube = free.add_tool(phymul.Sphere(2e-3), Pose((0.01, 0.01, 0.033)), suction=0.3, suction_reach=8e-3)
        free.step(1, 1e-5)
        self.assertLess(tube.force.force[2], -0.01)
        self.assertGreater(np.linalg.norm(tube.force.force), 0.01)
        with self.assertRaisesRegex(phymul.Error, "suction reach above 0 m"):
            free.add_tool(phymul.Sphere(2e-3), suction=0.3)

    def test_tensions_follow_the_capstan(self):
        sim = block(damping=200.0).fix(np.ones(64, bool))
        stitch = sim.sew(Thread(length=0.2, friction=0.2), [(0.005, 0.01, 0.01), (0.01, 0.01, 0.02), (0.02, 0.01, 0.02)])
        stitch.join("first", Anchor(point=(0.005, 0.01, 0.0)))
        stitch.pull("last", (1, 0, -1))
        self.assertEqual(len(stitch.state.positions), 0)
        for _ in range(20):
            sim.advance(2e-3)
        sliding = 0
        for tick in range(20):
            pull = np.array((1, 0, -1)) * 1.05**tick
            stitch.pull("last", pull)
            before = stitch.state
            sim.step(1, 1e-4)
            state = stitch.state
            along = np.vstack([np.diff(before.positions[:-1], axis=0), pull])
            along /= np.linalg.norm(along, axis=1)[:, None]
            wrap = np.arccos((along[1:] * along[:-1]).sum(axis=1))
            self.assertAlmostEqual(state.tensions[-1] / np.linalg.norm(pull), 1, 12)
            ratio = state.tensions[1:] / state.tensions[:-1] / np.exp(0.2 * wrap)
            self.assertLess(ratio.max(), 1 + 1e-9)
            np.testing.assert_allclose(ratio[state.slides == 1], 1, rtol=1e-9)
            sliding += (state.slides == 1).sum()
        self.assertGreater(sliding, 20)
        np.testing.assert_array_equal(state.rows, [0, 1, 2])
        self.assertEqual((state.torn, state.pulled_out, state.broken.any()), (0, 0, False))
        np.testing.assert_allclose(np.linalg.norm(state.force_first), state.tensions[0], rtol=1e-12)

    def test_a_free_thread_carries_its_weight(self):
        sim = block().gravity((0, 0, -9.81)).fix(np.ones(64, bool))
        thread = sim.add_thread(Thread(length=0.03, radius=1e-3, damping=50), (0, 0, 0.2), (0, 0, -1))
        thread.hold(0, (0, 0, 0.2))
        for _ in range(200):
            sim.advance(2.5e-3)
        state, weight = thread.state, 920 * math.pi * 1e-6 * 0.03 * 9.81
        self.assertEqual(state.positions.shape, (11, 3))
        self.assertAlmostEqual(state.tensions[0] / weight, 1 - 1 / 20, delta=0.004)  # but for half a segment, which is held
        thread.release(0)
        sim.advance(0.02)
        self.assertLess(thread.state.positions[0, 2], 0.1999)

    def test_knots_hold_and_are_loosened(self):
        sim = block(damping=100.0).fix("z0")
        stitch = sim.sew(Thread(length=0.1, throw_holding=0.05), [(0.005, 0.015, 0.025), (0.025, 0.015, 0.025)])
        stitch.pull("first", (0.2, 0, 0))
        stitch.pull("last", (-0.2, 0, 0))
        sim.advance(0.1)
        stitch.tie(0, 1, throws=40)
        sim.advance(0.01)
        for tip in ("first", "last"):
            stitch.pull(tip, (0, 0, 0))
        sim.advance(0.1)
        knot = stitch.state.knots[0]
        self.assertEqual((knot.a, knot.b, knot.broken), (0, 1, False))
        self.assertGreater(knot.tension, 0.05)
        self.assertEqual(knot.slip, 0)
        stitch.tie(1, 0, throws=1)
        sim.advance(0.01)
        self.assertLessEqual(stitch.state.knots[0].tension, 0.05 + 1e-12)
        self.assertGreater(stitch.state.knots[0].tension, 0.04)
        self.assertGreater(stitch.state.knots[0].slip, 0)
        stitch.loosen(0, 1)
        sim.advance(0.01)
        self.assertEqual(stitch.state.knots, [])

    def test_a_clip_closes_to_its_gap_with_its_force(self):
        sim = block(damping=100.0).fix("x0")
        walls = Anchor(particles="y0"), Anchor(particles="y1")
        clip = sim.add_clip(Clip(gap=0.0295, holding=5.0), *walls)
        sim.advance(0.3)
        sim.advance(0.3)
        width = np.ptp([sim.positions[sim.body.group(wall), 1].mean() for wall in ("y0", "y1")])
        stretch = clip.state.tensions[1] / (2e9 * math.pi * 0.15e-3**2)
        self.assertAlmostEqual(width / (0.0295 * (1 + stretch)), 1, 5)
        clip.remove()
        sim = block(damping=100.0).fix("x0")
        weak = sim.add_clip(Clip(gap=0.02, holding=0.02, opening=0.05), *walls)  # too weak to close
        sim.advance(0.3)
        self.assertAlmostEqual(weak.state.tensions[1], 0.02, 9)

    def test_what_makes_no_sense_is_refused(self):
        sim = block()
        stitch = sim.sew(Thread(), [(0.01, 0.01, 0.01), (0.02, 0.01, 0.01)])
        self.refused(ErrorCode.INVALID_ARGUMENT, "Thread.length: expected 0 or more", sim.sew, Thread(length=-1), [(0, 0, 0)])
        self.refused(ErrorCode.INVALID_ARGUMENT, "0", sim.sew, Thread(length=0), [(0.01, 0.01, 0.01)] * 2)
        self.refused(ErrorCode.INVALID_ARGUMENT, '"first" or "last"', stitch.pull, "end", (0, 0, 0))
        self.refused(ErrorCode.INVALID_ARGUMENT, "free thread", stitch.hold, 0, (0, 0, 0))
        self.refused(ErrorCode.INVALID_ARGUMENT, "needle", sim.swage, Thread(), sim.add_tool(phymul.Sphere(0.01)))
        self.refused(ErrorCode.INVALID_ARGUMENT, '"gas"', sim.add_fluid, "a", sim.body.triangles, 1e-5, Fluid("air"))
        self.refused(ErrorCode.INVALID_ARGUMENT, "conductance: expected 0 or more", sim.add_fluid, "a",
                     sim.body.triangles, 1e-5, Fluid("gas", conductance=-1))
        self.refused(ErrorCode.UNKNOWN_NAME, "nothing", sim.set_volume, "nothing", 1e-5)
        stitch.remove()
        self.refused(ErrorCode.UNKNOWN_NAME, "thread", stitch.tie, 0, 1)


class Tools(Refusals):
    def test_a_needle_punctures_at_its_force_and_cuts_at_its_own(self):
        sim = block(young=50e3).fix("z0")
        shape = Needle(length=0.05, radius=0.5e-3, puncture=0.3, cutting=0.1, static_friction=0, kinetic_friction=0,
                       spread=0.015)
        needle = sim.add_tool(shape, Pose((0.014, 0.014, 0.0305)))
        self.assertEqual(needle.needle, phymul.NeedleState(0, False, False, False, 0.0))
        forces = []
        for tick in range(200):
            needle.move_to(Pose((0.014, 0.014, 0.0305 - 7.5e-5 * (tick + 1))))
            self.assertEqual(sim.advance(1e-3).tissue_gave_way, 0)
            forces.append(needle.force.force[2])
        self.assertAlmostEqual(max(forces), 0.3, delta=0.01)
        self.assertAlmostEqual(forces[-1], 0.1, 6)  # without friction nothing else acts
        self.assertTrue(needle.needle.punctured)
        np.testing.assert_allclose(needle.needle_points(3)[:, 2] - needle.pose.position[2], [0, 0.025, 0.05], atol=1e-12)
        self.refused(ErrorCode.INVALID_ARGUMENT, "another shape", lambda: sim.add_tool(phymul.Sphere(0.01)).needle)

    def test_jaws_close_until_they_press_with_their_grip(self):
        sim = block().fix("x0")
        hinge = Pose((0.055, 0.015, 0.015), (math.sqrt(0.5), 0, math.sqrt(0.5), 0))  # -z of the jaws: toward -x
        jaws = sim.add_jaws("grasper", hinge, length=0.035, width=0.04, opening=1.8, grip=0.2, speed=2.0, friction=0.8)
        self.assertAlmostEqual(jaws.report.angle, 1.8)
        jaws.close()
        for _ in range(600):
            jaws.follow(hinge, 1e-3)
            sim.advance(1e-3)
        self.assertAlmostEqual(jaws.report.grip, 0.2, delta=0.02)
        self.assertLess(jaws.report.angle, 1.7)
        self.assertGreater(jaws.first.force.particles, 0)
        jaws.open()
        for _ in range(600):
            jaws.follow(hinge, 1e-3)
            sim.advance(1e-3)
        self.assertAlmostEqual(jaws.report.angle, 1.8)
        for wrong in ({"grip": 0}, {"length": 0}, {"opening": 0}, {"friction": -0.5}):
            self.refused(ErrorCode.INVALID_ARGUMENT, "expected", sim.add_jaws, "other", hinge, **wrong)

    def test_jaws_of_a_toughness_are_scissors(self):
        body = phymul.make_tetrahedral_block((0.05, 0.03, 0.01), 10, 6, 2)
        body.set_material(1e5, 0.4, 1000.0)
        sim = phymul.Simulation(body.with_spare_particles(300), backend="cpu", damping=20.0).fix("y0").fix("y1")
        hinge = Pose((0.06, 0.014, 0.005), (0.5, 0.5, 0.5, 0.5))  # into the body along -x, opening along z
        for toughness, cut in ((1e4, False), (0.0, True)):
            jaws = sim.add_jaws(f"scissors of {toughness}", hinge, length=0.03, opening=1.4, speed=2.0, grip=0.2,
                                toughness=toughness)
            jaws.close()
            for _ in range(800):
                jaws.follow(hinge, 1e-3)
                sim.advance(1e-3)
            self.assertEqual(sim.cuts > 0, cut)
            self.assertEqual(jaws.report.angle < 1e-6, cut)
            jaws.first.remove()
            jaws.second.remove()


class Bodies(Refusals):
    def test_fluids_follow_their_law_and_flow_out(self):
        sim = block(backend="reference", damping=100.0)
        full = 2.7e-5
        sim.add_fluid("air", sim.body.triangles, full, Fluid("curve", curve=[(0.5, 2000), (1.5, -2000)]))
        sim.set_volume("air", 1.01 * full)
        for _ in range(50):
            sim.advance(1e-2)
        now = sim.fluid("air")
        self.assertAlmostEqual(now.volume, 1.01 * full)
        a, b, c = (sim.positions[sim.body.triangles[:, k]] for k in range(3))
        box = (a * np.cross(b, c)).sum() / 6  # m^3
        self.assertAlmostEqual(now.pressure / (2000 - 4000 * (box / now.volume - 0.5)), 1, delta=1e-3)
        sim.set_fluid("air", Fluid("curve", curve=[(0.5, 2000), (1.5, -2000)], conductance=1e-8))
        before = sim.fluid("air")
        sim.step(1, 1e-6)
        lost = before.volume - sim.fluid("air").volume
        self.assertAlmostEqual(lost / (1e-8 * before.pressure * 1e-6), 1, delta=1e-3)
        sim.remove_volume("air")
        self.refused(ErrorCode.UNKNOWN_NAME, "air", sim.fluid, "air")
        sim.constrain_volume().set_volume("volume 2", full)  # the second one

    def test_a_fluid_flows_into_another_body(self):
        left = phymul.make_block((0.03, 0.03, 0.03), 3, 3, 3)
        sim = phymul.Simulation({"left": left, "right": left.moved((0.05, 0, 0))}, **SOFT, backend="reference")
        triangles, full = sim.body.triangles, 2.7e-5
        of_left = triangles[:, 0] < left.particles
        sim.fix(np.ones(sim.body.particles, bool))
        sim.add_fluid("right", triangles[~of_left], full, Fluid("gas"))
        sim.add_fluid("left", triangles[of_left], 1.1 * full, Fluid("gas", conductance=1e-9, opens_into="right"))
        sim.step(1, 1e-3)
        flows = 1e-3 * 1e-9 * (sim.fluid("left").pressure - sim.fluid("right").pressure)
        self.assertAlmostEqual(flows / 1.0132e-8, 1, delta=0.01)  # a tenth of 101325 Pa
        self.assertAlmostEqual(1e9 * (sim.fluid("right").volume - full), 1e9 * flows)
        sim.step(3000, 1e-3)
        self.assertEqual(sim.fluid("left").volume + sim.fluid("right").volume, 1.1 * full + full)
        self.assertAlmostEqual(sim.fluid("left").volume / sim.fluid("right").volume, 1, delta=1e-6)
        self.refused(ErrorCode.UNKNOWN_NAME, '"there"', sim.set_fluid, "left", Fluid(opens_into="there"))

    def test_a_notched_strip_tears_and_a_cut_makes_two_parts(self):
        body = phymul.make_tetrahedral_block((0.04, 0.02, 0.005), 16, 8, 2)
        body.set_material(**SOFT)
        body = body.with_spare_particles(400).cut((0.02, 0, 0), (1, 0, 0), ((0, 0.008, 0), (0, 1, 0)))
        for toughness in (0.05, 0):
            sim = phymul.Simulation(body, damping=100.0, backend="cpu").tear(toughness)
            sim.fix("x0").add_load("translation", "x1", (1, 0, 0), [(0, 0), (0.2, 0.03)])
            torn = sum(sim.advance(2e-3).torn for _ in range(100))
            self.assertEqual((torn > 0, sim.cuts > 0), (toughness > 0, toughness > 0))
        sim = phymul.Simulation(body)
        self.assertTrue(sim.cut((0.013, 0, 0), (1, 0, 0)))
        number, volumes = sim.body.parts
        np.testing.assert_allclose(volumes, [0.013 * 1e-4, 0.027 * 1e-4], rtol=5e-3)  # through jittered corners
        self.assertAlmostEqual(volumes.sum() / 4e-6, 1, 9)
        self.assertEqual(set(number), {-1, 0, 1})  # spare particles that are left have none


if __name__ == "__main__":
    unittest.main()
