"""Checks paths with coal on the original collision meshes of the robot's URDF, against itself and the obstacles.

Usage: meshes.py PROBLEMS PATHS [--jobs N] [--every N] [--distances] [--ends]; PROBLEMS of problems.py, PATHS with a JSON line for each path: set, index,
joints (a list of way points [rad, m], dense or not), and, where there are several of a problem, what. Between way points a path is straight in joint space.

Every pair of bodies is looked at alone: links that move to one another and that the SRDF does not disable, and each link with each
obstacle. A pair at distance d is looked at again before its distance can have changed by more than d, or by 1 mm where d is less: nothing is missed
that lasts longer than 1 mm of motion. The bound on the change is the sum over the joints between both bodies of |change of the joint| times
the largest distance from its axis that a point of the body behind it can have in any posture.
The smallest distance is that of convex hulls where those are more than 1 mm apart, and the least of what was looked at. With `--distances` it
is that of the meshes and exact to 1 mm, for which near pairs are looked at more often.

Meshes are surfaces: a body that is wholly inside another one is not found, but on its way there it is, unless the path begins inside.
Cylinders are cylinders. Prints every path in collision with its pairs, then a JSON line: paths, sampled (looks at a pair), collisions (paths),
at_ends (those of them whose pairs all collide at the start or the goal already, which no planner can help), pairs (paths by name of pair),
smallest [m] and where. Exits with 1 where a path is in collision other than at its ends; with `--ends` wherever one is.
"""

import argparse
import collections
import json
import multiprocessing
import sys
import warnings
import xml.etree.ElementTree as xml

import coal
import numpy as np
import pinocchio as pin

STEP = 1e-3
# Where the boxes around two bodies are farther apart than FAR [m], or their convex hulls than STEP, that distance is enough: it is smaller.
FAR = 2e-2


class Bodies:
    """The links of a robot, and how far every one may move for a change of the joints."""

    def __init__(self, robot):
        self.model = pin.buildModelFromUrdf(robot["urdf"])
        self.data = self.model.createData()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            links = pin.buildGeomFromUrdf(self.model, robot["urdf"], pin.GeometryType.COLLISION, [robot["meshes"]])
        self.links = list(links.geometryObjects)
        self.names = [self.model.frames[link.parentFrame].name for link in self.links]
        given = list(self.model.names)[1:]
        self.order = [self.model.joints[self.model.getJointId(name)].idx_q for name in robot["joints"]]
        if sorted(robot["joints"]) != sorted(given):
            raise SystemExit(f"meshes: {robot['urdf']}: joints {given}, but the problems have {robot['joints']}")
        off = {
            frozenset((pair.get("link1"), pair.get("link2")))
            for pair in xml.parse(robot["srdf"]).getroot().findall("disable_collisions")
        }
        self.pairs = [
            (a, b)
            for a in range(len(self.links))
            for b in range(a + 1, len(self.links))
            if self.links[a].parentJoint != self.links[b].parentJoint and frozenset((self.names[a], self.names[b])) not in off
        ]
        self.reach = [self.reaches(link) for link in self.links]
        self.boxes = [self.box(link) for link in self.links]
        self.hulls = [self.hull(link) for link in self.links]

    @staticmethod
    def hull(link):
        """The convex hull of a mesh; of what is no mesh the shape itself."""
        if not isinstance(link.geometry, coal.BVHModelBase):
            return link.geometry
        link.geometry.buildConvexHull(False, "Qt")
        return link.geometry.convex

    @staticmethod
    def box(link):
        """The box around a link, and its pose in the link's shape."""
        aabb = link.geometry.aabb_local
        return coal.Box(*(aabb.max_ - aabb.min_)), pin.SE3(np.eye(3), (aabb.max_ + aabb.min_) / 2)

    def reaches(self, link):
        """For each joint (by idx_v) the largest distance [m] of a point of the link from the joint's origin; 1 for a prismatic one, 0 for no ancestor."""
        shape = link.geometry
        shape.computeLocalAABB()
        # The largest distance of a point from the origin of the joint that carries the link.
        if isinstance(shape, coal.BVHModelBase):
            points = shape.vertices() if callable(getattr(shape, "vertices", None)) else np.array([shape.vertices(i) for i in range(shape.num_vertices)])
            far = np.linalg.norm(points @ link.placement.rotation.T + link.placement.translation, axis=1).max()
        else:
            far = np.linalg.norm(link.placement.act(shape.aabb_center)) + shape.aabb_radius
        out, joint = np.zeros(self.model.nv), link.parentJoint
        while joint > 0:
            revolute = "R" in self.model.joints[joint].shortname()
            out[self.model.joints[joint].idx_v] = far if revolute else 1.0
            far += np.linalg.norm(self.model.jointPlacements[joint].translation)
            if not revolute:
                limits = self.model.lowerPositionLimit, self.model.upperPositionLimit
                far += max(abs(limit[self.model.joints[joint].idx_q]) for limit in limits)
            joint = self.model.parents[joint]
        return out

    def bound(self, a, b):
        """How much the distance of link a to link b, or to what stands in the world, may change at most [m] by a change of each joint."""
        if b is None:
            return self.reach[a]
        # Joints that carry both bodies move neither to the other. On two branches both motions add.
        mine, other = self.carriers(self.links[a].parentJoint), self.carriers(self.links[b].parentJoint)
        both = mine & other
        on = np.array([i in mine | other and i not in both for i in range(self.model.nv)])
        return np.where(on, self.reach[a] + self.reach[b], 0.0)

    def carriers(self, joint):
        out = set()
        while joint > 0:
            out.add(self.model.joints[joint].idx_v)
            joint = self.model.parents[joint]
        return out

    def positions(self, joints):
        q = pin.neutral(self.model)
        q[self.order] = joints
        return q

    def place(self, q):
        pin.forwardKinematics(self.model, self.data, q)

    def pose(self, link):
        return self.data.oMi[self.links[link].parentJoint] * self.links[link].placement


