// What those who drive the panel in a browser share: the program that is started, facts that must hold, and what pages show.

import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

/** The value of an option of the test, `--shots FOLDER`. */
export const option = (name) => (process.argv.includes(`--${name}`) ? process.argv[process.argv.indexOf(`--${name}`) + 1] : undefined);
/** Where pictures are kept. */
export const shots = option('shots');
if (shots) mkdirSync(shots, { recursive: true });
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
/** What a page waits for at most [ms]: this machine may be late. */
export const TIMEOUT = 15000;
/** How a browser draws on a machine without a graphics processor. */
export const DRAWING = ['--enable-unsafe-swiftshader'];
let held = 0;
export const checks = () => held;

/** A browser that takes the time that a cell on the same processors leaves: one that draws by the processor would make it late. */
export function nicely(browserPath, nice) {
  const path = join(dirname(fileURLToPath(import.meta.url)), `browser-${nice}`);
  writeFileSync(path, `#!/bin/sh\nexec nice -n ${nice} '${browserPath}' "$@"\n`, { mode: 0o755 });
  return path;
}

/** Faults that a cell has whose machine is late: a process waited for another one for too long, or missed too many of its own steps. */
const LATENESS = ['PeerLost', 'Overrun'];
/** The fault that has ended or stopped a cell, where it is that of a late machine. */
export const lateness = (outcome) => (LATENESS.includes(outcome?.fault?.kind) ? outcome.fault : null);
/** How a run ended, with the figures of how late it was. */
export const inWords = (outcome) => (outcome
  ? `${outcome.fault?.kind ?? 'no fault'}: ${outcome.fault?.text ?? ''} (${outcome.steps} steps, ${outcome.skipped} periods left out, the longest stall was ${(1e3 * outcome.longest_stall).toFixed(1)} ms)`
  : 'no outcome');

/** What went wrong, with how the cell ended, which it is made to do, and what it said last. */
export async function told(error, runs) {
  await runs.end('SIGINT');
  const outcome = runs.outcome();
  return Object.assign(new Error(`${error.stack}\nThe cell ended: ${inWords(outcome)}\nIt said last:\n${runs.said().split('\n').slice(-12).join('\n')}`), { outcome });
}

/**
 * Tests, once. A cell in real time that a late machine stopped has done what it must: what it could not show is told by name. Whatever else
 * falls short ends this process with a failure.
 */
export async function tested(what, test) {
  try {
    return await test();
  } catch (error) {
    if (lateness(error.outcome)) console.log(`panel: not tested, for this machine was late: ${what} after ${held} facts: ${inWords(error.outcome)}`);
    else {
      console.error(`panel: ${what}: ${error.stack ?? error}`);
      process.exitCode = 1;
    }
    return undefined;
  } finally {
    if (again) console.log(`panel: ${what}: ${again} times a page pressed once more, for it had lost control or the cell did not do it at once`);
  }
}

let again = 0;
/** A person presses once more what a page that had lost control, for the browser was late, did not do; it is counted. */
export function pressedAgain(trial, most, what) {
  check(trial < most, what);
  again += trial > 0;
}

export function check(fact, what) {
  held += 1;
  if (!fact) throw new Error(`not so: ${what}`);
}

/** Starts the program, with options of its own; gives the address that it prints, how to end it, and how it ended. */
export async function start(program, words, { own = [], variables = {} } = {}) {
  const file = join(mkdtempSync(join(tmpdir(), 'mrroc-outcome-')), 'outcome.json');
  const outcome = words[0] === 'panel' ? [] : ['--outcome', file];
  const child = spawn(program, [...words, ...outcome, '--', ...own], { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, ...variables } });
  let said = '';
  const ended = new Promise((resolve) => child.on('close', resolve));
  const address = new Promise((resolve, reject) => {
    const timeout = setTimeout(() => {
      child.kill('SIGINT');
      reject(new Error(`no address:\n${said}`));
    }, 60000);
    const hear = (text) => {
      said += text;
      const found = said.match(/panel: (https?:\S+?#token=[0-9a-f]{32})/);
      if (!found) return;
      clearTimeout(timeout);
      resolve(found[1]);
    };
    child.stdout.on('data', hear);
    child.stderr.on('data', hear);
    ended.then(() => {
      clearTimeout(timeout);
      reject(new Error(`it has ended:\n${said}`));
    });
  });
  return { address: await address, ended, said: () => said, end: (signal = 'SIGTERM') => { child.kill(signal); return ended; },
    outcome: () => (existsSync(file) ? JSON.parse(readFileSync(file, 'utf8')) : null) };
}

export const state = (page) => page.evaluate(() => window.mrrocPanel.state());
export const shows = (page, word) => page.waitForFunction(
  (expected) => expected.includes(window.mrrocPanel.state()?.state), [word].flat(), { timeout: TIMEOUT, polling: 50 });
/** Waits until a fact of the state holds. */
export const until = (page, fact, argument = null, timeout = TIMEOUT) => page.waitForFunction(fact, argument, { timeout, polling: 50 });
export const press = (page, name) => page.getByRole('button', { name, exact: true }).click({ timeout: TIMEOUT });
export const shot = async (page, name) => {
  // A picture that this machine has no time for is no fault of the panel.
  if (shots) await page.screenshot({ path: join(shots, `${name}.png`) }).catch((error) => console.log(`panel: no picture ${name}: ${error.message.split('\n')[0]}`));
};

/** Control, once more where a page was silent for too long because this machine was. */
export async function take(page) {
  for (let i = 0; i < 5; i++) {
    if (await page.getByText('You have control.').isVisible()) return;
    await page.locator('#take').click();
    await page.waitForTimeout(200);
  }
}

export async function violations(page) {
  await page.evaluate(axe);
  const { violations: found } = await page.evaluate(() => window.axe.run());
  check(found.length === 0, `accessible: ${found.map(({ id, nodes }) => `${id} at ${nodes.map(({ target }) => target)}`).join('; ')}`);
}
