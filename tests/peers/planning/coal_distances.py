"""Times coal's distance queries between two arms of one kind, each link of one with each of the other.

Usage: coal_distances.py COVERS [--rounds N]; COVERS is a JSON file:

- urdf, joints: the arm, and its joints in the order of the postures
- bases: poses of the two arms' root links in the world, each [x, y, z, qx, qy, qz, qw] [m]
- zero: true where shapes are not in the frames of their links, but in that of the root link with all joints at 0
- links: a list of {link, spheres: [[x, y, z, radius], ..], capsules: [[ax, ay, az, bx, by, bz, radius], ..]} [m] in the frame of the link of that name
- postures: a list of pairs of joint values [[..], [..]] [rad], the first arm's first

Pinocchio computes where the links are, which is not timed. coal_distances.cc, compiled here against coal's own headers (g++ -O3; the distances are in its library as it comes), then asks
on one thread and prints its JSON line: per posture pair, best of N rounds (20) [ns]: `placing` of all shapes (part of all the others),
`all_shapes` (coal::distance of every shape with every one), `link_trees` (the same least distances of links by a dynamic AABB tree over each
link's shapes) and `arm_trees` (one tree over each arm, only the least distance of all). `sum` is the sum of the distances found, 0 for those that
overlap [m].
"""

import argparse
import json
import pathlib
import subprocess
import sys
import sysconfig

import numpy as np
import pinocchio as pin

HERE = pathlib.Path(__file__).parent


def poses(covers):
    """For each posture pair the poses of all links of both arms."""
    model = pin.buildModelFromUrdf(covers["urdf"])
    data = model.createData()
    frames = [model.getFrameId(link["link"]) for link in covers["links"]]
    order = [model.joints[model.getJointId(name)].idx_q for name in covers["joints"]]
    bases = [pin.XYZQUATToSE3(np.array(base, float)) for base in covers["bases"]]
    for pair in covers["postures"]:
        out = []
        for base, joints in zip(bases, pair):
            q = pin.neutral(model)
            q[order] = joints
            pin.framesForwardKinematics(model, data, q)
            out += [pin.SE3ToXYZQUAT(base * data.oMf[frame]) for frame in frames]
        yield out


def places_at_zero(covers):
    """Where each link is with all joints at 0, or nowhere else than its shapes."""
    if not covers.get("zero"):
        return [pin.SE3.Identity() for _ in covers["links"]]
    model = pin.buildModelFromUrdf(covers["urdf"])
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    return [data.oMf[model.getFrameId(link["link"])].copy() for link in covers["links"]]


def words(covers):
    links = covers["links"]
    yield [len(links)]
    for link, place in zip(links, places_at_zero(covers)):
        shapes = [[*s[:3], *s[:3], s[3]] for s in link.get("spheres", [])] + link.get("capsules", [])
        yield [len(shapes)]
        for *ends, radius in shapes:
            ends = [place.actInv(np.array(end)) for end in (ends[:3], ends[3:])]
            yield [*ends[0], *ends[1], radius]
    yield [len(covers["postures"])]
    for posture in poses(covers):
        yield from posture


def compiled():
    prefix = pathlib.Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix"
    program = pathlib.Path(sys.prefix) / "coal_distances"
    source = HERE / "coal_distances.cc"
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        includes = [f"-isystem{prefix / folder}" for folder in ("include", "include/eigen3")]
        libraries = [f"-L{prefix / 'lib'}", f"-Wl,-rpath,{prefix / 'lib'}", "-lcoal"]
        subprocess.run(["g++", "-std=c++17", "-O3", *includes, source, "-o", program, *libraries], check=True)
    return program


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("covers")
    arguments.add_argument("--rounds", type=int, default=20)
    given = arguments.parse_args()
    with open(given.covers) as file:
        covers = json.load(file)
    text = "\n".join(" ".join(repr(float(x)) for x in line) for line in words(covers))
    sys.exit(subprocess.run([compiled(), str(given.rounds)], input=text, text=True).returncode)


if __name__ == "__main__":
    main()
