// What the 3D picture shows beside the links: their meshes, wrenches as arrows, the cell's frames, and the nearest pair of links.
//
// In: places in metres, wrenches in N and N m, in the axes of the tool. Out: objects of the picture, and texts beside them.

import {
  AxesHelper, BufferAttribute, BufferGeometry, ConeGeometry, CylinderGeometry, Group, Line, LineBasicMaterial, Mesh, MeshLambertMaterial,
  Quaternion, Vector3,
} from 'three';

const UP = new Vector3(0, 1, 0);
const SHAFT = new CylinderGeometry(1, 1, 1, 12, 1), TIP = new ConeGeometry(1, 1, 16);
/** What is less is not drawn [N, N m]; how long an arrow of one is [m]; how long an arrow is at most [m]. */
const ARROWS = { force: { least: 0.5, each: 0.005, most: 0.5, colour: '#d55e00' }, torque: { least: 0.05, each: 0.05, most: 0.5, colour: '#6a51a3' } };

const turn = new Quaternion();
export function pose6(object, [x, y, z, ...rotation]) {
  object.position.set(x, y, z);
  object.quaternion.copy(turn.set(...rotation));
}

/** A pose x, y, z, and a quaternion, as it is seen from another one. */
export function seenFrom(frame, pose) {
  const back = new Quaternion(...frame.slice(3)).invert();
  const from = new Vector3(...pose.slice(0, 3)).sub(new Vector3(...frame.slice(0, 3))).applyQuaternion(back);
  return [...from.toArray(), ...back.multiply(new Quaternion(...pose.slice(3))).toArray()];
}

/** The triangles of a mesh, given in hundredths of a millimetre. */
export function triangles(corners) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(Float32Array.from(corners, (x) => x * 1e-5), 3));
  geometry.computeVertexNormals();
  return geometry;
}

class Arrow {
  constructor({ least, each, most, colour }) {
    Object.assign(this, { least, each, most });
    const material = new MeshLambertMaterial({ color: colour, emissive: colour, emissiveIntensity: 0.35 });
    this.group = new Group();
    this.parts = [new Mesh(SHAFT, material), new Mesh(TIP, material)];
    this.group.add(...this.parts);
    this.group.visible = false;
  }

  /** A vector at a pose, in its axes; how large it is, or 0 if it is not drawn. */
  place(pose, vector) {
    const size = vector.every((x) => x !== null) ? Math.hypot(...vector) : 0;
    this.group.visible = size >= this.least;
    if (!this.group.visible) return 0;
    const length = Math.min(this.most, this.each * size), [shaft, tip] = this.parts, head = Math.min(0.05, 0.5 * length);
    const direction = new Vector3(...vector).divideScalar(size).applyQuaternion(turn.set(...pose.slice(3)));
    this.group.position.set(...pose.slice(0, 3));
    this.group.quaternion.setFromUnitVectors(UP, direction);
    shaft.scale.set(0.007, length - head, 0.007);
    shaft.position.set(0, 0.5 * (length - head), 0);
    tip.scale.set(0.02, head, 0.02);
    tip.position.set(0, length - 0.5 * head, 0);
    this.end = direction.multiplyScalar(length).add(this.group.position);
    return size;
  }
}

/** The wrench that a sensor reads, at the tool of its robot. */
export class WrenchArrows {
  constructor(name) {
    this.name = name;
    this.force = new Arrow(ARROWS.force);
    this.torque = new Arrow(ARROWS.torque);
    this.group = new Group();
    this.group.add(this.force.group, this.torque.group);
    this.label = document.createElement('span');
    this.label.hidden = true;
    this.newtons = 0;
  }

  /** At the tool's pose in the world. */
  place(tool, reading) {
    const there = Boolean(tool && reading);
    const force = there ? this.force.place(tool, reading.slice(0, 3)) : 0, torque = there ? this.torque.place(tool, reading.slice(3, 6)) : 0;
    this.group.visible = there;
    this.newtons = force;
    const texts = [force && `${force.toFixed(1)} N`, torque && `${torque.toFixed(2)} N m`].filter(Boolean);
    this.label.textContent = texts.join(' · ');
    this.at = force ? this.force.end : torque ? this.torque.end : null;
  }
}

/** A frame of the cell, with its name. */
export function placeMark(name, pose) {
  const axes = new AxesHelper(0.2), label = document.createElement('span');
  axes.material.depthTest = false;
  axes.renderOrder = 1;
  pose6(axes, pose);
  label.textContent = name;
  label.hidden = true;
  return { axes, label };
}

/** Where two segments are nearest, each from a to b: the points, and how far they are apart. */
export function nearestOfSegments(a, b, c, d) {
  const sub = (p, q) => p.map((x, i) => x - q[i]), dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const along = (p, v, s) => p.map((x, i) => x + s * v[i]), clamp = (x) => Math.min(1, Math.max(0, x));
  const u = sub(b, a), v = sub(d, c), w = sub(a, c);
  const uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w), parts = uu * vv - uv * uv;
  // Parallel ones are as near at any point: then the first end decides.
  let s = parts > 1e-12 ? clamp((uv * vw - vv * uw) / parts) : 0, t = vv > 1e-12 ? (uv * s + vw) / vv : 0;
  if (t < 0 || t > 1) {
    t = clamp(t);
    s = uu > 1e-12 ? clamp((uv * t - uw) / uu) : 0;
  }
  const points = [along(a, u, s), along(c, v, t)];
  return { points, apart: Math.hypot(...sub(...points)) };
}

/** The nearest links of two robots of which none carries the other; `null` if there are none. */
export function nearestLinks(robots) {
  let nearest = null;
  robots.forEach((one, i) => robots.slice(i + 1).forEach((other) => {
    if (one.on === other.name || other.on === one.name) return;
    for (const a of one.links) {
      for (const b of other.links) {
        const { points, apart } = nearestOfSegments(a.slice(0, 3), a.slice(3, 6), b.slice(0, 3), b.slice(3, 6));
        const free = apart - a[6] - b[6];
        if (!nearest || free < nearest.free) nearest = { points, free, of: [one.name, other.name], radii: [a[6], b[6]], apart };
      }
    }
  }));
  return nearest;
}

/** The line between the nearest links. */
export class NearestLine {
  constructor(colour) {
    this.geometry = new BufferGeometry();
    this.geometry.setAttribute('position', new BufferAttribute(new Float32Array(6), 3));
    this.line = new Line(this.geometry, new LineBasicMaterial({ color: colour, depthTest: false }));
    this.line.renderOrder = 2;
    this.line.frustumCulled = false;
    this.line.visible = false;
    this.label = document.createElement('span');
    this.label.hidden = true;
  }

  show(nearest) {
    this.line.visible = Boolean(nearest) && nearest.free > 0;
    this.at = null;
    if (!this.line.visible) return;
    const [a, b] = nearest.points.map((point) => new Vector3(...point)), direction = b.clone().sub(a).normalize();
    // From surface to surface.
    a.addScaledVector(direction, nearest.radii[0]);
    b.addScaledVector(direction, -nearest.radii[1]);
    const places = this.geometry.getAttribute('position');
    places.setXYZ(0, ...a.toArray());
    places.setXYZ(1, ...b.toArray());
    places.needsUpdate = true;
    this.at = a.add(b).multiplyScalar(0.5);
    this.label.textContent = `${Math.round(1000 * nearest.free)} mm apart`;
  }
}
