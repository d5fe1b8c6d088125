// How soon an arm stands that is jogged, however its hold ends: `--times` holds each way (1), tested from a recording by holds.py. Where it has
// a network of its own (`--network`), the link to the page is taken down as well.
//
// Always, of each hold: the rate falls without rising again, within the longest stop, and then robots stand. In how many steps it begins to
// fall is up to threads that do not keep real time, too: it is 3 at most of half of all holds, and of each one where there are many. A hold
// of which nothing can be said is not made again, and counted.

import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { check, inWords, lateness, nicely, option, shows, start, state, take, until } from './kit.mjs';

const [browserPath, program, cellFile, python, test] = process.argv.slice(2);
const times = Number(option('times') ?? 1);
const network = process.argv.includes('--network');
/** So many holds each way are many, and so many steps are soon. */
const MANY = 10, SOON = 3;
/** The date, by which recordings go [ns]. */
const now = () => Date.now() * 1e6;
/** How long the machine below has taken processors away from this one [ms]. */
const stolen = () => 10 * Number(readFileSync('/proc/stat', 'utf8').split('\n')[0].split(/\s+/)[8] ?? 0);
const pause = (time) => new Promise((resolve) => { setTimeout(resolve, time); });
const link = (word) => check(spawnSync('ip', ['link', 'set', 'lo', word]).status === 0, `the link is ${word}`);

const ways = {
  'let go': (page) => page.mouse.up(),
  'the page loses the focus': (page) => page.evaluate(() => { window.dispatchEvent(new Event('blur')); }),
  'the tab is hidden': (page) => page.evaluate(() => {
    Object.defineProperty(document, 'hidden', { value: true, configurable: true });
    document.dispatchEvent(new Event('visibilitychange'));
    setTimeout(() => Object.defineProperty(document, 'hidden', { value: false, configurable: true }), 900);
  }),
  'the page hangs': async (page) => { page.evaluate(() => { const end = Date.now() + 1200; while (Date.now() < end); }).catch(() => {}); },
  'the page is killed': async (page) => { (await page.context().newCDPSession(page)).send('Page.crash').catch(() => {}); },
};
if (network) {
  ways['the link is down'] = async () => { link('down'); setTimeout(() => link('up'), 1000); };
}
const loses = ['the page hangs', 'the page is killed', 'the link is down', 'the tab is hidden'];

/** Holds the button that turns the tool to a side, until it moves; gives the window in which this was, or nothing if it did not move. */
async function trial(page, side, way) {
  const button = page.getByRole('button', { name: `turn Z ${side}`, exact: true });
  await take(page);
  await button.scrollIntoViewIfNeeded();
  const box = await button.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const from = now();
  await page.mouse.down();
  try {
    await until(page, () => window.mrrocPanel.state().held && window.mrrocPanel.state().rate > 0.2, null, 3000);
  } catch {
    await page.mouse.up();
    return null;
  }
  // At any phase of the motion.
  await pause(300 * Math.random());
  const before = stolen();
  await ways[way](page);
  await pause(400);
  const taken = stolen() - before;
  await pause(600);
  return { way, from, to: now(), taken };
}

