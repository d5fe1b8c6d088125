// A person at the panel jogs an arm, teaches it poses, and lets its program run through them.

import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { DRAWING, TIMEOUT, check, checks, tested, nicely, pressedAgain, shot, shots, shows, start, state, take, told, until, violations } from './kit.mjs';

const [browserPath, program, cellFile] = process.argv.slice(2);
const robot = async (page, name = 'left') => (await state(page)).robots.find((shown) => shown.name === name);
const far = (a, b) => Math.hypot(...[0, 1, 2].map((i) => a.tool[i] - b.tool[i]));
const button = (page, label) => page.getByRole('button', { name: label, exact: true });
const why = (page) => page.locator('#jog-why').textContent();

/** The page says this of the arm, once it has control; a page that has lost that takes it again. */
async function says(page, words) {
  for (let trial = 0; ; trial++) {
    pressedAgain(trial, 6, `the page says ${words}: ${await why(page)}`);
    await take(page);
    const found = await until(page, (expected) => document.getElementById('jog-why').textContent.includes(expected), words, 3000).catch(() => null);
    if (found) return;
  }
}
const stands = (page) => until(page, () => !window.mrrocPanel.state().held && window.mrrocPanel.state().rate === 0);

/** Holds a button by the pointer while `meanwhile` lasts; a page that has lost control meanwhile presses it again. */
async function held(page, label, meanwhile, end = (of) => of.mouse.up()) {
  let failed = '';
  for (let trial = 0; ; trial++) {
    pressedAgain(trial, 12, `${label} is held: ${failed}`);
    try {
      await take(page);
      const place = await button(page, label).boundingBox() ?? (await button(page, label).scrollIntoViewIfNeeded(), await button(page, label).boundingBox());
      await button(page, label).scrollIntoViewIfNeeded();
      const box = await button(page, label).boundingBox() ?? place;
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await page.mouse.down();
      await until(page, () => window.mrrocPanel.state().held, null, 3000);
      const lost = until(page, () => !window.mrrocPanel.state().held, null, 60000).then(() => { throw new Error('the hold was lost'); });
      lost.catch(() => {});
      await Promise.race([meanwhile(), lost]);
      await end(page);
      return;
    } catch (error) {
      if (!page.isClosed()) await page.mouse.up();
      failed = error.message;
      // A cell that has stopped does no more.
      check((await state(page).catch(() => null))?.state !== 'latched', `the cell runs while ${label} is held: ${failed}`);
    }
  }
}

const TABLET = { width: 820, height: 1180 };

/** Holds to run until a fact holds. */
const run = (page, fact, argument) => held(page, 'Hold to run', () => until(page, fact, argument, 30000));

