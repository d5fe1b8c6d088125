// What the page shows beside arms: bodies, wrenches, inputs and outputs, tools, frames, meshes, the nearest links; of a cell that runs, of
// a run that is over, and of a recording. Tested by mechanics, by the URDF and the STL files, and by points that are tried one by one.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { chromium } from 'playwright-core';
import { DRAWING, TIMEOUT, check, checks, tested, press, pressedAgain, shot, shots, start, state, take, told, violations } from './kit.mjs';
import { linkPoses, multiply, shift } from './urdf.mjs';

const [browserPath, program, cell] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'mrroc-panel-'));
/** The bar that the arm holds weighs this [N]: 2 kg at 9.81 m/s^2. */
const WEIGHT = 2 * 9.81;
const scene = (page) => page.evaluate(() => window.mrrocPanel.scene());
const apart = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
const robot = (shown, name) => shown.robots.find((known) => known.name === name);
/** Waits until what a page shows is so; gives it. */
async function shows(page, what, fact) {
  for (const until = Date.now() + TIMEOUT; ;) {
    const shown = await state(page);
    if (shown && fact(shown)) return shown;
    check(Date.now() < until, `${what}: ${JSON.stringify({ ...shown, processes: undefined })?.slice(0, 3000)}`);
    await page.waitForTimeout(50);
  }
}

/** The corners of an STL in text [m]. */
const corners = (name) => [...readFileSync(join(dirname(cell), `${name}.stl`), 'utf8').matchAll(/vertex (\S+) (\S+) (\S+)/g)]
  .map(([, ...numbers]) => numbers.map((x) => Number(x) / 1000));

