// SPDX-License-Identifier: MIT
//
// The soft cube in Bullet 3: its deformable world with implicit springs. Three things its documentation does not say:
// without setUseProjection(true) a held body does not move at all, sleeping has to be off, and a body's own damping and
// self collision have to be switched off one by one.
#include "soft_cube.h"

#if PHYMUL_BENCH_BULLET

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <memory>

#include "stopwatch.h"

namespace phymul::bench {
namespace {

struct World {
  World() {
    solver.setDeformableSolver(&deformable);
    world = std::make_unique<btDeformableMultiBodyDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration,
                                                                 &deformable);
    world->setGravity(btVector3(0, -cube_gravity, 0));
    world->getWorldInfo().m_gravity.setValue(0, -cube_gravity, 0);
    world->setImplicit(true);
    world->setLineSearch(false);
    world->setUseProjection(true);
    world->getSolverInfo().m_deformable_erp = 0.3;
    world->getSolverInfo().m_deformable_maxErrorReduction = 200;
  }

  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btDeformableBodySolver deformable;
  btDeformableMultiBodyConstraintSolver solver;
  std::unique_ptr<btDeformableMultiBodyDynamicsWorld> world;
};

/// Owned by whoever calls; the world does not delete soft bodies.
std::unique_ptr<btSoftBody> make_body(const Model& cube, btSoftBodyWorldInfo& info) {
  std::vector<btVector3> place;
  std::vector<btScalar> mass;
  for (Index i = 0; i < cube.particle_count(); ++i) {
    place.emplace_back(cube.rest[i].x(), cube.rest[i].y(), cube.rest[i].z());
    mass.push_back(cube.mass[i]);
  }
  auto body = std::make_unique<btSoftBody>(&info, cube.particle_count(), place.data(), mass.data());
  for (Index i = 0; i < cube.particle_count(); ++i) {
    for (const Index* j = cube.neighbours.begin(i); j != cube.neighbours.end(i); ++j) {
      if (i < *j) body->appendLink(i, *j);
    }
  }
  for (const Index i : cube.group("held")) body->setMass(i, 0);
  body->m_cfg.kDP = 0;
  body->m_cfg.collisions = 0;
  body->m_sleepingThreshold = 0;
  body->setSelfCollision(false);
  body->setDampingCoefficient(0);
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

}  // namespace

SoftCubeRun run_soft_cube_in_bullet(const Model& cube, int steps) {
  SoftCubeRun run;
  run.device = "Bullet 3, double precision, one thread";
  World world;
  const auto body = make_body(cube, world.world->getWorldInfo());
  world.world->addSoftBody(body.get());
  btDeformableMassSpringForce springs(cube.stiffness.front(), 0, false);
  btDeformableGravityForce gravity(btVector3(0, -cube_gravity, 0));
  world.world->addForce(body.get(), &springs);
  world.world->addForce(body.get(), &gravity);
  const double dt = cube_time / steps, cpu = processor_seconds();
  const Stopwatch wall;
  for (int k = 0; k < steps; ++k) world.world->stepSimulation(dt, 0, dt);
  run.wall = wall.seconds();
  run.cpu = processor_seconds() - cpu;
  run.steps = steps;
  for (int i = 0; i < body->m_nodes.size(); ++i) {
    const btVector3& x = body->m_nodes[i].m_x;
    run.position.emplace_back(x.x(), x.y(), x.z());
  }
  world.world->removeSoftBody(body.get());
  return run;
}

}  // namespace phymul::bench

#else

namespace phymul::bench {

SoftCubeRun run_soft_cube_in_bullet(const Model&, int) {
  SoftCubeRun run;
  run.status = "not_built";
  run.message = "Bullet was not found when the benches were built (Debian: libbullet-dev)";
  return run;
}

}  // namespace phymul::bench

#endif