def transform(pose):
    return coal.Transform3s(pose.rotation, pose.translation)


def obstacles(problem):
    """Names, shapes and poses of a problem's obstacles."""
    out = []
    for kind, shape in (
        ("boxes", lambda o: coal.Box(*(2 * half for half in o["half_extents"]))),
        ("cylinders", lambda o: coal.Cylinder(o["radius"], 2 * o["half_length"])),
        ("spheres", lambda o: coal.Sphere(o["radius"])),
        ("capsules", lambda o: coal.Capsule(o["radius"], 2 * o["half_length"])),
    ):
        for body in problem[kind]:
            R = pin.Quaternion(np.array(body.get("quaternion", [0.0, 0.0, 0.0, 1.0]))).normalized().toRotationMatrix()
            out.append((body.get("name", kind), shape(body), coal.Transform3s(R, np.array(body["center"]))))
    return out


class Check:
    """Of one path: pairs in collision with the place of the first one there, and the smallest distance."""

    def __init__(self, bodies, problem, exact):
        self.bodies, self.problem, self.world, self.exact = bodies, problem, obstacles(problem), exact
        self.request, self.result = coal.DistanceRequest(), coal.DistanceResult()
        self.count, self.smallest, self.near = 0, np.inf, None

    def distance(self, pair):
        """Distance [m] of a pair where the joints are now, or where they are far from one another less than that; 0 or less in collision."""
        a, b = pair
        self.count += 1
        pose = self.bodies.pose(a)
        if isinstance(b, int):
            other = self.bodies.pose(b)
            shape, hull, at = self.bodies.links[b].geometry, self.bodies.hulls[b], transform(other)
            box, to_box = self.bodies.boxes[b]
            around = box, transform(other * to_box)
        else:
            _, shape, at = b
            hull, around = shape, (shape, at)
        box, to_box = self.bodies.boxes[a]
        enough = self.smallest if self.exact else 0.0
        d = self.between(box, transform(pose * to_box), *around)
        if d > max(FAR, enough):
            return d
        d = self.between(self.bodies.hulls[a], transform(pose), hull, at)
        if d <= max(STEP, enough):
            d = self.between(self.bodies.links[a].geometry, transform(pose), shape, at)
        if d < self.smallest:
            self.smallest, self.near = d, self.name(pair)
        return d

    def between(self, *shapes):
        self.result.clear()
        return coal.distance(*shapes, self.request, self.result)

    def name(self, pair):
        a, b = pair
        return f"{self.bodies.names[a]} {self.bodies.names[b] if isinstance(b, int) else b[0]}"

    def run(self, joints):
        points = [self.bodies.positions(point) for point in joints]
        pairs = list(self.bodies.pairs) + [(a, b) for a in range(len(self.bodies.links)) for b in self.world if self.bodies.reach[a].any()]
        found = {}
        self.bodies.place(points[0])
        # What is left of the distance at the last look [m]. Near pairs first: with `exact` they tell how near to look at the others.
        left = {i: self.distance(pair) for i, pair in enumerate(pairs)}
        for i in sorted(left, key=left.get):
            # The first and the last posture count as ends: their collisions are the problem's.
            if left[i] <= 0:
                found[self.name(pairs[i])] = 0.0
        self.bodies.place(points[-1])
        for pair in pairs:
            if self.distance(pair) <= 0:
                found.setdefault(self.name(pair), 1.0)
        for i in sorted(left, key=left.get):
            if self.name(pairs[i]) not in found:
                at = self.follow(pairs[i], points, left[i])
                if at is not None:
                    found[self.name(pairs[i])] = at
        return found

    def follow(self, pair, points, left):
        """Share of the path at which a pair collides first; None where it does not."""
        bounds = np.abs(np.diff(points, axis=0)) @ self.bodies.bound(pair[0], pair[1] if isinstance(pair[1], int) else None)
        # By how much the distance may have changed at each way point.
        changed, now = np.concatenate([[0.0], np.cumsum(bounds)]), 0.0
        while (now := now + self.step(left)) < changed[-1]:
            i = int(np.searchsorted(changed, now, side="right")) - 1
            t = (now - changed[i]) / bounds[i]
            self.bodies.place((1 - t) * points[i] + t * points[i + 1])
            left = self.distance(pair)
            if left <= 0:
                return (i + t) / len(bounds)
        return None

    def step(self, distance):
        """How far the pair may move until the next look [m]."""
        return max(distance - max(self.smallest - STEP, 0.0) if self.exact else distance, STEP)


