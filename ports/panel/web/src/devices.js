// What the cell has beside joints: the tool and the payload of the chosen robot, inputs and outputs of all, the frames of the cell.
//
// In: the layout, and states. Out: tables of the page.

import { tenths } from './values.js';

const by = (id) => document.getElementById(id);
const element = (tag, text = '', name = '') => Object.assign(document.createElement(tag), { textContent: text, className: name });
export const mm = (numbers) => numbers.map((x) => tenths(1000 * x)).join(', ');

/** Turns about the fixed axes x, y, z [deg] that give the rotation of a quaternion x, y, z, w. */
export function rollPitchYaw([x, y, z, w]) {
  const degrees = (angle) => (180 * angle) / Math.PI;
  const pitch = Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x))));
  return [Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), pitch, Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))].map(degrees);
}

export class Devices {
  /** The cell is made of this. */
  build(layout) {
    this.rows = [];
    const rows = layout.robots.flatMap((robot) => robot.signals.map((signal, place) => {
      const row = element('tr'), value = element('td', '–', 'value');
      row.append(element('td', `${robot.name} ${signal.name}`), element('td', signal.output ? 'output' : 'input'), element('td', signal.channel), value);
      row.title = signal.note;
      this.rows.push({ robot: robot.name, place, value });
      return row;
    }));
    by('signals').replaceChildren(...rows);
    by('signals-part').hidden = rows.length === 0;
    by('places').replaceChildren(...layout.frames.map((name, i) => {
      const row = element('tr'), pose = layout.places[i];
      row.append(element('td', name), element('td', mm(pose.slice(0, 3))), element('td', rollPitchYaw(pose.slice(3)).map(tenths).join(', ')));
      return row;
    }));
    by('places-part').hidden = layout.frames.length === 0;
  }

  /** The cell is like this now, and this robot is chosen. */
  show(state, chosen) {
    const carried = state.robots.find(({ name }) => name === chosen)?.carried;
    by('carried').textContent = carried ? tool(carried) : '';
    for (const { robot, place, value } of this.rows) {
      const now = state.robots.find(({ name }) => name === robot)?.signals[place] ?? null;
      const text = now === null ? '–' : now === true ? 'on' : now === false ? 'off' : now.toPrecision(4);
      if (value.textContent !== text) {
        value.textContent = text;
        value.dataset.on = now === true;
      }
    }
  }
}

/** The tool and the payload in words. */
function tool({ name, tcp, mass, centre }) {
  const flange = tcp.slice(0, 3).every((x) => x === 0);
  const what = name ? `Tool ${name}` : flange ? 'No tool' : 'A tool without a name';
  const payload = mass === null ? 'no payload is known' : `payload ${mass.toFixed(3)} kg at ${mm(centre)} mm`;
  return `${what}: TCP ${mm(tcp.slice(0, 3))} mm from the flange; ${payload}.`;
}
