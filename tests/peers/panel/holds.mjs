// How soon an arm stands that is jogged, however its hold ends: as often as `MRROC_HOLDS` says each (1), judged from recordings by
// holds.py. Where it has a network of its own (`network` as the last argument), the link to the page is taken down as well.

import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { check, enough, nicely, shows, start, state, take, until } from './kit.mjs';

const [browserPath, program, cellFile, python, judge, network] = process.argv.slice(2);
const times = Number(process.env.MRROC_HOLDS ?? 1);
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
/** How often a hold is tried whose rate began to fall too late. The panel's threads do not keep real time, and this machine is shared; of
 *  many holds each one counts. */
const ASKED = times < 10 ? 3 : 1;
const late = (why) => /began to fall \d+ steps after/.test(why);
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

async function round(browser, wanted, folder) {
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
    for (const [way, count] of Object.entries(wanted)) {
      for (let i = 0, tried = 0; i < count && tried < 3 * count; tried++) {
        // A cell that has stopped, because this machine was late, does no more; what was done before is judged.
        check((await state(page))?.state !== 'latched', 'the cell runs');
        const done = await trial(page, side, way).catch((error) => { console.error(`panel: ${way}: ${error.message.split('\n')[0]}`); return null; });
        if (done) {
          trials.push(done);
          i += 1;
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
  const judged = spawnSync(python, [judge, recorded, list, stop], { encoding: 'utf8', maxBuffer: 1 << 28 });
  check(judged.status === 0, `it can be judged: ${judged.stderr}`);
  if (process.env.MRROC_KEEP) { copyFileSync(recorded, process.env.MRROC_KEEP); copyFileSync(list, `${process.env.MRROC_KEEP}.json`); }
  return { stop, found: JSON.parse(judged.stdout) };
}

const browser = await chromium.launch({ executablePath: nicely(browserPath, 5), args: ['--no-sandbox', '--disable-3d-apis', '--disable-gpu'] });
const all = Object.fromEntries(Object.keys(ways).map((way) => [way, { good: [], bad: [], again: [], void: [] }]));
try {
  // Trials of which nothing can be said are made again.
  for (let rounds = 0; rounds < 4 + times; rounds++) {
    const wanted = Object.fromEntries(Object.entries(all).map(([way, { good, bad }]) => [way, times - good.length - bad.length]).filter(([, count]) => count > 0));
    if (Object.keys(wanted).length === 0 || (times < 10 && enough())) break;
    const folder = mkdtempSync(join(tmpdir(), 'mrroc-holds-'));
    try {
      const { stop, found } = await round(browser, wanted, folder);
      for (const [way, { good, bad, void: nothing }] of Object.entries(found)) {
        all[way].good.push(...good);
        for (const why of bad) {
          const { again } = all[way];
          (late(why) && again.length + 1 < ASKED ? again : all[way].bad).push(why);
        }
        all[way].void.push(...nothing);
        all[way].stop = stop;
      }
    } catch (error) {
      console.error(`panel: holds, round ${rounds + 1}: ${error.stack ?? error}`);
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
  }
} finally {
  await browser.close();
}
let ok = true, left = 0;
for (const [way, { good, bad, again, void: nothing, stop }] of Object.entries(all)) {
  // Nothing says that it was this machine if it never went well.
  if (good.length === 0) bad.push(...again.splice(0));
  const worst = (of) => Math.max(...good.map((trial) => trial[of])).toFixed(1);
  console.log(`panel: ${way}: ${good.length} of ${good.length + bad.length} in time; at most ${Math.max(...good.map(({ steps }) => steps))} steps, ${worst('fell_ms')} ms until the rate falls, `
    + `${worst('stopped_ms')} ms of ${stop} ms until it is 0${nothing.length ? `; ${nothing.length} more not judged: ${[...new Set(nothing)].join('; ')}` : ''}`);
  bad.forEach((why) => console.log(`panel: ${way}: ${why}`));
  again.forEach((why) => console.log(`panel: ${way}: tried again: ${why}`));
  ok &&= bad.length === 0;
  left += times - good.length - bad.length;
}
if (!ok) process.exitCode = 1;
else if (left > 0) console.log(`skipped: ${left} holds on the panel: this machine was late by more than the cell bears`);
