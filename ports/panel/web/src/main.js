// The operator's panel.
//
// In: what the panel's process sends. Out: the page. `scene` draws the cell, `plots` the last minute, `operate` has the buttons, `jog`
// those that move one robot, `devices` what is beside joints, `values` what is plotted, `play` the time of a recording, `link` the
// connection.

import { Devices } from './devices.js';
import { Jogging } from './jog.js';
import { CellScene, NoScene } from './scene.js';
import { Link } from './link.js';
import { Operating } from './operate.js';
import { Player } from './play.js';
import { LINES, Plot, save } from './plots.js';
import { SHOWN, groups, tenths } from './values.js';

const by = (id) => document.getElementById(id);
/** A picture that is older than this is told of [ms]. */
const OLD = 1000;

const scene = drawn();
const plots = {
  joints: new Plot(by('plot-joints')), speed: new Plot(by('plot-speed'), by('speed-names'), 20), late: new Plot(by('plot-late'), by('late-names')),
  readings: new Plot(by('plot-readings'), by('readings-names')),
};
let layout = null, newest = null, cameAt = 0, over = '', closed = false, late = [];
const before = new Map();
/** To one digit; a zero has no sign. */
const devices = new Devices();
/** What the plot of readings may show, and what it does show. */
let sensed = [], group = null;

/** The picture; a browser that cannot draw one operates the cell all the same. */
function drawn() {
  try {
    return new CellScene(by('scene'), by('labels'));
  } catch {
    by('no-scene').hidden = false;
    by('scene').hidden = true;
    for (const element of document.querySelectorAll('.tools, .legend')) element.hidden = true;
    return new NoScene();
  }
}

const link = new Link(hear, (what, why) => {
  closed = what === 'closed';
  if (what === 'token') {
    by('door-why').textContent = why;
    if (!by('door').open) by('door').showModal();
  } else if (by('door').open) {
    by('door').close();
  }
  operating.draw();
  if (layout) jogging.draw();
});
const operating = new Operating(link);
const player = new Player(link);
const jogging = new Jogging(operating, link, (path) => scene.showPath(path));

function hear(message) {
  switch (message.kind) {
    case 'layout': return build(message);
    case 'mesh': return scene.mesh(message);
    case 'state': return show(message);
    case 'authority':
      operating.authority(message);
      return jogging.draw();
    case 'poses': return jogging.poses(message);
    case 'note': return note(message.text);
    case 'over':
      over = message.text;
      return undefined;
    default: return undefined;
  }
}

function build(message) {
  layout = message;
  document.title = `${layout.robots.map((robot) => robot.name).join(', ') || 'mrroc'} · panel`;
  scene.build(layout);
  by('robot').replaceChildren(...layout.robots.map((robot) => new Option(`${robot.name} (${robot.kind})`, robot.name)));
  plots.speed.begin(layout.robots.map((robot) => robot.name));
  late = [];
  const played = layout.lasts !== null;
  by('reach').hidden = by('operating').hidden = by('processes-part').hidden = by('late-figure').hidden = played;
  devices.build(layout);
  sensed = groups(layout.sensors);
  by('readings-of').replaceChildren(...sensed.map(({ title }, i) => new Option(title, i)));
  by('readings-figure').hidden = sensed.length === 0;
  choose();
  chooseReadings();
  jogging.begin(layout);
  if (played) player.begin(layout.lasts);
}

/** Another robot's joints are shown. */
function choose() {
  const robot = layout?.robots.find(({ name }) => name === by('robot').value);
  const joints = robot?.joints ?? [];
  const unit = (joint) => (joint.kind === 'revolute' ? 'rad' : 'm');
  by('plot-joints-title').textContent = `${robot?.name ?? '–'} [${SHOWN[by('joints-as').value].unit ?? [...new Set(joints.map(unit))].join(', ')}]`;
  plots.joints.begin(joints.map((_, i) => `${i + 1}`));
  by('joints').replaceChildren(...joints.flatMap((joint, i) => {
    const name = document.createElement('span'), range = document.createElement('div'), value = document.createElement('output');
    name.textContent = `${i + 1}`;
    name.style.borderLeftColor = LINES[i % LINES.length];
    range.className = 'range';
    range.append(document.createElement('b'), document.createElement('i'));
    value.textContent = '–';
    return [name, range, value];
  }));
}

