"""Compares the normal forces on the feet of a walk with MuJoCo's, on a model of the same machine and the same steps.

Usage: compare.py FOLDER, with what `cargo run -p legs --example forces` wrote there.

MuJoCo simulates the whole machine: a free trunk, twelve links with their masses, a pad on a ball joint at each shank, the treads as
boxes. Its joints are servoed to the joint positions that the walk had. It knows nothing of the forces there.

While three feet stand: the mean of each foot's normal force from 0.1 s after the lift to the landing must agree within 5 % of its mean; the root
of the mean square of the difference is told, too. While four stand, they are not determined by statics: the means of their sum (5 %) and of the
centre of pressure (15 mm, 2.5 % of the feet's distance) must agree: a short stance is full of the rocking of a landing. Exits with 1 where anything falls short.
"""

import csv
import pathlib
import sys

import mujoco
import numpy as np

NAMES = ["lf", "rf", "lh", "rh"]
STEP = 2.5e-4
SHARE, OFF = 0.05, 1.5e-2


def table(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def model(figures, ground, start):
    """The machine on the treads, as MJCF."""
    f = figures
    boxes = []
    for i, tread in enumerate(ground):
        a, b, height = float(tread["from"]), float(tread["to"]), float(tread["height"])
        y = 0.5 * int(tread["side"])
        boxes.append(f'<geom name="tread{i}" type="box" size="{(b - a) / 2} 0.5 0.5" pos="{(a + b) / 2} {y} {height - 0.5}"/>')
    legs, motors = [], []
    for i, name in enumerate(NAMES):
        side = 1 if i % 2 == 0 else -1
        x = f["hip_x"] if i < 2 else -f["hip_x"]
        rod = [m * l * l / 12 for m, l in ((f["thigh_mass"], f["thigh"]), (f["shank_mass"], f["shank"]))]
        legs.append(f'''
<body name="{name}_hip" pos="{x} {side * f["hip_y"]} 0">
 <joint name="{name}0" axis="1 0 0" armature="0.4"/>
 <inertial pos="0 {side * f["centre_hip"]} 0" mass="{f["hip_mass"]}" diaginertia="8e-4 8e-4 8e-4"/>
 <body pos="0 {side * f["aside"]} 0">
  <joint name="{name}1" axis="0 1 0" armature="0.4"/>
  <inertial pos="0 0 {-f["centre_thigh"]}" mass="{f["thigh_mass"]}" diaginertia="{rod[0]} {rod[0]} 4e-4"/>
  <body pos="0 0 {-f["thigh"]}">
   <joint name="{name}2" axis="0 1 0" armature="0.4"/>
   <inertial pos="0 0 {-f["centre_shank"]}" mass="{f["shank_mass"]}" diaginertia="{rod[1]} {rod[1]} 4e-4"/>
   <body pos="0 0 {-f["shank"]}">
    <joint name="{name}f" type="ball" damping="0.01" armature="1e-3"/>
    <inertial pos="0 0 0" mass="0.001" diaginertia="1e-5 1e-5 1e-5"/>
    <geom name="{name}" type="sphere" size="{f["radius"]}"/>
   </body>
  </body>
 </body>
</body>''')
        for j in range(3):
            motors.append(f'<position joint="{name}{j}" kp="60000" kv="600"/>')
    at = " ".join(start[k] for k in ("x", "y", "z"))
    turn = " ".join(start[k] for k in ("qw", "qx", "qy", "qz"))
    box = [f["trunk_x"], f["trunk_y"], f["trunk_z"]]
    inertia = [f["trunk_mass"] / 12 * (sum(e * e for e in box) - box[i] ** 2) for i in range(3)]
    # A pad does not roll on the ground: condim 6 holds it by friction of rolling. Direct stiffness and damping of a contact.
    return f'''<mujoco>
<option timestep="{STEP}" gravity="0 0 -9.80665" integrator="implicitfast" cone="elliptic"/>
<default><geom condim="6" friction="{f["friction"]} 0.1 0.1" solref="-{f["stiffness"]} -400" solimp="0.95 0.95 0.001"/></default>
<worldbody>
{"".join(boxes)}
<body name="trunk" pos="{at}" quat="{turn}">
 <freejoint/>
 <inertial pos="0 0 0" mass="{f["trunk_mass"]}" diaginertia="{inertia[0]} {inertia[1]} {inertia[2]}"/>
{"".join(legs)}
</body>
</worldbody>
<actuator>{"".join(motors)}</actuator>
</mujoco>'''


def simulated(folder):
    """Times, the walk's forces, MuJoCo's forces and where its feet were."""
    figures = {row["name"]: float(row["value"]) for row in table(folder / "figures.csv")}
    walk = table(folder / "walk.csv")
    m = mujoco.MjModel.from_xml_string(model(figures, table(folder / "ground.csv"), walk[0]))
    d = mujoco.MjData(m)
    q = np.array([[float(row[f"{name}{j}"]) for name in NAMES for j in range(3)] for row in walk])
    time = np.array([float(row["time"]) for row in walk])
    told = np.array([[float(row[f"n_{name}"]) for name in NAMES] for row in walk])
    joints = [m.joint(f"{name}{j}").qposadr[0] for name in NAMES for j in range(3)]
    d.qpos[joints] = q[0]
    geoms = {m.geom(name).id: i for i, name in enumerate(NAMES)}
    forces, feet = np.zeros_like(told), np.zeros((len(time), 4, 2))
    count = round((time[1] - time[0]) / STEP)
    wrench = np.zeros(6)
    for row in range(len(time)):
        before = q[max(row - 1, 0)]
        for k in range(count):
            d.ctrl[:] = before + (q[row] - before) * (k + 1) / count
            mujoco.mj_step(m, d)
            for c in range(d.ncon):
                contact = d.contact[c]
                leg = geoms.get(contact.geom2, geoms.get(contact.geom1))
                mujoco.mj_contactForce(m, d, c, wrench)
                # Along the contact's normal, turned into the world.
                up = contact.frame.reshape(3, 3).T @ wrench[:3]
                forces[row, leg] += abs(up[2]) / count
        feet[row] = [d.geom(name).xpos[:2] for name in NAMES]
    return time, told, forces, feet


def windows(time, told):
    """Intervals in which one leg is in the air for 0.2 s or more: the leg, first and last row."""
    air = told < 1.0
    found = []
    for leg in range(4):
        edges = np.flatnonzero(np.diff(np.concatenate(([0], air[:, leg].astype(int), [0]))))
        for a, b in zip(edges[::2], edges[1::2]):
            if time[min(b, len(time)) - 1] - time[a] > 0.2:
                found.append((leg, a, b))
    return sorted(found, key=lambda each: each[1])


def main():
    time, told, forces, feet = simulated(pathlib.Path(sys.argv[1]))
    rate = round(0.1 / (time[1] - time[0]))
    bad, worst, worst_rms, sums, pressed, ends = 0, 0.0, 0.0, 0.0, 0.0, 0
    swings = windows(time, told)
    for leg, a, b in swings:
        a += rate
        b -= rate // 4
        others = [i for i in range(4) if i != leg]
        ours, theirs = told[a:b, others].mean(axis=0), forces[a:b, others].mean(axis=0)
        error = np.abs(ours - theirs) / theirs
        rms = np.sqrt(((told[a:b, others] - forces[a:b, others]) ** 2).mean(axis=0)) / theirs
        worst, worst_rms = max(worst, error.max()), max(worst_rms, rms.max())
        if error.max() > SHARE:
            bad += 1
            print(f"{NAMES[leg]} in the air at {time[a]:.2f} s: ours {ours.round(1)} N, MuJoCo's {theirs.round(1)} N")
    stances = [(b + rate // 2, c - rate // 2) for (_, _, b), (_, c, _) in zip(swings, swings[1:]) if c - b > 2 * rate]
    for a, b in stances:
        ours, theirs = told[a:b].sum(axis=1).mean(), forces[a:b].sum(axis=1).mean()
        sums = max(sums, abs(ours - theirs) / theirs)
        at = [(n[:, :, None] * feet[a:b]).sum(axis=1) / n.sum(axis=1)[:, None] for n in (told[a:b], forces[a:b])]
        off = np.linalg.norm(at[0].mean(axis=0) - at[1].mean(axis=0))
        pressed = max(pressed, off)
        if abs(ours - theirs) > SHARE * theirs or off > OFF:
            bad += 1
            print(f"on four feet at {time[a]:.2f} s: {ours:.1f} N and {theirs:.1f} N, centres {1e3 * off:.1f} mm apart")
    print(f"{len(swings)} three-legged stances: each foot's mean force within {100 * worst:.2f} %, rms of the difference {100 * worst_rms:.1f} %")
    print(f"{len(stances)} four-legged stances: sums within {100 * sums:.2f} %, centres of pressure within {1e3 * pressed:.2f} mm")
    if not swings or not stances:
        sys.exit("there is nothing to compare")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
