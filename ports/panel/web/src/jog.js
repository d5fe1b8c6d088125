// Jogging and teaching: buttons that move one robot as long as they are held, or switch its outputs, and poses with names.
//
// In: states of the cell, the poses that were taught, presses. Out: a jog, said again and again while a button is held; requests to teach,
// rename and forget poses. Every button that moves something is a button that is held, and says why it cannot be.

import { mm, rollPitchYaw } from './devices.js';
import { seenFrom } from './shown.js';
import { tenths } from './values.js';

const by = (id) => document.getElementById(id);
const AXES = ['x', 'y', 'z', 'rx', 'ry', 'rz'];
const NAMES = { x: 'X', y: 'Y', z: 'Z', rx: 'turn X', ry: 'turn Y', rz: 'turn Z' };
/** Increments: [m] of a tool or a joint that slides, [degrees] of what turns. */
const STEPS = [['while held', null, null], ['1 mm · 0.1°', 0.001, 0.1], ['5 mm · 1°', 0.005, 1], ['20 mm · 5°', 0.02, 5]];
const RAD = Math.PI / 180;
/** A robot that stands because it has gone the whole distance. */
const THERE = 'it is there';

export class Jogging {
  /** `operating` holds; `draw` shows the path to a pose, or none. */
  constructor(operating, link, draw) {
    this.operating = operating;
    this.link = link;
    this.drawPath = draw;
    this.layout = null;
    this.state = null;
    this.taught = {};
    by('jog-robot').addEventListener('change', () => this.build());
    by('jog-space').addEventListener('change', () => this.build());
    by('jog-speed').addEventListener('input', () => { by('jog-speed-set').textContent = `${by('jog-speed').value} %`; });
    by('jog-done').addEventListener('click', () => operating.press(by('jog-done'), { do: 'jog-done', rest: this.robot, ...operating.stamp() }));
    by('teach').addEventListener('submit', (event) => {
      event.preventDefault();
      const name = by('pose-name').value.trim();
      operating.press(by('teach-it'), { do: 'teach', robot: this.robot, name, ...operating.stamp() }).then((outcome) => {
        if (outcome === 'done') by('pose-name').value = this.free();
      });
    });
    by('jog-step').replaceChildren(...STEPS.map(([text], i) => new Option(text, i)));
  }

  get robot() {
    return by('jog-robot').value;
  }

  /** What that robot is made of, and how it is now. */
  get made() {
    return this.layout.robots.find(({ name }) => name === this.robot);
  }

  get now() {
    return this.state?.robots.find(({ name }) => name === this.robot);
  }

  /** No path is shown any more, so that none may be gone. */
  forgetPath() {
    this.seen = null;
    this.drawPath(null);
  }

  /** Another cell. */
  begin(layout) {
    this.layout = layout;
    by('jog').hidden = layout.lasts !== null;
    by('jog-robot').replaceChildren(...layout.robots.map(({ name, kind }) => new Option(`${name} (${kind})`, name)));
    const frames = layout.frames ?? [];
    by('jog-space').replaceChildren(
      new Option('tool', 'tool'), new Option('world', 'world'), ...frames.map((name) => new Option(`frame ${name}`, `frame ${name}`)), new Option('joints', 'joints'));
    this.build();
  }

  /** Buttons of another robot, or in another space. */
  build() {
    this.operating.letGo();
    const joints = this.made?.joints ?? [];
    const space = by('jog-space').value;
    const rows = space === 'joints'
      ? joints.map((joint, i) => [`joint ${i + 1}`, `joint ${i + 1}`, joint.kind === 'revolute'])
      : AXES.map((axis) => [`${space} ${axis}`, NAMES[axis], axis.startsWith('r')]);
    by('jog-buttons').replaceChildren(...rows.flatMap(([what, name, turns]) => {
      const button = (sign, text) => this.holdButton(text, `${name} ${sign < 0 ? 'minus' : 'plus'}`, () => this.order(what, sign, turns));
      const label = document.createElement('span');
      label.textContent = name;
      return [button(-1, '−'), label, button(1, '+')];
    }));
    this.buildOutputs();
    by('pose-name').value = this.free();
    this.list();
    this.draw();
  }

  /** A button that jogs as long as it is held. */
  holdButton(text, label, jog) {
    const made = Object.assign(document.createElement('button'), { type: 'button', className: 'hold', textContent: text });
    made.setAttribute('aria-label', label);
    this.operating.holding(made, jog);
    return made;
  }

  /** Buttons that switch outputs of the robot, while it stands. */
  buildOutputs() {
    const { signals = [] } = this.made ?? {};
    this.outputs = [];
    by('jog-outputs').replaceChildren(...signals.flatMap(({ name, channel, output, note }, place) => {
      if (!output) return [];
      const label = document.createElement('span');
      label.textContent = name;
      label.title = note;
      const button = (text, says, value) => {
        const made = this.holdButton(text, `${name} ${text}`, () => ({ robot: this.robot, order: `output ${name} ${says()}` }));
        if (value !== undefined) this.outputs.push({ place, value, button: made });
        return made;
      };
      if (channel.startsWith('digital')) return [label, button('off', () => 'off', false), button('on', () => 'on', true)];
      const number = Object.assign(document.createElement('input'), { type: 'number', step: 'any', value: '0' });
      number.setAttribute('aria-label', `${name} to`);
      return [label, number, button('set', () => number.valueAsNumber)];
    }));
  }

  /** What a button asks for. */
  order(what, sign, turns) {
    const [, metres, degrees] = STEPS[by('jog-step').value];
    const distance = turns ? degrees && degrees * RAD : metres;
    // From elsewhere the path to a pose is another one.
    this.forgetPath();
    return { robot: this.robot, order: `${what} ${sign * by('jog-speed').value}%${distance ? ` by ${distance}` : ''}` };
  }

