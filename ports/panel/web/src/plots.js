// Plots of the last minute.
//
// In: numbers with their times, in seconds. Out: lines that move on, drawn a few times a second.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

const MINUTE = 60;
/** States that are farther apart are not joined [s]. */
const GAP = 2;
export const LINES = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#8a6fb8', '#7f7f7f'];

export class Plot {
  /** `least`: a curve from 0 whose axis is at least as high as this. */
  constructor(element, legend, least) {
    this.element = element;
    this.least = least;
    this.legend = legend;
    this.names = [];
    this.data = [[]];
    new ResizeObserver(() => this.resize()).observe(element);
  }

  /** Begins anew with lines of these names. */
  begin(names) {
    this.names = names;
    this.data = [[], ...names.map(() => [])];
    this.legend?.replaceChildren(...names.map((name, i) => {
      const item = document.createElement('span');
      item.textContent = name;
      item.style.borderLeftColor = LINES[i % LINES.length];
      return item;
    }));
    this.make();
  }

  make() {
    this.plot?.destroy();
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = { stroke: colour('--soft'), grid: { stroke: colour('--line'), width: 1 }, ticks: { show: false }, font: '11px system-ui' };
    const seconds = (_, ticks) => ticks.map((t) => `${t.toFixed(ticks[1] - ticks[0] < 1 ? 1 : 0)} s`);
    const series = this.names.map((label, i) => ({ label, stroke: LINES[i % LINES.length], width: 1.5, points: { show: false }, dash: i >= LINES.length ? [4, 3] : undefined }));
    const { clientWidth: width, clientHeight: height } = this.element;
    this.plot = new uPlot({
      width: Math.max(60, width), height: Math.max(40, height),
      scales: { x: { time: false }, ...(this.least ? { y: { range: (_, low, high) => [0, Math.max(this.least, 1.1 * high)] } } : {}) },
      series: [{ label: 's', value: (_, t) => (t === null ? '' : t.toFixed(2)) }, ...series],
      axes: [{ ...axis, values: seconds, size: 22, space: 70 }, { ...axis, size: 46 }],
      legend: { show: false },
      cursor: { drag: { x: true, y: false } },
    }, this.data, this.element);
  }

  /** What it shows is of another time. */
  forget() {
    this.data.forEach((line) => { line.length = 0; });
  }

  add(time, values) {
    const times = this.data[0];
    // What is earlier than what is there begins anew.
    if (times.length && time < times.at(-1)) this.forget();
    if (times.length && time === times.at(-1)) return;
    // What was not seen is no line: a jump in a recording, or a page that was away.
    if (times.length && time > times.at(-1) + GAP) this.data.forEach((line, i) => line.push(i ? null : times.at(-1) + GAP / 2));
    times.push(time);
    values.forEach((value, i) => this.data[i + 1]?.push(value));
    let old = 0;
    while (times[old] < time - MINUTE) old++;
    if (old > 20) this.data.forEach((line) => line.splice(0, old));
  }

  draw() {
    if (this.plot && !this.isZoomed()) this.plot.setData(this.data);
  }

  /** Whether a part was chosen by hand: two clicks show all of it again. */
  isZoomed() {
    const { min, max } = this.plot.scales.x, times = this.data[0];
    return this.plot.select.width > 0 && min !== undefined && max - min < 0.9 * (times.at(-1) - times[0]);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (this.plot && width && height) this.plot.setSize({ width, height });
  }
}

/** Writes what plots have, the last minute, into a file of the person's: a block for each plot, with its times in seconds. */
export function save(plots, file) {
  const blocks = plots.filter(([, { data }]) => data[0].length).map(([name, { names, data }]) => {
    const rows = data[0].map((_, i) => data.map((line) => line[i] ?? '').join(','));
    const quoted = names.map((text) => `"${text.replaceAll('"', '""')}"`);
    return [`# ${name}`, ['time_s', ...quoted].join(','), ...rows].join('\n');
  });
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([`${blocks.join('\n\n')}\n`], { type: 'text/csv' }));
  link.download = file;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
