// What those who drive the panel in a browser share: the program that is started, facts that must hold, and what pages show.

import { spawn, spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { cpus, loadavg } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const shots = process.env.MRROC_SHOTS;
if (shots) mkdirSync(shots, { recursive: true });
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
/** What a page waits for at most [ms]: this machine may be late. */
export const PATIENCE = 15000;
/** How a browser draws on a machine without a graphics processor. */
export const DRAWING = ['--enable-unsafe-swiftshader'];
/** A judge asks at most so often: a cell that keeps real time may find this machine late. */
const TRIALS = 3;
/** A judge begins nothing again when it has taken so long [ms]: whoever waits for it pays for it. */
const ENOUGH = 120000;
/** Whether it has. */
export const enough = () => performance.now() > ENOUGH;
let held = 0;
export const checks = () => held;

/** A browser that takes the time that a cell on the same processors leaves: one that draws by the processor would make it late. */
export function nicely(browserPath, nice) {
  const path = join(dirname(fileURLToPath(import.meta.url)), `browser-${nice}`);
  writeFileSync(path, `#!/bin/sh\nexec nice -n ${nice} '${browserPath}' "$@"\n`, { mode: 0o755 });
  return path;
}

/**
 * Why this machine cannot judge, or nothing: the cell says that its processes were given too little time, or a browser that draws by the
 * processor shares it with too many others.
 */
export function excuse(said) {
  if (spawnSync('python3', ['tests/peers/late.py'], { input: said }).status === 0) return 'the cell says that this machine was late';
  const load = loadavg()[0] / cpus().length;
  return load > 3 ? `${load.toFixed(1)} tasks wait for each processor of this machine` : '';
}

/** What went wrong, with what the cell said last, which tells whether this machine was late. */
export const told = (error, runs) => new Error(`${error.stack}\nThe cell said last:\n${runs.said().split('\n').slice(-12).join('\n')}`);

/** Judges, again where that fails; what this machine cannot judge is skipped by name, else this process fails. */
export async function judged(what, judge) {
  for (let trial = 1; ; trial++) {
    try {
      return await judge();
    } catch (error) {
      console.error(`panel: ${what}, trial ${trial}: ${error.stack ?? error}`);
      if (trial < TRIALS && !enough()) continue;
      const excused = excuse(error.message);
      if (excused) console.log(`skipped: ${what}: ${excused}`);
      else process.exitCode = 1;
      return undefined;
    }
  }
}

export function check(fact, what) {
  held += 1;
  if (!fact) throw new Error(`not so: ${what}`);
}

/** Starts the program; gives the address that it prints, and how to end it. */
export async function start(program, words, variables = {}) {
  const child = spawn(program, words, { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, ...variables } });
  let said = '';
  const ended = new Promise((resolve) => child.on('close', resolve));
  const address = new Promise((resolve, reject) => {
    const patience = setTimeout(() => {
      child.kill('SIGINT');
      reject(new Error(`no address:\n${said}`));
    }, 60000);
    const hear = (text) => {
      said += text;
      const found = said.match(/panel: (https?:\S+?#token=[0-9a-f]{32})/);
      if (!found) return;
      clearTimeout(patience);
      resolve(found[1]);
    };
    child.stdout.on('data', hear);
    child.stderr.on('data', hear);
    ended.then(() => {
      clearTimeout(patience);
      reject(new Error(`it has ended:\n${said}`));
    });
  });
  return { address: await address, ended, said: () => said, end: (signal = 'SIGTERM') => { child.kill(signal); return ended; } };
}

export const state = (page) => page.evaluate(() => window.mrrocPanel.state());
export const shows = (page, word) => page.waitForFunction(
  (expected) => expected.includes(window.mrrocPanel.state()?.state), [word].flat(), { timeout: PATIENCE, polling: 50 });
/** Waits until a fact of the state holds. */
export const until = (page, fact, argument = null, timeout = PATIENCE) => page.waitForFunction(fact, argument, { timeout, polling: 50 });
export const press = (page, name) => page.getByRole('button', { name, exact: true }).click({ timeout: PATIENCE });
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