async function made(browser, folder) {
  const cell = join(folder, 'cell.toml'), recorded = join(folder, 'holds.mcap'), list = join(folder, 'trials.json');
  copyFileSync(cellFile, cell);
  const said = spawnSync(program, ['--cell', cell, '--check'], { encoding: 'utf8' }).stdout;
  const stop = Number(said.match(/suspend and abort keep the path and take up to (\d+) ms/)[1]);
  const cellRuns = await start(program, ['--cell', cell, '--processes', '--panel', '--reduced', '--no-picture', '--record', recorded]);
  const context = await browser.newContext({ viewport: { width: 1280, height: 1000 } });
  const trials = [];
  const open = async () => {
    const page = await context.newPage();
    await page.goto(cellRuns.address);
    await shows(page, ['running', 'suspended', 'idle']);
    return page;
  };
  try {
    let page = await open(), side = 'plus';
    // Its program goes home first.
    for (let i = 0; !(await page.evaluate(() => window.mrrocPanel.state().robots[0].jogs)); i++) {
      check(i < 20, 'the arm may be jogged');
      await take(page);
      await page.locator('#hold').focus();
      await page.keyboard.down(' ');
      await until(page, () => window.mrrocPanel.state().robots[0].jogs, null, 3000).catch(() => {});
      await page.keyboard.up(' ');
    }
    for (const way of Object.keys(ways)) {
      for (let i = 0; i < times; i++) {
        // A cell that has stopped, because this machine was late, does no more; what was done before is tested.
        check((await state(page))?.state !== 'latched', 'the cell runs');
        const done = await trial(page, side, way).catch((error) => { console.error(`panel: ${way}: ${error.message.split('\n')[0]}`); return null; });
        if (done) {
          trials.push(done);
          side = side === 'plus' ? 'minus' : 'plus';
        }
        if (way === 'the page is killed') {
          await page.close();
          page = await open();
        } else {
          if (loses.includes(way)) await pause(600);
          await page.mouse.up();
          await until(page, () => window.mrrocPanel.isOpen(), null, 20000);
        }
      }
    }
  } catch (error) {
    console.error(`panel: holds: ${error.message.split('\n')[0]}; the cell said last: ${cellRuns.said().split('\n').slice(-6).join('\n')}`);
  } finally {
    await context.close();
    await cellRuns.end('SIGINT');
  }
  writeFileSync(list, JSON.stringify(trials));
  const tested = spawnSync(python, [test, recorded, list, stop], { encoding: 'utf8', maxBuffer: 1 << 28 });
  check(tested.status === 0, `it can be tested: ${tested.stderr}`);
  const keep = option('keep');
  if (keep) { copyFileSync(recorded, keep); copyFileSync(list, `${keep}.json`); }
  return { stop, found: JSON.parse(tested.stdout), outcome: cellRuns.outcome() };
}

const browser = await chromium.launch({ executablePath: nicely(browserPath, 5), args: ['--no-sandbox', '--disable-3d-apis', '--disable-gpu'] });
const folder = mkdtempSync(join(tmpdir(), 'mrroc-holds-'));
try {
  const { stop, found, outcome } = await made(browser, folder);
  const all = [];
  for (const way of Object.keys(ways)) {
    const { good, bad, void: nothing } = found[way] ?? { good: [], bad: [], void: [] };
    const worst = (of) => (good.length ? Math.max(...good.map((trial) => trial[of])).toFixed(1) : '-');
    const unmade = times - good.length - bad.length - nothing.length;
    if (unmade > 0) nothing.push(...Array(unmade).fill('the arm was not moved'));
    console.log(`panel: ${way}: ${good.length} of ${times} stood; at most ${worst('steps')} steps, ${worst('fell_ms')} ms until the rate falls, `
      + `${worst('stopped_ms')} ms of ${stop} ms until it is 0${nothing.length ? `; ${nothing.length} void: ${[...new Set(nothing)].join('; ')}` : ''}`);
    if (times >= MANY) bad.push(...good.filter(({ steps, taken }) => steps > SOON && taken === 0).map(({ steps }) => `the rate began to fall ${steps} steps after the hold had ended`));
    for (const why of bad) {
      console.error(`panel: ${way}: ${why}`);
      process.exitCode = 1;
    }
    all.push(...good.map(({ steps }) => steps));
  }
  all.sort((a, b) => a - b);
  console.log(`panel: holds: ${all.length} of ${times * Object.keys(ways).length} tested; the rate began to fall after ${all.join(', ')} steps; the cell ended: ${inWords(outcome)}`);
  if (lateness(outcome)) console.log('panel: not tested, for this machine was late: holds that the cell did not live to see');
  else check(all.length > 0, 'one of the holds can be tested');
  if (all.length) check(all[Math.floor((all.length - 1) / 2)] <= SOON, `half of the holds end within ${SOON} steps: ${all}`);
} finally {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