/** What was chosen just now is plotted. */
function plotAnew() {
  if (newest && layout.lasts === null) show(newest);
  else if (newest) player.anew();
}

/** Readings of another sensor are plotted. */
function chooseReadings() {
  group = sensed[by('readings-of').value] ?? null;
  if (group) plots.readings.begin(group.names);
}

function show(state) {
  const continues = layout.lasts === null || player.came();
  if (!continues) {
    scene.forget();
    before.clear();
    Object.values(plots).forEach((plot) => plot.forget());
    state.minute?.forEach(plotted);
  }
  newest = state;
  cameAt = performance.now();
  scene.show(state, continues);
  operating.show(state);
  if (layout.lasts === null) jogging.show(state);
  const sign = by('state');
  sign.dataset.state = state.state;
  sign.querySelector('.word').textContent = state.state;
  by('doing').textContent = state.doing === 'nothing'
    ? `instruction ${state.instruction} is over` : `instruction ${state.instruction}: ${state.doing} ${state.by}`;
  by('step').textContent = state.step;
  by('time').textContent = `${state.time.toFixed(1)} s`;
  by('rate').textContent = `${Math.round(100 * state.rate)} %`;
  by('fault').hidden = !state.fault;
  const stopped = ['latched', 'acknowledged', 'stopping'].includes(state.state);
  by('fault').querySelector('h2').textContent = stopped ? 'Stopped: first cause' : 'Last fault';
  by('fault').classList.toggle('past', !stopped);
  by('cause').textContent = state.fault ?? '';
  by('help').textContent = state.help ? `What to do: ${state.help}` : '';
  by('persisting').textContent = state.persisting ? `A reset failed or would be refused: ${state.persisting}` : '';
  showJoints(state);
  plotted(state);
  by('fastest').textContent = `${Math.round(1000 * scene.fastest)} mm/s`;
  devices.show(state, by('robot').value);
  showProcesses(state);
}

/** What robots and sensors did goes on in the plots. */
function plotted(state) {
  const chosen = by('robot').value, joints = layout.robots.find(({ name }) => name === chosen)?.joints;
  const robot = state.robots.find(({ name }) => name === chosen);
  if (robot && joints) plots.joints.add(state.time, joints.map((joint, i) => SHOWN[by('joints-as').value].of(robot.measured[i], robot.demanded[i], joint)));
  plots.speed.add(state.time, layout.robots.map(({ name }) => speed(name, state)));
  if (group) plots.readings.add(state.time, group.places.map((place) => state.readings[group.sensor]?.[place] ?? null));
}

/** The speed of a robot's tool since the state before [mm/s]. */
function speed(name, state) {
  const robot = state.robots.find((shown) => shown.name === name), tool = robot?.tool, last = before.get(name);
  if (!tool) return null;
  const since = robot.time - (last?.time ?? robot.time);
  if (last && since <= 0) return last.speed;
  const distance = last ? Math.hypot(...[0, 1, 2].map((i) => tool[i] - last.tool[i])) : 0;
  const fast = since > 0 ? (1000 * distance) / since : 0;
  before.set(name, { tool, time: robot.time, speed: fast });
  return fast;
}

function showJoints(state) {
  const chosen = by('robot').value;
  const robot = state.robots.find(({ name }) => name === chosen), made = layout.robots.find(({ name }) => name === chosen);
  if (!robot || !made) return;
  const cells = by('joints').children;
  made.joints.forEach((joint, i) => {
    const [range, value] = [cells[3 * i + 1], cells[3 * i + 2]];
    const share = (q) => (joint.lower === null || joint.upper === null || q === null ? 0.5 : (q - joint.lower) / (joint.upper - joint.lower));
    const at = share(robot.measured[i]);
    range.firstChild.style.left = `${100 * Math.min(1, Math.max(0, share(robot.demanded[i])))}%`;
    range.lastChild.style.left = `${100 * Math.min(1, Math.max(0, at))}%`;
    range.classList.toggle('near', at < 0.03 || at > 0.97);
    const q = robot.measured[i];
    value.textContent = q === null ? '–' : joint.kind === 'revolute' ? `${tenths((q * 180) / Math.PI)}°` : `${tenths(1000 * q)} mm`;
  });
}