  /** The poses that robots were taught. */
  poses({ robots }) {
    this.taught = robots;
    if (!by('pose-name').value) by('pose-name').value = this.free();
    this.list();
    this.draw();
  }

  /** A name that no pose has. */
  free() {
    const names = (this.taught[this.robot]?.poses ?? []).map(({ name }) => name);
    for (let i = 1; ; i++) if (!names.includes(`p${i}`)) return `p${i}`;
  }

  list() {
    // Its buttons are made anew: one that is held is let go.
    if (by('poses').contains(this.operating.held?.button)) this.operating.letGo();
    this.forgetPath();
    const { poses = [], why } = this.taught[this.robot] ?? {};
    by('poses-why').textContent = why ?? '';
    by('poses').replaceChildren(...poses.map(({ name, joints }) => {
      const item = document.createElement('li'), text = document.createElement('span');
      text.textContent = name;
      const button = (label, does) => {
        const made = Object.assign(document.createElement('button'), { type: 'button', textContent: label });
        made.setAttribute('aria-label', `${label}: ${name}`);
        made.addEventListener('click', () => does(made));
        return made;
      };
      const look = button('Path', (made) => this.look(name, made));
      look.dataset.looks = '';
      const go = this.holdButton('Go, held', `Go, held: ${name}`, () => ({ robot: this.robot, order: `to ${by('jog-speed').value}% ${joints.join(' ')}` }));
      go.dataset.pose = name;
      const rename = button('Rename', (made) => {
        const to = by('pose-name').value.trim();
        this.operating.press(made, { do: 'rename', robot: this.robot, name, to });
      });
      const forget = button('Delete', (made) => this.operating.press(made, { do: 'forget', robot: this.robot, name }));
      item.append(text, look, go, rename, forget);
      return item;
    }));
  }

  /** Shows the path to a pose: then the robot may go along it. */
  async look(name, button) {
    const answer = await this.link.ask({ do: 'path', robot: this.robot, name });
    this.operating.tell(answer.outcome, answer.text || `this is the path to ${name}: hold Go to move`);
    button.blur();
    if (answer.outcome !== 'done') return;
    this.drawPath(answer.path);
    this.seen = name;
    this.draw();
    by('poses').querySelector(`[data-pose="${name}"]`)?.focus();
  }

  show(state) {
    this.state = state;
    const jogs = this.now?.jogs;
    // Its program goes on: nobody goes along the path that is shown.
    if (this.jogs && !jogs) this.forgetPath();
    this.jogs = jogs;
    this.draw();
  }

  /** Where its tool is, in the frame that it is jogged along, or in the world, and how it is turned there; nothing of joints. */
  at() {
    const tool = this.now?.tool;
    const [what, name] = by('jog-space').value.split(' ');
    if (!tool || what === 'joints') return [];
    const frame = what === 'frame' ? this.layout.places[this.layout.frames.indexOf(name)] : null;
    const pose = frame ? seenFrom(frame, tool) : tool;
    return [`Tool in ${frame ? `frame ${name}` : 'the world'}: ${mm(pose.slice(0, 3))} mm`, `turned about x, y, z: ${rollPitchYaw(pose.slice(3)).map(tenths).join(', ')}°`];
  }

  /** Why no jog would move anything; empty if one would. */
  why() {
    const robot = this.now;
    if (!robot) return 'Nothing is known of this robot yet.';
    if (!this.operating.yours) return 'Take control first.';
    if (this.robot.includes('.')) return 'A robot of a lower cell is jogged at that cell.';
    if (!['running', 'suspended'].includes(this.state.state)) return `Nothing can be jogged: the cell is ${this.state.state}.`;
    if (!robot.jogs) {
      const doing = robot.doing ? `: it is at ${robot.doing}` : '';
      return `No program lets this robot be jogged now${doing}.${this.state.reduced ? ' Hold to run, and it goes on.' : ''}`;
    }
    if (!this.state.reduced) return 'Press Reduced speed first.';
    return '';
  }

  draw() {
    const why = this.why(), open = this.link.isOpen && this.state !== null;
    const robot = this.now;
    // A hold that the cell refuses, or that ended meanwhile, moves nothing.
    const stands = this.state?.held ? '' : this.operating.held?.why;
    const stop = stands || robot?.stop;
    const said = stop && `${stop[0].toUpperCase()}${stop.slice(1)}.`;
    by('jog-why').textContent = why || said || 'Hold a button to move; let go to stop.';
    by('jog-why').classList.toggle('stopped', !why && Boolean(stop) && stop !== THERE);
    const [place, turned] = this.at();
    by('jog-at').hidden = !place;
    by('jog-place').textContent = place ?? '';
    by('jog-turned').textContent = turned ?? '';
    for (const button of by('jog-buttons').querySelectorAll('button')) button.disabled = !open || why !== '';
    for (const button of by('jog-outputs').querySelectorAll('button')) button.disabled = !open || why !== '';
    for (const { place, value, button } of this.outputs ?? []) button.setAttribute('aria-pressed', robot?.signals?.[place] === value);
    for (const button of by('poses').querySelectorAll('button')) {
      const { pose, looks } = button.dataset;
      button.disabled = pose ? !open || why !== '' || this.seen !== pose : !open || (looks === undefined && !this.operating.yours);
    }
    by('jog-done').disabled = !open || !this.operating.yours || !robot?.jogs;
    by('teach-it').disabled = !open || !this.operating.yours;
  }
}