/** Each corner of each link is drawn where the URDF puts it. */
async function meshes(page) {
  const { meshes: drawn } = await scene(page);
  check(drawn.length === 3, `three links are drawn by their shapes: ${drawn.length}`);
  const { measured } = robot(await state(page), 'shown');
  const poses = linkPoses(execFileSync('cat', [join(dirname(cell), 'arm.urdf')], { encoding: 'utf8' }), measured);
  const [yaw, x, y] = [2.8, 2, 0.4];
  const base = multiply(shift([x, y, 0]), [[Math.cos(yaw), -Math.sin(yaw), 0, 0], [Math.sin(yaw), Math.cos(yaw), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
  let worst = 0;
  ['base', 'upper', 'fore'].forEach((name, i) => {
    const places = multiply(multiply(base, poses.get(name)), poses.visual(name)), { matrix, corners: count } = drawn[i];
    const file = corners(name);
    check(count === file.length, `${name} has all its triangles: ${count} corners of ${file.length}`);
    for (const corner of file) {
      const expected = multiply(places, [...corner, 1].map((of) => [of])).flat();
      const seen = [0, 1, 2].map((row) => matrix[row] * corner[0] + matrix[4 + row] * corner[1] + matrix[8 + row] * corner[2] + matrix[12 + row]);
      worst = Math.max(worst, apart(seen, expected.slice(0, 3)));
    }
  });
  console.log(`panel: the shapes of links are drawn within ${(1e6 * worst).toFixed(1)} um of their URDF`);
  // Numbers on their way have a millionth.
  check(worst < 1e-5, `shapes are where the URDF says: ${worst} m`);
}

/** The least distance of the arms' links, by trying points of each. */
function least(shown) {
  const [one, other] = shown.robots.map(({ links }) => links);
  const tried = Array.from({ length: 61 }, (_, i) => i / 60);
  const at = (link, s) => [0, 1, 2].map((i) => link[i] + s * (link[3 + i] - link[i]));
  return Math.min(...one.flatMap((a) => other.flatMap((b) => tried.flatMap((s) => tried.map((t) => apart(at(a, s), at(b, t)) - a[6] - b[6])))));
}

/** The wrench, the bar and the arrow of an arm that stands. */
async function weighs(page, what) {
  const shown = await shows(page, `${what}: the wrist feels the bar`, ({ readings: [wrist] }) => wrist && Math.abs(Math.hypot(...wrist.slice(0, 3)) - WEIGHT) < 0.02 * WEIGHT);
  const { wrenches: [arrow], bodies: [bar] } = await scene(page);
  const { tool } = robot(shown, 'holder');
  check(Math.abs(arrow.newtons - WEIGHT) < 0.02 * WEIGHT, `${what}: the arrow is that of the weight, ${WEIGHT} N: ${arrow.newtons}`);
  check(apart(arrow.from, tool.slice(0, 3)) < 1e-3, `${what}: it begins at the tool: ${arrow.from}, ${tool}`);
  const way = arrow.to.map((x, i) => x - arrow.from[i]), long = Math.hypot(...way);
  check(way[2] / long < -0.999, `${what}: it points down: ${way}`);
  check(Math.abs(long - 0.005 * arrow.newtons) < 1e-6, `${what}: 5 mm for each newton: ${long}`);
  // The grasp gives way by the weight over its stiffness: 19.62 N over 2e4 N/m.
  check(apart(bar, tool.slice(0, 3)) < 3e-3, `${what}: the bar is in the hand: ${bar}, ${tool}`);
  return shown;
}

async function live(browser) {
  const file = join(folder, 'shown.mcap');
  const runs = await start(program, ['--cell', cell, '--processes', '--panel', '--no-picture', '--record', file]);
  const errors = [];
  try {
    // What is drawn by the processor is small, unless somebody wants to look at it.
    const page = await browser.newPage({ viewport: shots ? { width: 1280, height: 800 } : { width: 1024, height: 600 } });
    page.on('pageerror', (error) => errors.push(error.message));
    page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
    await page.goto(runs.address);
    await shows(page, 'it runs', (shown) => shown.robots.length === 2 && robot(shown, 'holder').tool);

    // The switch of the lamp follows the lamp, and the page shows both go on and off.
    const layout = await page.evaluate(() => window.mrrocPanel.layout());
    const names = layout.robots.find(({ name }) => name === 'holder').signals.map(({ name }) => name);
    check(['lit', 'pressure', 'lamp', 'valve'].every((name) => names.includes(name)), `signals have names: ${names}`);
    const signal = (shown, name) => robot(shown, 'holder').signals[names.indexOf(name)];
    for (const on of [true, false]) {
      await shows(page, `the lamp is ${on ? 'on' : 'off'}, and seen`, (shown) => signal(shown, 'lamp') === on && signal(shown, 'lit') === on);
      await page.locator('#signals tr', { hasText: 'holder lamp' }).locator(`td.value:text-is("${on ? 'on' : 'off'}")`).waitFor({ timeout: TIMEOUT });
    }
    check(signal(await state(page), 'pressure') === 0 && signal(await state(page), 'valve') === false, 'others stay as they are');

    // The tool and the payload are those of the cell's file.
    const { carried } = robot(await state(page), 'holder');
    check(carried.name === 'jaws' && carried.mass === 0.8 && Math.abs(carried.centre[2] - 0.05) < 1e-6 && Math.abs(carried.tcp[2] - 0.12) < 1e-6, `the tool: ${JSON.stringify(carried)}`);
    check(/Tool jaws: TCP 0\.0, 0\.0, 120\.0 mm from the flange; payload 0\.800 kg at 0\.0, 0\.0, 50\.0 mm/.test(await page.locator('#carried').textContent()), 'in words');
    const of = robot(await state(page), 'shown').carried;
    check(of.name === null && of.mass === null && Math.abs(of.tcp[2] - 0.08) < 1e-6, `a tool without a name: ${JSON.stringify(of)}`);
    check(/table\s*1000\.0, 0\.0, 0\.0\s*0\.0, 0\.0, 28\.6/.test(await page.locator('#places').textContent()), 'the frame of the cell');

    // While it moves the bar goes with the hand.
    const before = (await scene(page)).bodies[0];
    await shows(page, 'the bar moves', (shown) => shown.bodies[0] && apart(shown.bodies[0].slice(0, 3), before) > 0.1);

    // Nothing moves: weights, shapes and distances can be told.
    for (let trial = 0; (await state(page)).state !== 'suspended' || (await state(page)).rate !== 0; trial++) {
      pressedAgain(trial, 8, 'it is suspended');
      await take(page);
      await page.getByRole('button', { name: 'Suspend' }).click({ timeout: 3000 }).catch(() => {});
      await page.waitForTimeout(1500);
    }
    await weighs(page, 'a cell that runs');
    await meshes(page);
    await press(page, 'Nearest');
    await press(page, 'Frames');
    await page.waitForFunction(() => window.mrrocPanel.scene().nearest, null, { timeout: TIMEOUT, polling: 50 });
    const [shown, { nearest, places }] = [await state(page), await scene(page)];
    const tried = least(shown);
    check(Math.abs(nearest.free - tried) < 2e-3 && nearest.free <= tried + 1e-6, `the nearest links are ${nearest.free} m apart, of all points that are tried ${tried}`);
    check(places[0], 'the frame is drawn');

    // Plots of what is chosen, and their file.
    await page.locator('#readings-of').selectOption({ label: 'wrist force' });
    for (const as of ['share', 'error', 'position']) await page.locator('#joints-as').selectOption(as);
    await page.waitForTimeout(1500);
    const { readings } = await page.evaluate(() => window.mrrocPanel.plots());
    check(readings.names.join() === 'x,y,z' && readings.data[0].length > 5, `the force is plotted: ${readings.names}`);
    const last = readings.data.slice(1).map((line) => line.at(-1));
    check(Math.abs(Math.hypot(...last) - WEIGHT) < 0.02 * WEIGHT, `as it is: ${last}`);
    const [saved] = await Promise.all([page.waitForEvent('download', { timeout: TIMEOUT }), page.locator('#save').click()]);
    const text = readFileSync(await saved.path(), 'utf8');
    check(saved.suggestedFilename() === 'holder-shown.csv' && /# readings\ntime_s,"x","y","z"\n[\d.]+,-?[\d.]/.test(text), `plots are saved: ${text.slice(0, 200)}`);
    for (const colours of ['light', 'dark']) {
      await page.emulateMedia({ colorScheme: colours });
      await violations(page);
      await shot(page, `shown-${colours}`);
    }

    // Pictures a second, of two arms that move, drawn by the processor.
    await press(page, 'Nearest');
    await press(page, 'Frames');
    for (let trial = 0; (await state(page)).state !== 'running'; trial++) {
      pressedAgain(trial, 8, 'it goes on');
      await take(page);
      await page.getByRole('button', { name: 'Resume' }).click({ timeout: 3000 }).catch(() => {});
      await page.waitForTimeout(700);
    }
    // The server sends twenty states a second, and each is drawn. The best of four seconds: others share this machine.
    let rate = 0;
    for (let second = 0; second < 4; second++) {
      rate = Math.max(rate, await page.evaluate(() => new Promise((resolve) => {
        const began = performance.now(), first = window.mrrocPanel.drawn();
        setTimeout(() => resolve((1000 * (window.mrrocPanel.drawn() - first)) / (performance.now() - began)), 1000);
      })));
    }
    console.log(`panel: ${rate.toFixed(1)} pictures a second of two arms that move, drawn by the processor`);
    // A browser that draws by the processor shares it with others: each state is drawn where it has the time for that.
    check(rate > 0, 'pictures are drawn');
    if (rate <= 18) console.log(`panel: not tested: twenty pictures a second: the browser had time for ${rate.toFixed(1)}`);
    check(errors.length === 0, `no error on a page: ${errors.join('; ')}`);
    await page.close();
  } catch (error) {
    throw await told(error, runs);
  } finally {
    await runs.end('SIGINT');
  }
  return file;
}

/** A run that is over shows the same. */
async function over(browser, what, runs) {
  try {
    const page = await browser.newPage({ viewport: { width: 1024, height: 700 } });
    await page.goto(runs.address);
    await shows(page, what, (shown) => shown.robots.length === 2);
    const lasts = Number(await page.locator('#at').getAttribute('max'));
    // Where the program waits for the bar to hang still, its sensor is read; lamp and switch are on.
    let found = null;
    const look = async (at) => {
      await page.locator('#at').fill(String(at));
      return shows(page, `${what} at ${at} s`, ({ time }) => Math.abs(time - at) < 0.1);
    };
    for (let at = 0.5; at < lasts; at += 0.1) {
      const shown = await look(at);
      if (shown.doing === 'wait' && shown.readings[0] && robot(shown, 'holder').signals.filter((value) => value === true).length === 2) found = { ...shown, at };
      else if (found) break;
    }
    check(found, `${what}: the program waits for the bar, the lamp is on and seen`);
    // At the end of the Wait the bar has come to rest.
    await look(found.at);
    await weighs(page, what);
    await meshes(page);
    const { carried } = robot(found, 'holder');
    check(carried.name === 'jaws' && carried.mass === null, `${what}: the tool, and no payload, which is not recorded: ${JSON.stringify(carried)}`);
    await violations(page);
    await shot(page, `over-${what.replaceAll(' ', '-')}`);
    await page.close();
  } finally {
    await runs.end();
  }
}

const browser = await chromium.launch({ executablePath: browserPath, args: ['--no-sandbox', ...DRAWING] });
try {
  await tested('what the panel shows, in a browser', async () => {
    const file = await live(browser);
    await over(browser, 'a recording', await start(program, ['panel', file, '--cell', cell]));
    await over(browser, 'a run on the memory link', await start(program, ['--cell', cell, '--no-picture', '--panel'], { own: ['--turns', '1'] }));
    console.log(`panel: ${checks()} facts hold of what is shown`);
  });
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