def check(job):
    """Of a path: its name, the pairs in collision, how many looks it took, and the smallest distance."""
    path, exact = job
    problem = WORLDS[path["set"], path["index"]]
    this = Check(BODIES, problem, exact)
    found = this.run(path["joints"])
    return " ".join(str(path[key]) for key in ("set", "index", "what") if key in path), found, this.count, this.smallest, this.near


def load(file):
    global BODIES, WORLDS
    with open(file) as lines:
        BODIES = Bodies(json.loads(next(lines)))
        WORLDS = {(problem["set"], problem["index"]): problem for problem in map(json.loads, lines)}


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("problems")
    arguments.add_argument("paths")
    arguments.add_argument("--jobs", type=int, default=1)
    arguments.add_argument("--every", type=int, default=1)
    arguments.add_argument("--distances", action="store_true")
    arguments.add_argument("--ends", action="store_true")
    given = arguments.parse_args()
    with open(given.paths) as file:
        jobs = [(json.loads(line), given.distances) for line in list(file)[:: given.every]]
    totals = {"paths": 0, "sampled": 0, "collisions": 0, "at_ends": 0}
    pairs, smallest, where = collections.Counter(), np.inf, None
    with multiprocessing.Pool(given.jobs, load, (given.problems,)) as pool:
        for name, found, count, distance, near in pool.imap(check, jobs):
            totals["paths"] += 1
            totals["sampled"] += count
            if found:
                totals["collisions"] += 1
                totals["at_ends"] += all(share in (0.0, 1.0) for share in found.values())
                pairs.update(found.keys())
                print(f"{name}: " + ", ".join(f"{pair} at {share:.4f}" for pair, share in found.items()))
            elif distance < smallest:
                smallest, where = float(distance), f"{name}: {near}"
    print(json.dumps(totals | {"pairs": dict(pairs.most_common()), "smallest": smallest, "where": where}))
    sys.exit(totals["collisions"] > (0 if given.ends else totals["at_ends"]))


if __name__ == "__main__":
    main()