function showProcesses(state) {
  if (!state.processes.length) return;
  // An ECP waits for orders: it is late for nothing.
  const timed = state.processes.filter(({ name }) => !name.startsWith('ecp')).slice(0, 8), names = timed.map(({ name }) => name);
  if (names.join() !== late.join()) {
    late = names;
    plots.late.begin(names);
  }
  plots.late.add(state.time, timed.map((process) => process.late[1]));
  if (!by('processes-part').open) return;
  by('processes').replaceChildren(...state.processes.map((process) => {
    const row = document.createElement('tr');
    const cells = [process.runs ? process.name : `${process.name} (ended)`, process.steps, process.skipped, process.late[1].toFixed(0)];
    row.append(...cells.map((text) => Object.assign(document.createElement('td'), { textContent: text })));
    return row;
  }));
}

function note(text) {
  const item = document.createElement('li');
  item.textContent = text;
  by('notes').prepend(item);
  while (by('notes').children.length > 100) by('notes').lastChild.remove();
}

// What is shown is old, or the connection is gone: that is told, and nothing looks alive.
setInterval(() => {
  const since = performance.now() - cameAt;
  const live = layout !== null && layout.lasts === null;
  const old = live && newest !== null && since > OLD;
  const text = over ? `The cell is over: ${over}` : closed ? 'The panel cannot be reached. It is tried again.' : old ? `No news for ${(since / 1000).toFixed(0)} s: what you see is old.` : '';
  by('stale').hidden = !text;
  by('stale').textContent = text;
  document.querySelector('.view').classList.toggle('old', Boolean(text));
  if (text && !over) {
    operating.draw();
    if (layout) jogging.draw();
  }
}, 250);
setInterval(() => Object.values(plots).forEach((plot) => plot.draw()), 200);

for (const [id, chooses] of [['robot', choose], ['joints-as', choose], ['readings-of', chooseReadings]]) {
  by(id).addEventListener('change', () => {
    chooses();
    plotAnew();
  });
}
by('save').addEventListener('click', () => save(Object.entries(plots), `${layout?.robots.map(({ name }) => name).join('-') || 'cell'}.csv`));
for (const button of document.querySelectorAll('[data-view]')) button.addEventListener('click', () => scene.look(button.dataset.view));
const toggle = (id, set) => by(id).addEventListener('click', () => {
  const on = by(id).getAttribute('aria-pressed') !== 'true';
  by(id).setAttribute('aria-pressed', on);
  set(on);
  if (newest) scene.show(newest, false);
});
toggle('frames', (on) => { scene.showsFrames = on; });
toggle('nearest', (on) => { scene.showsNearest = on; });
toggle('path', (on) => {
  scene.showsPath = on;
  by('legend').hidden = !on;
});
by('door').addEventListener('cancel', (event) => event.preventDefault());
by('door').addEventListener('close', () => {
  if (!link.isOpen) link.open(by('token').value.trim());
});

const theme = localStorage.getItem('mrroc-theme');
if (theme) document.documentElement.dataset.theme = theme;
by('theme').addEventListener('click', () => {
  const dark = getComputedStyle(document.documentElement).colorScheme === 'dark';
  document.documentElement.dataset.theme = dark ? 'light' : 'dark';
  localStorage.setItem('mrroc-theme', dark ? 'light' : 'dark');
  scene.theme();
  Object.values(plots).forEach((plot) => plot.make());
});
scene.theme();

// For those who test the page: the camera, and what was shown last.
window.mrrocPanel = {
  camera: () => ({ view: scene.camera.matrixWorldInverse.toArray(), projection: scene.camera.projectionMatrix.toArray() }),
  state: () => newest,
  isOpen: () => link.isOpen,
  ask: (message) => link.ask(message),
  cut: () => link.socket.close(),
  marks: () => scene.marks(),
  layout: () => layout,
  scene: () => scene.shown(),
  drawn: () => scene.drawn ?? 0,
  plots: () => Object.fromEntries(Object.entries(plots).map(([name, { names, data }]) => [name, { names, data }])),
};

link.open();
