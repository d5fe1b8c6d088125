// The cell in 3D.
//
// In: where links, frames, tools, bodies and obstacles are, in metres, z up. Out: a picture, drawn when something has changed and not otherwise.

import {
  AmbientLight, AxesHelper, Box3, BoxGeometry, BufferAttribute, BufferGeometry, Color, CylinderGeometry, DirectionalLight, DynamicDrawUsage,
  GridHelper, Group, HemisphereLight, Line, LineBasicMaterial, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene,
  SphereGeometry, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { clear, standing } from './standing.js';
import { NearestLine, WrenchArrows, nearestLinks, placeMark, pose6, triangles } from './shown.js';

/** Colours of robots in their order; colour-blind people tell them apart, too. */
export const COLOURS = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00'];
const UP = new Vector3(0, 1, 0);
const BALL = new SphereGeometry(1, 28, 18);
const ROD = new CylinderGeometry(1, 1, 1, 28, 1, true);
const BLOCK = new BoxGeometry(1, 1, 1);
const FADE = [new Color('#3b4cc0'), new Color('#8fb1fe'), new Color('#f7b89c'), new Color('#b40426')];
/** Points of a tool's path: a minute at twenty a second. */
const POINTS = 1200;

/** A link: a rod with a ball at each end. */
class Capsule {
  constructor(material) {
    this.parts = [new Mesh(ROD, material), new Mesh(BALL, material), new Mesh(BALL, material)];
  }

  place([ax, ay, az, bx, by, bz, radius]) {
    const [rod, a, b] = this.parts;
    const from = new Vector3(ax, ay, az), direction = new Vector3(bx - ax, by - ay, bz - az), length = direction.length();
    a.position.copy(from);
    b.position.set(bx, by, bz);
    a.scale.setScalar(radius);
    b.scale.setScalar(radius);
    rod.visible = length > 1e-6;
    if (rod.visible) {
      rod.position.copy(from).addScaledVector(direction, 0.5);
      rod.quaternion.setFromUnitVectors(UP, direction.divideScalar(length));
      rod.scale.set(radius, length, radius);
    }
  }
}

/** The path of a tool, coloured by its speed. */
class Path {
  constructor() {
    this.geometry = new BufferGeometry();
    this.places = new BufferAttribute(new Float32Array(3 * POINTS), 3).setUsage(DynamicDrawUsage);
    this.colours = new BufferAttribute(new Float32Array(3 * POINTS), 3).setUsage(DynamicDrawUsage);
    this.geometry.setAttribute('position', this.places);
    this.geometry.setAttribute('color', this.colours);
    this.line = new Line(this.geometry, new LineBasicMaterial({ vertexColors: true, linewidth: 2 }));
    this.line.frustumCulled = false;
    this.points = [];
    this.draw(1);
  }

  add(point, speed) {
    this.points.push([...point, speed]);
    if (this.points.length > POINTS) this.points.shift();
  }

  draw(fastest) {
    const colour = new Color();
    this.points.forEach(([x, y, z, speed], i) => {
      this.places.setXYZ(i, x, y, z);
      const at = Math.min(0.999, speed / fastest) * (FADE.length - 1), low = Math.floor(at);
      colour.lerpColors(FADE[low], FADE[low + 1], at - low);
      this.colours.setXYZ(i, colour.r, colour.g, colour.b);
    });
    this.geometry.setDrawRange(0, this.points.length);
    this.places.needsUpdate = true;
    this.colours.needsUpdate = true;
  }
}

/** Whether pictures are drawn by the processor. */
function isSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2'), about = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = about ? gl.getParameter(about.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class CellScene {
  constructor(canvas, labels) {
    this.canvas = canvas;
    this.labels = labels;
    // Where the processor draws, smooth edges cost more than all else.
    this.renderer = new WebGLRenderer({ canvas, antialias: !isSoftware(), alpha: true });
    this.camera = new PerspectiveCamera(40, 1, 0.02, 200);
    this.camera.up.set(0, 0, 1);
    this.scene = new Scene();
    this.scene.add(new HemisphereLight('#ffffff', '#8c98a4', 1.9), new AmbientLight('#ffffff', 0.35));
    const sun = new DirectionalLight('#ffffff', 1.5);
    sun.position.set(2, -3, 5);
    this.scene.add(sun);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.wake());
    this.robots = new Map();
    this.bodies = [];
    this.standing = new Group();
    this.wrenches = [];
    this.places = [];
    this.geometries = [];
    this.nearest = new NearestLine('#d55e00');
    this.scene.add(this.nearest.line);
    this.showsFrames = false;
    this.showsNearest = false;
    this.showsPath = true;
    this.fitted = false;
    this.fastest = 0.1;
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.theme();
    this.resize();
  }

  /** The cell is made of this. */
  build(layout) {
    this.robots.forEach(({ group }) => this.scene.remove(group));
    this.bodies.forEach((body) => this.scene.remove(body));
    this.scene.remove(this.standing);
    clear(this.standing);
    this.standing = standing(layout.obstacles);
    this.scene.add(this.standing);
    this.robots.clear();
    [...this.wrenches, ...this.places].forEach(({ group, axes }) => this.scene.remove(group ?? axes));
    this.geometries.forEach((geometry) => geometry?.dispose());
    this.geometries = [];
    this.labels.replaceChildren(this.nearest.label);
    layout.robots.forEach((robot, i) => {
      const colour = new Color(COLOURS[i % COLOURS.length]);
      const group = new Group(), path = new Path(), label = document.createElement('span');
      label.textContent = robot.name;
      this.labels.append(label);
      group.add(path.line);
      this.scene.add(group);
      const dark = colour.clone().lerp(new Color('#20262d'), 0.25);
      const materials = [colour, dark].map((color) => new MeshLambertMaterial({ color }));
      // Where it is demanded: seen through, so that what is measured stays in sight.
      const through = new MeshLambertMaterial({ color: colour, transparent: true, opacity: 0.3, depthWrite: false });
      const tool = new Mesh(BALL, new MeshLambertMaterial({ color: '#ff00c8', emissive: '#ff00c8', emissiveIntensity: 0.7 }));
      tool.scale.setScalar(0.012);
      tool.visible = false;
      const bar = new Capsule(new MeshLambertMaterial({ color: '#8a939c' }));
      const axes = new AxesHelper(0.12);
      bar.parts.forEach((part) => { part.visible = false; });
      group.add(tool, axes, ...bar.parts);
      const meshes = robot.meshes.map(({ mesh, frame, pose }) => {
        const on = new Group(), shape = new Mesh(undefined, materials[frame % 2]);
        pose6(shape, pose);
        on.add(shape);
        on.visible = false;
        group.add(on);
        return { mesh, frame, on, shape };
      });
      this.robots.set(robot.name, { group, path, label, materials, through, tool, bar, axes, meshes, on: robot.on, links: [], ghost: [], frames: [], at: null });
    });
    // A wrench is shown at the tool of the robot that its sensor belongs to.
    this.wrenches = layout.sensors.flatMap((sensor, place) => {
      if (!sensor.wrench || !sensor.of) return [];
      const arrows = new WrenchArrows(sensor.name);
      this.scene.add(arrows.group);
      this.labels.append(arrows.label);
      return [Object.assign(arrows, { of: sensor.of, sensor: place })];
    });
    this.places = layout.frames.map((name, i) => {
      const mark = placeMark(name, layout.places[i]);
      mark.axes.visible = false;
      this.scene.add(mark.axes);
      this.labels.append(mark.label);
      return mark;
    });
    const grey = new MeshLambertMaterial({ color: '#9aa4ae' });
    this.bodies = layout.bodies.map(({ edges }) => {
      const body = new Mesh(BLOCK, grey);
      body.scale.set(...edges);
      body.visible = false;
      this.scene.add(body);
      return body;
    });
    this.fitted = false;
  }

  /** The triangles of a mesh have come. */
  mesh({ mesh, corners }) {
    const geometry = triangles(corners);
    this.geometries[mesh] = geometry;
    this.robots.forEach(({ meshes }) => meshes.filter((known) => known.mesh === mesh).forEach(({ shape }) => { shape.geometry = geometry; }));
    this.wake();
  }

  /** The cell is like this now. */
  show(state, continues) {
    for (const robot of state.robots) {
      const shown = this.robots.get(robot.name);
      if (!shown) continue;
      while (shown.links.length < robot.links.length) {
        const link = new Capsule(shown.materials[shown.links.length % 2]);
        shown.links.push(link);
        shown.group.add(...link.parts);
      }
      robot.links.forEach((link, i) => shown.links[i].place(link));
      // Meshes in place of capsules, as soon as all of them have come.
      const whole = shown.meshes.length > 0 && shown.meshes.every(({ mesh, frame }) => this.geometries[mesh] && robot.frames[frame]);
      shown.meshes.forEach(({ on, frame }) => {
        on.visible = whole;
        if (whole) pose6(on, robot.frames[frame]);
      });
      if (whole) shown.links.forEach(({ parts }) => parts.forEach((part) => { part.visible = false; }));
      while (shown.ghost.length < robot.ghost.length) {
        const link = new Capsule(shown.through);
        shown.ghost.push(link);
        shown.group.add(...link.parts);
      }
      shown.ghost.forEach(({ parts }, i) => parts.forEach((part) => { part.visible = i < robot.ghost.length; }));
      robot.ghost.forEach((link, i) => shown.ghost[i].place(link));
      this.place(shown, robot);
      if (robot.tool && continues) {
        const at = robot.tool.slice(0, 3), before = shown.at;
        const time = robot.time - (before?.time ?? robot.time);
        if (!before || Math.hypot(...at.map((x, i) => x - before.at[i])) > 1e-5) {
          const speed = before && time > 0 ? Math.hypot(...at.map((x, i) => x - before.at[i])) / time : 0;
          this.fastest = Math.max(this.fastest, speed);
          shown.path.add(at, speed);
          shown.path.draw(this.fastest);
        }
        shown.at = { at, time: robot.time };
      }
      shown.path.line.visible = this.showsPath;
    }
    state.bodies.forEach((pose, i) => {
      const body = this.bodies[i];
      if (!body) return;
      body.visible = pose !== null;
      if (pose) pose6(body, pose);
    });
    for (const arrows of this.wrenches) {
      const tool = state.robots.find(({ name }) => name === arrows.of)?.tool;
      arrows.place(tool, state.readings[arrows.sensor]);
    }
    this.places.forEach(({ axes }) => { axes.visible = this.showsFrames; });
    const robots = state.robots.map(({ name, links }) => ({ name, links, on: this.robots.get(name)?.on }));
    this.pair = this.showsNearest ? nearestLinks(robots) : null;
    this.nearest.show(this.pair);
    if (!this.fitted && state.robots.some((robot) => robot.links.length)) this.look('fit');
    this.wake();
  }

  /** The tool and the frames of a robot. */
  place(shown, robot) {
    const { tool, bar, axes } = shown;
    tool.visible = axes.visible = Boolean(robot.tool);
    const flange = robot.frames.at(-1);
    if (robot.tool) {
      pose6(tool, robot.tool);
      pose6(axes, robot.tool);
    }
    const far = robot.tool && flange && Math.hypot(...[0, 1, 2].map((i) => robot.tool[i] - flange[i])) > 0.001;
    bar.parts.forEach((part) => { part.visible = Boolean(far); });
    if (far) bar.place([...flange.slice(0, 3), ...robot.tool.slice(0, 3), 0.01]);
    while (this.showsFrames && shown.frames.length < robot.frames.length) {
      const frame = new AxesHelper(0.15);
      frame.material.depthTest = false;
      frame.renderOrder = 1;
      shown.frames.push(frame);
      shown.group.add(frame);
    }
    shown.frames.forEach((frame, i) => {
      frame.visible = this.showsFrames && i < robot.frames.length;
      if (frame.visible) pose6(frame, robot.frames[i]);
    });
    shown.base = robot.frames[0];
  }

  /** Forgets where tools have been. */
  forget() {
    this.robots.forEach((shown) => {
      shown.path.points = [];
      shown.path.draw(1);
      shown.at = null;
    });
  }

  /** Shows the path of a tool before the robot goes along it; `null`: none. */
  showPath(points) {
    if (this.path) {
      this.scene.remove(this.path);
      this.path.children.forEach(({ geometry }) => geometry !== BALL && geometry.dispose());
      this.path = null;
    }
    if (points) {
      this.path = new Group();
      const line = new BufferGeometry().setFromPoints(points.map(([x, y, z]) => new Vector3(x, y, z)));
      const colour = getComputedStyle(document.documentElement).getPropertyValue('--accent').trim();
      this.path.add(new Line(line, new LineBasicMaterial({ color: colour })));
      // A line is one pixel wide: balls show it from afar, and a greater one where it ends.
      points.forEach(([x, y, z], i) => {
        const ball = new Mesh(BALL, new MeshLambertMaterial({ color: colour }));
        ball.position.set(x, y, z);
        ball.scale.setScalar(i === points.length - 1 ? 0.02 : 0.005);
        if (i % 3 === 0 || i === points.length - 1) this.path.add(ball);
      });
      this.scene.add(this.path);
    }
    this.wake();
  }

  /** Looks from a side, at all that there is. */
  look(from) {
    const low = new Vector3(Infinity, Infinity, Infinity), high = low.clone().negate();
    const take = (x, y, z, r) => {
      low.min(new Vector3(x - r, y - r, z - r));
      high.max(new Vector3(x + r, y + r, z + r));
    };
    this.robots.forEach(({ links }) => links.forEach(({ parts: [, a, b] }) => {
      [a, b].forEach(({ position, scale }) => take(position.x, position.y, position.z, scale.x));
    }));
    // Bodies and obstacles, but for floors and walls that are larger than the cell.
    this.bodies.filter(({ visible, scale }) => visible && scale.length() < 4).forEach(({ position, scale }) => take(position.x, position.y, position.z, 0.5 * scale.length()));
    this.standing.children.forEach((solid) => {
      const { min, max } = new Box3().setFromObject(solid);
      if (min.distanceTo(max) < 4) [min, max].forEach(({ x, y, z }) => take(x, y, z, 0));
    });
    if (low.x > high.x) return;
    // Arms may reach below the world's origin, as those do that stand on a column of their own.
    this.floor = Math.min(0, low.z);
    this.grid.position.z = this.floor;
    const middle = low.clone().add(high).multiplyScalar(0.5);
    const direction = new Vector3(...{ front: [0, -1, 0.02], side: [1, 0, 0.02], top: [0, -0.001, 1], fit: [0.75, -1, 0.55] }[from]).normalize();
    // As near as all corners of the box around the links can be seen.
    const right = new Vector3(0, 0, 1).cross(direction).normalize(), up = direction.clone().cross(right);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360), wide = tall * this.camera.aspect;
    let distance = 0.5;
    for (let corner = 0; corner < 8; corner++) {
      const at = new Vector3(...['x', 'y', 'z'].map((axis, bit) => (corner & (1 << bit) ? high : low)[axis])).sub(middle);
      distance = Math.max(distance, at.dot(direction) + 1.1 * Math.max(Math.abs(at.dot(right)) / wide, Math.abs(at.dot(up)) / tall));
    }
    this.camera.position.copy(middle).addScaledVector(direction, distance);
    this.controls.target.copy(middle);
    this.controls.update();
    this.fitted = true;
    this.wake();
  }

  theme() {
    const style = getComputedStyle(document.documentElement);
    if (this.grid) this.scene.remove(this.grid);
    this.grid = new GridHelper(8, 32, style.getPropertyValue('--grid').trim(), style.getPropertyValue('--grid-fine').trim());
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.z = this.floor ?? 0;
    this.scene.add(this.grid);
    this.wake();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.wake();
  }

  /** Where marks of tools are in the picture that was drawn, in pixels of the page: the middles of their spots. */
  marks() {
    const gl = this.renderer.getContext(), [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    this.axes(false);
    this.renderer.render(this.scene, this.camera);
    const bytes = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    this.axes(true);
    this.wake();
    const spots = [];
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const at = 4 * (y * width + x);
        if (bytes[at] < 200 || bytes[at + 1] > 60 || bytes[at + 2] < 140) continue;
        const spot = spots.find((known) => Math.hypot(known.x / known.n - x, known.y / known.n - y) < 20);
        if (spot) {
          spot.x += x;
          spot.y += y;
          spot.n += 1;
        } else {
          spots.push({ x, y, n: 1 });
        }
      }
    }
    const ratio = this.renderer.getPixelRatio();
    return spots.filter(({ n }) => n > 3).map(({ x, y, n }) => [(x / n + 0.5) / ratio, (height - y / n - 0.5) / ratio, n]);
  }

  /** What is drawn, for those who test the page: bodies, obstacles, arrows, meshes, the nearest pair. */
  shown() {
    return {
      bodies: this.bodies.map(({ visible, position }) => (visible ? position.toArray() : null)),
      obstacles: this.standing.children.map(({ name, position }) => ({ name, at: position.toArray() })),
      wrenches: this.wrenches.map(({ name, group, newtons, force: { end, group: at } }) => ({
        name, newtons: group.visible ? newtons : 0, from: at.position.toArray(), to: end?.toArray() ?? null,
      })),
      meshes: [...this.robots.values()].flatMap(({ meshes }) => meshes.filter(({ on }) => on.visible).map(({ shape }) => {
        shape.updateWorldMatrix(true, false);
        return { matrix: shape.matrixWorld.toArray(), corners: shape.geometry.getAttribute('position').count };
      })),
      places: this.places.map(({ axes }) => axes.visible),
      nearest: this.pair ? { of: this.pair.of, free: this.pair.free } : null,
    };
  }

  /** Shows the axes of tools, or leaves them out. */
  axes(shown) {
    this.robots.forEach(({ axes, path, bar }) => {
      axes.visible = shown;
      path.line.visible = shown && this.showsPath;
      bar.parts.forEach((part) => { part.material.visible = shown; });
    });
    this.wrenches.forEach(({ group }) => { group.scale.setScalar(shown ? 1 : 0); });
    this.bodies.forEach((body) => { body.material.visible = shown; });
    this.standing.visible = shown;
    this.nearest.line.material.visible = shown;
  }

  wake() {
    if (this.asked) {
      this.again = true;
      return;
    }
    this.asked = true;
    const asked = performance.now();
    requestAnimationFrame(() => {
      // A machine that draws late is given time for what matters more: the buttons.
      const late = performance.now() - asked;
      this.rest = late > 60 ? Math.min(2000, 2 * late) : 0;
      this.renderer.render(this.scene, this.camera);
      this.drawn = (this.drawn ?? 0) + 1;
      this.name();
      const free = () => {
        this.asked = false;
        if (this.again) {
          this.again = false;
          this.wake();
        }
      };
      if (this.rest) setTimeout(free, this.rest);
      else free();
    });
  }

  /** Texts beside arrows and frames. */
  beside(arrows, places) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const put = (label, at) => {
      label.hidden = !at;
      if (!at) return;
      const seen = at.clone().project(this.camera);
      label.hidden = Math.abs(seen.x) > 1 || Math.abs(seen.y) > 1 || seen.z > 1;
      label.style.transform = `translate(${(0.5 + 0.5 * seen.x) * width + 10}px, ${(0.5 - 0.5 * seen.y) * height - 20}px)`;
    };
    arrows.forEach(({ label, at, group, line }) => put(label, (group ?? line).visible ? at : null));
    places.forEach(({ label, axes }) => put(label, axes.visible ? axes.position : null));
  }

  /** Names of robots, beside their bases; of those that would hide each other the nearest one. */
  name() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const named = [], at = new Vector3();
    this.robots.forEach(({ label, base }, name) => {
      label.hidden = true;
      if (!base) return;
      at.set(...base.slice(0, 3)).project(this.camera);
      if (Math.abs(at.x) > 1 || Math.abs(at.y) > 1 || at.z > 1) return;
      named.push({ label, name, far: at.z, x: (0.5 + 0.5 * at.x) * width + 8, y: (0.5 - 0.5 * at.y) * height + 6 });
    });
    this.beside([...this.wrenches, this.nearest], this.places);
    const shown = [];
    named.sort((one, other) => one.far - other.far).forEach((one) => {
      // About as wide as it is drawn: to measure each of them would cost more than to draw the cell.
      const wide = 9 * one.name.length + 12;
      const hides = (other) => Math.abs(one.y - other.y) < 22 && one.x < other.x + other.wide && other.x < one.x + wide;
      if (shown.some(hides)) return;
      shown.push({ ...one, wide });
      one.label.hidden = false;
      one.label.style.transform = `translate(${one.x}px, ${one.y}px)`;
    });
  }
}

/** In its place, where nothing can be drawn. */
export class NoScene {
  fastest = 0;

  build() {}

  mesh() {}

  show() {}

  forget() {}

  showPath() {}

  look() {}

  theme() {}

  marks() {
    return [];
  }

  shown() {
    return null;
  }
}