async function jogged(browser, drawingBrowser, folder) {
  const cell = join(folder, 'cell.toml'), recorded = join(folder, 'jog.mcap');
  copyFileSync(cellFile, cell);
  const cellRuns = await start(program, ['--cell', cell, '--processes', '--panel', '--reduced', '--no-picture', '--record', recorded]);
  const size = { viewport: { width: 1280, height: 1000 } };
  const context = await browser.newContext(size);
  const errors = [];
  const open = async (of = context) => {
    const page = await of.newPage();
    page.on('pageerror', (error) => errors.push(error.message));
    await page.goto(cellRuns.address);
    await shows(page, ['running', 'suspended', 'idle']);
    return page;
  };
  try {
    let one = await open();
    const two = await open();

    // What cannot be jogged yet is grey, and says why.
    check(/Take control/.test(await why(two)) && await button(two, 'X plus').isDisabled(), 'without control nothing is jogged');
    // Its program goes home first.
    await says(one, 'No program lets this robot be jogged');
    await run(one, () => window.mrrocPanel.state().robots.find(({ name }) => name === 'left').jogs);
    await stands(one);
    // Then it may be jogged.
    await says(one, 'Hold a button');
    await violations(one);

    // Along the world's x axis as long as the pointer is down, at up to half the speed; then it stands.
    await one.locator('#jog-space').selectOption('world');
    await one.locator('#jog-speed').fill('60');
    let before = await robot(one);
    let fastest = 0;
    await held(one, 'X plus', async () => {
      for (let last = await robot(one), moved = 0; moved < 0.03;) {
        await one.waitForTimeout(60);
        const now = await robot(one);
        if (now.time > last.time) fastest = Math.max(fastest, far(now, last) / (now.time - last.time));
        moved = far(now, before);
        last = now;
      }
    });
    const released = Date.now();
    await stands(two);
    console.log(`panel: a jog that is let go is seen to stand after ${Date.now() - released} ms; ${Math.round(1000 * fastest)} mm/s`);
    const after = await robot(one);
    check(after.tool[0] - before.tool[0] > 0.03 && Math.hypot(after.tool[1] - before.tool[1], after.tool[2] - before.tool[2]) < 5e-4, 'straight along x');
    // Where the tool is stands beside the buttons, in the world or in the frame that is chosen.
    const at = async () => (await one.locator('#jog-place').textContent()).match(/-?\d+\.\d/g).map((number) => Number(number) / 1000);
    check((await at()).every((x, i) => Math.abs(x - after.tool[i]) < 2e-4), `the tool is in the world at ${await at()}`);
    await one.locator('#jog-space').selectOption('frame table');
    const table = await one.evaluate(() => { const { frames, places } = window.mrrocPanel.layout(); return places[frames.indexOf('table')]; });
    const inTable = await at(), apart = [0, 1, 2].map((i) => after.tool[i] - table[i]);
    // A turn about z alone: its axes are those of the world, turned by twice the angle whose sine the quaternion has.
    check(table[3] === 0 && table[4] === 0, 'the table stands upright');
    const turned = 2 * Math.atan2(table[5], table[6]);
    const expected = [
      Math.cos(turned) * apart[0] + Math.sin(turned) * apart[1], Math.cos(turned) * apart[1] - Math.sin(turned) * apart[0], apart[2]];
    check(expected.every((x, i) => Math.abs(x - inTable[i]) < 2e-4), `the tool is at ${inTable} of the table, not at ${expected}`);
    await one.locator('#jog-space').selectOption('world');
    check(fastest > 0.02 && fastest < 0.25, `no faster than 250 mm/s: ${fastest}`);
    check(far(await robot(two, 'right'), await robot(one, 'right')) < 1e-5, 'the other arm stands');

    // An increment ends by itself, and the page says so.
    before = await robot(one);
    await one.locator('#jog-step').selectOption('2');
    await one.locator('#jog-speed').fill('100');
    await held(one, 'Z minus', () => until(one, () => window.mrrocPanel.state().robots[0].stop.includes('there')));
    check(Math.abs(far(await robot(one), before) - 0.005) < 2e-4, `5 mm: ${far(await robot(one), before)}`);

    // Outputs are switched while the arm stands; no button starts a tool.
    const reads = (name, value) => until(two, ([of, expected]) => {
      const row = [...document.querySelectorAll('#signals tr')].find(({ cells }) => cells[0].textContent === of);
      return row?.cells[3].textContent === expected;
    }, [name, value]);
    before = await robot(one);
    for (const value of ['on', 'off', 'on']) {
      await held(one, `gripper ${value}`, () => reads('left gripper', value));
      await reads('left gripped', value);
      check(await button(two, `gripper ${value}`).getAttribute('aria-pressed') === 'true', `the gripper is ${value}, and stays so`);
    }
    await take(one);
    await button(one, 'spindle on').focus();
    await one.keyboard.down(' ');
    await until(one, () => document.getElementById('jog-why').textContent.includes('drives a tool'));
    await one.keyboard.up(' ');
    await reads('left spindle', 'off');
    check((await robot(one)).demanded.every((q, i) => q === before.demanded[i]), 'no arm moves because an output is switched');

    // However the hold ends, the arm stands.
    await one.locator('#jog-step').selectOption('0');
    await one.locator('#jog-speed').fill('20');
    const ways = {
      'the page loses the focus': (page) => page.evaluate(() => window.dispatchEvent(new Event('blur'))),
      'the tab is hidden': (page) => page.evaluate(() => {
        Object.defineProperty(document, 'hidden', { value: true, configurable: true });
        document.dispatchEvent(new Event('visibilitychange'));
        Object.defineProperty(document, 'hidden', { value: false, configurable: true });
      }),
      'the connection is cut': (page) => page.evaluate(() => window.mrrocPanel.cut()),
      'the page hangs': async (page) => { page.evaluate(() => { const end = Date.now() + 1500; while (Date.now() < end); }); },
      'the page is killed': (page) => page.close(),
    };
    let side = 'plus';
    for (const [way, end] of Object.entries(ways)) {
      let began = 0;
      before = await robot(two);
      await held(one, `turn Z ${side}`, () => until(one, () => window.mrrocPanel.state().rate > 0.5), async (page) => { began = Date.now(); await end(page); });
      await stands(two);
      console.log(`panel: a jog, ${way}: seen to stand after ${Date.now() - began} ms`);
      check(true, way);
      if (one.isClosed()) {
        one = await open();
        await one.locator('#jog-space').selectOption('world');
        await one.locator('#jog-speed').fill('20');
      } else {
        if (way === 'the page hangs') await one.waitForTimeout(1600);
        await one.mouse.up();
        await until(one, () => window.mrrocPanel.isOpen());
      }
      side = side === 'plus' ? 'minus' : 'plus';
    }

    // Three poses, taught by name; the file is for people and programs.
    const poses = {};
    for (const [name, label, step] of [['a', 'Y plus', '3'], ['b', 'Z minus', '3'], ['c', 'turn Z plus', '3']]) {
      await one.locator('#jog-step').selectOption(step);
      await one.locator('#jog-speed').fill('100');
      await held(one, label, () => until(one, () => window.mrrocPanel.state().robots[0].stop.includes('there')));
      await stands(one);
      for (let trial = 0; !(await one.locator(`[data-pose="${name}"]`).count()); trial++) {
        pressedAgain(trial, 12, `${name} is taught`);
        await take(one);
        await one.waitForTimeout(200);
        await one.locator('#pose-name').fill(name);
        await button(one, 'Teach').click({ timeout: 3000 }).catch(() => {});
        await one.waitForTimeout(400);
      }
      poses[name] = (await robot(one)).demanded;
    }
    const text = readFileSync(join(folder, 'poses', 'left.txt'), 'utf8');
    check(/^a = 0\.5 0\.5 : /m.test(text) && /^c = /m.test(text), `the file has them: ${text}`);
    await two.locator('[data-pose="c"]').waitFor({ timeout: TIMEOUT });

    // Back to the first one: its way is shown, then held.
    for (let trial = 0; await one.locator('[data-pose="a"]').isDisabled(); trial++) {
      pressedAgain(trial, 12, 'the path to a is shown');
      await take(one);
      await button(one, 'Path: a').click({ timeout: 3000 }).catch(() => {});
      await one.waitForTimeout(500);
    }
    await held(one, 'Go, held: a', () => until(one, () => window.mrrocPanel.state().robots[0].stop.includes('there'), null, 30000));
    const there = (await robot(one)).demanded;
    check(there.every((q, i) => Math.abs(q - poses.a[i]) < 1e-5), `at a: ${there}, ${poses.a}`);
    await one.emulateMedia({ colorScheme: 'dark' });
    await violations(one);
    await one.emulateMedia({ colorScheme: null });
    // What stops, what runs while it is held, and the cell's answers are in reach on a tablet, however far its page is scrolled.
    await one.setViewportSize(TABLET);
    await one.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
    const inReach = await one.evaluate(() => ['stop', 'hold', 'answer'].every((id) => {
      const { left, right, top, bottom } = document.getElementById(id).getBoundingClientRect();
      return left >= 0 && right <= innerWidth && top >= 0 && bottom <= innerHeight;
    }));
    check(inReach, 'Stop, Hold to run and the answer are in reach on a tablet');
    await one.setViewportSize(size.viewport);
    if (shots) {
      const drawn = await drawingBrowser.newPage({ viewport: { width: 1280, height: 1000 } });
      await drawn.goto(cellRuns.address);
      await drawn.waitForFunction(() => window.mrrocPanel.state()?.robots.length === 2, null, { timeout: 4 * TIMEOUT });
      await one.close();
      await take(drawn);
      await drawn.getByRole('button', { name: 'Path: c', exact: true }).click();
      await drawn.waitForTimeout(3000);
      await drawn.locator('#jog').scrollIntoViewIfNeeded();
      await shot(drawn, 'jog');
      await drawn.setViewportSize(TABLET);
      await drawn.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
      await shot(drawn, 'jog-tablet');
      await drawn.setViewportSize(size.viewport);
      await drawn.emulateMedia({ colorScheme: 'dark' });
      await drawn.waitForTimeout(2000);
      await shot(drawn, 'jog-dark');
      await drawn.close();
      one = await open();
    }

    // Another name, and one forgotten.
    for (let trial = 0; !(await one.locator('[data-pose="end"]').count()); trial++) {
      pressedAgain(trial, 12, 'c has another name');
      await take(one);
      await one.locator('#pose-name').fill('end');
      await button(one, 'Rename: c').click({ timeout: 3000 }).catch(() => {});
      await one.waitForTimeout(500);
    }

    // Done: the program goes through them, held, and comes home again.
    for (let trial = 0; (await robot(one)).jogs; trial++) {
      pressedAgain(trial, 12, 'the program goes on');
      await take(one);
      await button(one, 'Done: the program goes on').click({ timeout: 3000 }).catch(() => {});
      await one.waitForTimeout(500);
    }
    const seen = await one.evaluate(() => {
      window.seen = [];
      window.watching = setInterval(() => window.seen.push(window.mrrocPanel.state().robots[0].demanded), 20);
    });
    check(seen === undefined, 'it is watched');
    await run(one, () => window.mrrocPanel.state().robots[0].doing.includes('Replay'));
    await run(one, () => window.mrrocPanel.state().robots[0].doing.includes('PanelJog'));
    const passed = await one.evaluate(() => { clearInterval(window.watching); return window.seen; });
    let from = 0;
    for (const name of ['a', 'b', 'c']) {
      const at = passed.findIndex((q, i) => i >= from && q.every((x, j) => Math.abs(x - poses[name][j]) < 5e-3));
      check(at >= 0, `the program comes to ${name}`);
      from = at;
    }

    check(errors.length === 0, `no error on a page: ${errors.join('; ')}`);
  } catch (error) {
    throw await told(error, cellRuns);
  } finally {
    await context.close();
    await cellRuns.end('SIGINT');
  }
  const replayed = spawnSync(program, ['--cell', cell, '--no-picture', 'replay', recorded, '--partial'], { encoding: 'utf8' });
  check(replayed.status === 0, `the demands of the recording, with all its jogs, are the same to the bit: ${replayed.stdout}${replayed.stderr}`);
}

