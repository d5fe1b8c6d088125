"""A robot as `cargo run -- export-urdf NAME` prints it, in MuJoCo: its tree, and what the comment in its URDF says beside.

    robot = Robot(urdf, "left")
    robot.add(model, model.find("worldbody"))  # an MJCF model, as an xml.etree.ElementTree

Motors are actuators of the model, named ROBOT/JOINT in the order of the robot's joints. Joints have the inertias of
their rotors as `armature`, and their motors' friction. Links that the URDF lets mimic a joint follow it by an equality constraint. Where links form a
closed loop, a `connect` constraint closes it, and a linear actuator is a tendon between the two points that it joins: its length is
the robot's joint. A transmission by which a motor moves several joints is refused.
"""

import math
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

from mujoco_arms import numbers, quaternion, text

# Of constraints: their errors decay within two steps of 0.5 ms; see MuJoCo's solref and solimp.
STIFF = {"solref": "0.001 1", "solimp": "0.99 0.999 0.001 0.5 2"}
# What is only to be seen.
SEEN = {"type": "capsule", "size": "0.025", "mass": "0", "contype": "0", "conaffinity": "0"}


class Robot:
    """A robot of its URDF."""

    def __init__(self, urdf, name):
        self.name = name
        self.root = ElementTree.fromstring(urdf)
        comment = urdf.split("<!--")[1].split("-->")[0]
        self.loops = Loops(comment) if "Closed loops" in comment else None
        self.ratios = self._ratios(comment)
        # Of each motor: rotor's inertia [kg m²], viscous [N m s] and Coulomb friction [N m], lasting torque [N m].
        motor = r"motor \d+: (\S+) kg m2, (\S+) N m s, (\S+) N m, (\S+) N m;"
        self.motors = [[float(x) for x in motor] for motor in re.findall(motor, comment)]
        joints = [joint for joint in self.root.findall("joint") if joint.get("type") != "fixed"]
        self.mimics = [joint for joint in joints if joint.find("mimic") is not None]
        passive = self.loops.passive if self.loops else ()
        self.moved = [joint for joint in joints if joint not in self.mimics and joint.get("name") not in passive]
        if self.loops:
            names = [joint.get("name") for joint in self.moved]
            self.joints = [names.index(own) if own in names else own for own in self.loops.joints]
        else:
            self.joints = list(range(len(self.moved)))

    def _ratios(self, comment):
        rows = re.search(r"row by row:\n((?:\s+-?\d[^\n]*\n)+)", comment).group(1)
        ratios = np.array([numbers(row) for row in rows.strip().splitlines()])
        if np.abs(ratios - np.diag(np.diag(ratios))).max() > 0:
            raise SystemExit(f"{self.name}: a motor moves several joints, for which this model has no word")
        return np.diag(ratios)

    def full(self, name):
        return f"{self.name}/{name}"

    def add(self, model, onto):
        """Its bodies onto the body `onto`, which is its world; its joints' constraints and actuators into `model`."""
        parts = {child: part(model, child) for child in ("equality", "actuator", "tendon")}
        below = {}
        for joint in self.root.findall("joint"):
            below.setdefault(joint.find("parent").get("link"), []).append(joint)
        links = {link.get("name"): link for link in self.root.findall("link")}
        self._add(onto, below, links, "world")
        for joint in self.mimics:
            mimic = joint.find("mimic")
            polynomial = f"{mimic.get('offset')} {mimic.get('multiplier')} 0 0 0"
            ElementTree.SubElement(
                parts["equality"], "joint", STIFF, joint1=self.full(joint.get("name")), joint2=self.full(mimic.get("joint")), polycoef=polynomial
            )
        if self.loops:
            self.loops.add(self, model, parts)
        for i, joint in enumerate(self.joints):
            if isinstance(joint, int):
                name = self.full(self.moved[joint].get("name"))
                ElementTree.SubElement(parts["actuator"], "motor", name=name, joint=name)
            else:
                ElementTree.SubElement(parts["actuator"], "motor", name=self.full(joint), tendon=self.full(joint))

    def actuators(self):
        """Their names, in the order of the robot's joints."""
        return [self.full(self.moved[j].get("name") if isinstance(j, int) else j) for j in self.joints]

    def felt(self, i):
        """What joint `i` feels of its motor: the rotor's inertia, and friction."""
        rotor, viscous, coulomb, _ = self.motors[i]
        ratio = abs(self.ratios[i])
        of = {"armature": rotor / ratio**2, "damping": viscous / ratio**2, "frictionloss": coulomb / ratio}
        return {key: repr(float(value)) for key, value in of.items()}

    def effort(self, i):
        """What its motor gives joint `i` lastingly [N m or N]."""
        return self.motors[i][3] / abs(self.ratios[i])

    def _add(self, onto, below, links, link):
        for joint in below.get(link, ()):
            child, origin, kind = joint.find("child").get("link"), joint.find("origin"), joint.get("type")
            body = ElementTree.SubElement(
                onto,
                "body",
                name=self.full(child),
                pos=origin.get("xyz"),
                quat=text(quaternion(numbers(origin.get("rpy")))),
            )
            if kind != "fixed":
                self._add_joint(body, joint, kind)
            inertial = links[child].find("inertial")
            if inertial is not None:
                tensor = inertial.find("inertia")
                ElementTree.SubElement(
                    body,
                    "inertial",
                    pos=inertial.find("origin").get("xyz"),
                    mass=inertial.find("mass").get("value"),
                    fullinertia=" ".join(tensor.get(key) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")),
                )
            self._draw(body, below.get(child, ()))
            self._add(body, below, links, child)

    def _add_joint(self, body, joint, kind):
        ElementTree.SubElement(
            body,
            "joint",
            self.felt(self.joints.index(self.moved.index(joint))) if joint in self.moved else {},
            name=self.full(joint.get("name")),
            type="slide" if kind == "prismatic" else "hinge",
            axis=joint.find("axis").get("xyz"),
        )

    @staticmethod
    def _draw(body, joints):
        """What is to be seen of a link: capsules to the links after it, that weigh and touch nothing."""
        for joint in joints:
            to = numbers(joint.find("origin").get("xyz"))
            if math.hypot(*to) > 0.02:
                ElementTree.SubElement(body, "geom", SEEN, fromto=text([0, 0, 0, *to]))

    def place(self, model, data, joints):
        """Lets it stand with its joints there."""
        values = [None if isinstance(j, str) else joints[i] for i, j in enumerate(self.joints)]
        for i, j in enumerate(self.joints):
            if isinstance(j, int):
                self._set(data, self.moved[j].get("name"), values[i])
        for joint in self.mimics:
            mimic = joint.find("mimic")
            leader = data.joint(self.full(mimic.get("joint"))).qpos[0]
            self._set(data, joint.get("name"), float(mimic.get("offset")) + float(mimic.get("multiplier")) * leader)
        if self.loops:
            lengths = {own: joints[i] for i, own in enumerate(self.loops.joints) if own in self.loops.actuators}
            for name, angle in self.loops.assembled(self.root, lengths).items():
                self._set(data, name, angle)

    def _set(self, data, joint, value):
        data.joint(self.full(joint)).qpos[0] = value
        data.joint(self.full(joint)).qvel[0] = 0.0


class Loops:
    """The closed loops of RNT, as the comment in its URDF tells them."""

    def __init__(self, comment):
        told = comment.split("Closed loops")[1].split("Transmission")[0]
        point = r"\(([^()]+)\) of `(\w+)`"
        found = [(np.array(numbers(at)), link) for at, link in re.findall(point, told)]
        self.cut, pairs = found[:2], found[2:]
        self.actuators = {f"q{number}": pairs[2 * i : 2 * i + 2] for i, number in enumerate(re.findall(r"actuator (\d)", told))}
        listed = re.search(r"The robot's joints are (.*?)\. ([^.]*?)have no motor", told, re.DOTALL)
        own = re.findall(r"(q\d)(?: \(`(\w+)`\))?", listed.group(1))
        self.joints = [name or number for number, name in own]
        self.passive = re.findall(r"`(\w+)`", listed.group(2))

    def add(self, robot, model, parts):
        """A point of one link is held at a point of another; tendons in place of the actuators."""
        bodies = {body.get("name"): body for body in model.iter("body")}
        sites = []
        for i, (at, link) in enumerate([self.cut[0], self.cut[1]] + [end for ends in self.actuators.values() for end in ends]):
            sites.append(robot.full(f"loop {i}"))
            ElementTree.SubElement(bodies[robot.full(link)], "site", name=sites[-1], pos=text(at), size="0.012")
        ElementTree.SubElement(parts["equality"], "connect", STIFF, site1=sites[0], site2=sites[1])
        for at, link in self.cut:
            ElementTree.SubElement(bodies[robot.full(link)], "geom", SEEN, fromto=text([0, 0, 0, *at]))
        for i, name in enumerate(self.actuators):
            number = self.joints.index(name)
            tendon = ElementTree.SubElement(parts["tendon"], "spatial", robot.felt(number), name=robot.full(name), width="0.012")
            for site in sites[2 + 2 * i : 4 + 2 * i]:
                ElementTree.SubElement(tendon, "site", site=site)

    def assembled(self, root, lengths):
        """The angles of the joints without motors at these lengths of the actuators, by laws of cosines."""
        at = lambda name: np.array(numbers(root.find(f"joint[@name='{name}']/origin").get("xyz")))
        shoulder, elbow = at("upper_arm"), at("forearm")[0]
        (foot2, crank), (foot3, rocker) = ((ends[0][0], ends[1][0][0]) for ends in self.actuators.values())
        rod, tail = self.cut[0][0][0], self.cut[1][0][0]

        def angle(foot, length, arm):
            way = foot - shoulder
            distance = np.linalg.norm(way)
            turned = np.arccos((distance**2 + arm**2 - length**2) / (2 * distance * arm))
            return np.arctan2(way[2], way[0]), turned

        (below, turned), (behind, folded) = angle(foot2, lengths["q2"], crank), angle(foot3, lengths["q3"], rocker)
        upper, back = below + turned, behind - folded
        end = rocker * np.exp(1j * back)
        # The rod meets the forearm's tail to the left of the line from the rocker's end to the elbow.
        joint = elbow * np.exp(1j * upper)
        way = joint - end
        along = (abs(way) ** 2 + rod**2 - tail**2) / (2 * abs(way))
        reach = way / abs(way) * (along + 1j * np.sqrt(rod**2 - along**2))
        forearm = (end + reach - joint) / tail
        directions = [np.exp(1j * back), reach / np.exp(1j * back), np.exp(1j * upper), forearm / np.exp(1j * upper)]
        return dict(zip(("rocker", "rod", "upper_arm", "forearm"), np.angle(directions)))


def part(model, name):
    """A part of an MJCF model, made where there is none yet."""
    found = model.find(name)
    return ElementTree.SubElement(model, name) if found is None else found