/** A stop while an arm is jogged; after the reset its program starts again. */
async function stopped(browser, folder) {
  const cell = join(folder, 'cell.toml');
  const cellRuns = await start(program, ['--cell', cell, '--processes', '--panel', '--reduced', '--no-picture']);
  const context = await browser.newContext({ viewport: { width: 1280, height: 1000 } });
  try {
    const [one, two] = [await context.newPage(), await context.newPage()];
    for (const page of [one, two]) {
      await page.goto(cellRuns.address);
      await shows(page, ['running', 'suspended', 'idle']);
    }
    await take(one);
    await run(one, () => window.mrrocPanel.state().robots[0].jogs);
    await one.locator('#jog-space').selectOption('world');
    await held(one, 'Y plus', () => until(one, () => window.mrrocPanel.state().rate > 0.3), (page) => page.keyboard.press('Escape'));
    await one.mouse.up();
    await shows(two, 'latched');
    await until(two, () => /Nothing can be jogged: the cell is latched|Take control/.test(document.getElementById('jog-why').textContent));
    for (const [name, word] of [['Acknowledge', 'acknowledged'], ['Reset', 'suspended']]) {
      for (let trial = 0; (await state(one)).state !== word; trial++) {
        pressedAgain(trial, 12, `${name} makes the cell ${word}; it is ${(await state(one)).state}`);
        await take(one);
        await button(one, name).click({ timeout: 3000 }).catch(() => {});
        await until(one, (expected) => window.mrrocPanel.state().state === expected, word, 3000).catch(() => {});
      }
    }
    await run(one, () => window.mrrocPanel.state().robots[0].jogs);
    check(true, 'after the reset it may be jogged again');
  } catch (error) {
    throw await told(error, cellRuns);
  } finally {
    await context.close();
    await cellRuns.end('SIGINT');
  }
}

const launch = (nice, args) => chromium.launch({ executablePath: nicely(browserPath, nice), args: ['--no-sandbox', ...args] });
const plain = await launch(5, ['--disable-3d-apis', '--disable-gpu']);
const drawing = await launch(19, DRAWING);
try {
  await tested('jog and teach in a browser', async () => {
    const folder = mkdtempSync(join(tmpdir(), 'mrroc-jog-'));
    try {
      const began = Date.now();
      await jogged(plain, drawing, folder);
      await stopped(plain, folder);
      console.log(`panel: jog and teach: ${checks()} facts hold (${((Date.now() - began) / 1000).toFixed(0)} s)`);
    } finally {
      rmSync(folder, { recursive: true, force: true });
    }
  });
} finally {
  await Promise.all([plain.close(), drawing.close()]);
}
