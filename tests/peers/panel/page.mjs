// Drives two pages of the panel of a cell that runs, as an operator, as one who looks on, and as one who means harm.

import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer, request } from 'node:http';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { DRAWING, TIMEOUT, check, checks, tested, nicely, press, pressedAgain, shot, shots, shows, start as started, state, take, told, violations } from './kit.mjs';
import { lastLink, multiply } from './urdf.mjs';

const [browserPath, program, cell] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'mrroc-panel-'));
const start = (words, own) => started(program, words, { own });
/** A connection from the origin of a page: sends frames, and tells what came and how it was closed. */
const connection = (page, frames, token, time = 1500) => page.evaluate(async ([sent, secret, wait]) => {
  const socket = new WebSocket(`ws://${location.host}/connect`), came = [];
  let closed = null;
  socket.onmessage = ({ data }) => came.push(JSON.parse(data));
  socket.onclose = ({ code, reason }) => { closed = { code, reason }; };
  await new Promise((resolve) => { socket.onopen = resolve; socket.onerror = resolve; });
  if (secret) socket.send(JSON.stringify({ token: secret }));
  for (const frame of sent) {
    const { repeat = 1, fill, bytes } = frame ?? {};
    for (let i = 0; i < repeat; i++) {
      if (socket.readyState !== WebSocket.OPEN) break;
      socket.send(bytes ? new Uint8Array(bytes) : fill ? 'x'.repeat(fill) : typeof frame === 'string' ? frame : JSON.stringify(frame.say));
    }
  }
  const until = performance.now() + wait;
  while (performance.now() < until && !closed) await new Promise((resolve) => setTimeout(resolve, 20));
  socket.close();
  return { closed, came: came.filter(({ kind }) => kind !== 'state').slice(0, 40), states: came.filter(({ kind }) => kind === 'state').length };
}, [frames, token, time]);

/** The answer to a plain request, with these headers. */
const plain = (address, { method = 'GET', path = '/', headers = {} } = {}) => new Promise((resolve, reject) => {
  const { hostname, port } = new URL(address);
  const asked = request({ hostname, port, path, method, headers }, (answer) => {
    answer.resume();
    answer.on('end', () => resolve({ status: answer.statusCode, headers: answer.headers }));
  });
  asked.on('upgrade', (answer, socket) => { socket.destroy(); resolve({ status: answer.statusCode, headers: answer.headers }); });
  asked.on('error', reject);
  asked.end();
});

async function operate(browser, plainBrowser) {
  const file = join(folder, 'live.mcap');
  const cellRuns = await start(['--cell', cell, '--processes', '--panel', '--no-picture', '--record', file]);
  const { address } = cellRuns;
  const [origin, token] = address.split('/#token=');
  const size = { viewport: { width: 1280, height: 800 } };
  // What is drawn by the processor is small, unless somebody wants to look at it.
  const drawn = shots ? size : { viewport: { width: 1024, height: 600 } };
  const [context, plainContext] = [await browser.newContext(drawn), await plainBrowser.newContext(size)];
  const errors = [], asked = new Set();
  const open = async (of = plainContext, word = ['running', 'suspended']) => {
    const page = await of.newPage();
    page.on('pageerror', (error) => errors.push(error.message));
    page.on('console', (message) => { if (message.type() === 'error' && of === context) errors.push(message.text()); });
    page.on('request', (of) => asked.add(new URL(of.url()).host));
    await page.goto(address);
    await shows(page, word);
    return page;
  };
  try {
    let one = await open();
    const two = await open();
    check(!(await one.evaluate(() => location.href)).includes(token), 'the token is not left in the address');

    // One page has control, and no other one can take it.
    await onlyOne(one, two, token);

    // It operates; what is asked for an old step is refused.
    await does(one, 'Suspend', 'suspended');
    await one.waitForFunction(() => window.mrrocPanel.state().rate === 0, null, { timeout: TIMEOUT, polling: 50 });
    check(await one.getByRole('button', { name: 'Suspend' }).getAttribute('aria-pressed') === 'true', 'the button shows the robots\' state');

    // A third page, which draws, looks on while nothing moves.
    const three = await open(context, 'suspended');
    await look(three, 'suspended');
    await three.close();
    await violations(two);

    await does(one, 'Resume', 'running');
    for (let trial = 0; (await state(one)).speed !== 0.5; trial++) {
      pressedAgain(trial, 5, 'the speed is set by keys');
      await take(one);
      await one.locator('#speed').fill('50');
      await one.waitForTimeout(500);
    }
    await two.getByText('50 %').first().waitFor({ timeout: TIMEOUT });

    one = await holds(one, two, open);

    // Any page stops the cell.
    await two.keyboard.press('Escape');
    await shows(one, 'latched');
    await two.getByText('Stopped: first cause').waitFor({ timeout: TIMEOUT });
    await shot(two, 'stopped');
    const old = await state(one);
    await does(one, 'Acknowledge', 'acknowledged');
    await does(one, 'Reset', 'running');
    await one.waitForFunction((before) => window.mrrocPanel.state().epoch === before + 1, old.epoch, { timeout: TIMEOUT, polling: 50 });
    await take(one);
    const stale = await one.evaluate(async ({ epoch: was }) => {
      const newest = window.mrrocPanel.state();
      const ask = (stamp) => window.mrrocPanel.ask({ do: 'suspend', ...stamp });
      return [await ask({ epoch: was, step: newest.step }), await ask({ epoch: newest.epoch, step: Math.max(0, newest.step - 5000) })];
    }, old);
    check(stale.every(({ outcome }) => outcome === 'refused'), `what is asked for before a reset or long ago is refused: ${JSON.stringify(stale)}`);

    await harm(two, address, origin, token, plainBrowser);
    check((await state(one)).state === 'running', 'the cell runs on');
    check(errors.length === 0, `no error on a page: ${errors.join('; ')}`);
    check([...asked].every((host) => origin.endsWith(host)), `no request leaves for elsewhere: ${[...asked]}`);
  } catch (error) {
    throw await told(error, cellRuns);
  } finally {
    await Promise.all([context.close(), plainContext.close()]);
    await cellRuns.end('SIGINT');
  }
  check(!cellRuns.said().replace(address, '').includes(token), 'the token is printed once');
  return file;
}

/** One page has control: another one can neither take it nor operate. */
async function onlyOne(one, two, token) {
  await take(one);
  await two.getByText(/Page \d+ has control\./).waitFor({ timeout: TIMEOUT });
  check(await two.getByRole('button', { name: 'Suspend' }).isDisabled(), 'a page without control cannot suspend');
  await two.locator('#take').click({ timeout: TIMEOUT });
  await two.getByText(/refused: page \d+ has control/).waitFor({ timeout: TIMEOUT });
  await take(one);
  const { epoch, step } = await state(two);
  const { came } = await connection(two, [{ say: { n: 5, do: 'suspend', epoch, step } }], token);
  check(came.some(({ n, outcome }) => n === 5 && outcome === 'refused'), 'a message of a page without control is refused');
}

/** Presses a button until the cell is in a state. */
async function does(page, name, word) {
  for (let trial = 0; (await state(page)).state !== word; trial++) {
    pressedAgain(trial, 5, `${name} makes the cell ${word}; it is ${(await state(page)).state}`);
    await take(page);
    await page.getByRole('button', { name, exact: true }).click({ timeout: 3000 }).catch(() => {});
    await page.waitForFunction((expected) => window.mrrocPanel.state().state === expected, word, { timeout: 3000, polling: 50 }).catch(() => {});
  }
}

/** The tool of each arm is drawn where its URDF says, within two pixels. */
async function look(page, name) {
  const status = execFileSync(program, ['status', '--cell', cell], { encoding: 'utf8' });
  const transposed = (list) => [0, 1, 2, 3].map((row) => [0, 1, 2, 3].map((column) => list[4 * column + row]));
  const box = await page.locator('#scene').boundingBox();
  // Nothing moves: the picture is that of the robots where two of them, half a second apart, show the same.
  let found;
  for (let before = null, trial = 0; ; before = JSON.stringify(found), trial++) {
    found = await page.evaluate(() => window.mrrocPanel.marks());
    if (found.length === 2 && JSON.stringify(found) === before) break;
    check(trial < 30, `two tools are drawn, and stand: ${JSON.stringify(found)}`);
    await page.waitForTimeout(500);
  }
  const { view, projection } = await page.evaluate(() => window.mrrocPanel.camera());
  for (const robot of ['left', 'right']) {
    const measured = status.match(new RegExp(`^${robot} at[^]*?measured([^\\n]*)`, 'm'))[1].trim().split(/\s+/).map(Number);
    const urdf = execFileSync(program, ['export-urdf', robot, '--cell', cell], { encoding: 'utf8' });
    // The URDF of a robot contains its base and its tool.
    const at = lastLink(urdf, measured);
    const [x, y, , w] = multiply(multiply(transposed(projection), transposed(view)), [0, 1, 2, 3].map((i) => [at[i][3]])).flat();
    const pixel = [box.width * (0.5 + (0.5 * x) / w), box.height * (0.5 - (0.5 * y) / w)];
    const far = Math.min(...found.map((mark) => Math.hypot(mark[0] - pixel[0], mark[1] - pixel[1])));
    console.log(`panel: the tool of ${robot} is drawn ${far.toFixed(2)} px from its projection`);
    check(far < 2, `the tool of ${robot} is within 2 px: ${far}, ${JSON.stringify(found)}, ${pixel}`);
  }
  await shot(page, name);
}

/** Switches reduced speed. */
async function reduced(page, on) {
  for (let trial = 0; (await state(page)).reduced !== on; trial++) {
    pressedAgain(trial, 5, 'reduced speed is switched');
    await take(page);
    await press(page, 'Reduced speed');
    await page.waitForTimeout(500);
  }
}

/** At reduced speed robots move only while the button is held; gives a page that is still there. */
async function holds(one, two, open) {
  await reduced(one, true);
  await one.waitForFunction(() => window.mrrocPanel.state().rate === 0, null, { timeout: TIMEOUT, polling: 50 });
  const moving = () => two.waitForFunction(() => window.mrrocPanel.state().held && window.mrrocPanel.state().rate > 0, null, { timeout: 4000, polling: 50 });
  const standing = () => two.waitForFunction(() => !window.mrrocPanel.state().held && window.mrrocPanel.state().rate === 0, null, { timeout: 4000, polling: 50 });
  const ways = {
    'the key is let go': async (page) => page.keyboard.up(' '),
    'the page loses the focus': async (page) => page.evaluate(() => window.dispatchEvent(new Event('blur'))),
    'the connection is cut': async (page) => page.evaluate(() => window.mrrocPanel.cut()),
    'the page hangs': async (page) => { page.evaluate(() => { const end = Date.now() + 1500; while (Date.now() < end); }); },
    'the page is closed': async (page) => page.close(),
  };
  let page = one;
  for (const [way, end] of Object.entries(ways)) {
    // A page that was silent for too long has lost control, and takes it again.
    for (let trial = 0; ; trial++) {
      pressedAgain(trial, 5, `robots move while the button is held: ${way}`);
      try {
        if (page.isClosed()) page = await open();
        await page.bringToFront();
        await take(page);
        await page.locator('#hold').focus();
        await page.keyboard.down(' ');
        await moving();
        break;
      } catch {
        await page.keyboard.up(' ');
      }
    }
    const began = Date.now();
    await end(page);
    await standing();
    console.log(`panel: ${way}: seen to stand after ${Date.now() - began} ms`);
    check(true, way);
    if (!page.isClosed()) await page.keyboard.up(' ');
    if (way === 'the page hangs') await page.waitForTimeout(1500);
    if (way === 'the page is closed') break;
    await page.waitForFunction(() => window.mrrocPanel.isOpen(), null, { timeout: TIMEOUT, polling: 50 });
  }
  const last = await open();
  await reduced(last, false);
  await does(last, 'Resume', 'running');
  return last;
}

/** What harms nobody: pages of others, messages that are none, floods, crowds. */
async function harm(page, address, origin, token, browser) {
  const host = origin.slice('http://'.length);
  const upgrade = { connection: 'Upgrade', upgrade: 'websocket', 'sec-websocket-version': '13', 'sec-websocket-key': 'dGhlIHNhbXBsZSBub25jZQ==' };
  check((await plain(address)).status === 200, 'the page is there');
  check((await plain(address)).headers['content-security-policy'].startsWith("default-src 'self'"), 'with a policy');
  for (const [what, asked] of Object.entries({
    'another host': { headers: { host: 'evil.example' } },
    'a connection without an origin': { path: '/connect', headers: { ...upgrade, host } },
    'a connection of another origin': { path: '/connect', headers: { ...upgrade, host, origin: 'http://evil.example' } },
    'a connection of an opaque origin': { path: '/connect', headers: { ...upgrade, host, origin: 'null' } },
    'a connection by another name': { path: '/connect', headers: { ...upgrade, host: 'evil.example', origin: 'http://evil.example' } },
  })) check((await plain(address, asked)).status === 403, `${what} is refused`);
  check((await plain(address, { method: 'POST' })).status === 405, 'what would change something is refused');
  check((await plain(address, { path: '/connect', headers: { ...upgrade, host, origin } })).status === 101, 'the panel\'s own page connects');

  // A page of another origin, in the same browser.
  const other = createServer((_, answer) => answer.end('<!doctype html><title>other</title>')).listen(0, '127.0.0.1');
  await new Promise((resolve) => { other.once('listening', resolve); });
  const foreign = await browser.newPage();
  await foreign.goto(`http://127.0.0.1:${other.address().port}/`);
  const opened = await foreign.evaluate((to) => new Promise((resolve) => {
    const socket = new WebSocket(`ws://${to}/connect`);
    socket.onopen = () => resolve('open');
    socket.onclose = () => resolve('closed');
  }), host);
  check(opened === 'closed', 'a page of another origin cannot connect');
  await foreign.close();
  other.close();

  const wrong = await connection(page, [], '0'.repeat(32));
  check(wrong.states === 0 && wrong.closed?.code === 1008, `without the token nothing is shown: ${JSON.stringify(wrong)}`);
  check((await connection(page, [{ say: { do: 'stop' } }], null)).came.length === 0, 'and nothing is done');
  for (const [what, frames] of Object.entries({
    'a huge message': [{ fill: 1 << 20 }],
    'what is no text': [{ bytes: [0, 255, 1] }],
    'messages that are none': [{ repeat: 20, fill: 30 }],
    'a flood': [{ repeat: 5000, say: { do: 'beat' } }],
  })) {
    const { closed } = await connection(page, frames, token);
    check(closed !== null, `${what}: is disconnected`);
  }
  const crowd = await page.evaluate(async (secret) => {
    const sockets = Array.from({ length: 50 }, () => new WebSocket(`ws://${location.host}/connect`));
    let shown = 0;
    sockets.forEach((socket) => {
      socket.onopen = () => socket.send(JSON.stringify({ token: secret }));
      socket.onmessage = ({ data }) => { if (JSON.parse(data).kind === 'layout') shown += 1; };
    });
    await new Promise((resolve) => setTimeout(resolve, 2500));
    sockets.forEach((socket) => socket.close());
    return shown;
  }, token);
  check(crowd > 0 && crowd <= 32, `of a crowd of fifty no more than 32 look on: ${crowd}`);
  // Five hundred that connect and say nothing, or begin a request that they do not end.
  const { hostname, port } = new URL(origin);
  const idle = Array.from({ length: 500 }, (_, i) => {
    const socket = connect(Number(port), hostname, () => { if (i % 2) socket.write('GET / HTTP/1.1\r\nHost: '); });
    return socket.on('error', () => {});
  });
  const before = (await state(page)).step;
  await page.waitForTimeout(1500);
  check((await state(page)).step > before + 100, 'a page is shown what the cell does beside five hundred connections');
  idle.forEach((socket) => socket.destroy());
}

/** A run that is over is played, and a panel changes nothing in a run on the memory link. */
async function play(browser, plainBrowser, recorded) {
  const turns = ['--turns', '1'];
  const files = ['without', 'with'].map((name) => join(folder, `${name}.mcap`));
  const run = (words, own = turns) => spawnSync(program, ['--cell', cell, '--no-picture', ...words, '--', ...own], { encoding: 'utf8' });
  check(run(['--record', files[0]]).status === 0, 'a run without a panel');
  const shown = await start(['--cell', cell, '--no-picture', '--panel', '--record', files[1]], turns);
  const context = await plainBrowser.newContext();
  try {
    const page = await context.newPage();
    await page.goto(shown.address);
    await page.waitForFunction(() => window.mrrocPanel.state()?.robots.length === 2, null, { timeout: TIMEOUT, polling: 50 });
    const lasts = Number(await page.locator('#at').getAttribute('max'));
    check(lasts > 4, `it lasts: ${lasts}`);
    check(await page.getByRole('button', { name: /^Stop/ }).isHidden(), 'there is nothing to stop');
    await page.locator('#at').fill(String(lasts / 2));
    await page.waitForFunction((at) => Math.abs(window.mrrocPanel.state().time - at) < 0.05, lasts / 2, { timeout: TIMEOUT, polling: 50 });
    // What was before, up to a minute, is plotted at once.
    const { joints, speed } = await page.evaluate(() => window.mrrocPanel.plots());
    const [times, first] = joints.data;
    check(times[0] < 0.1 && Math.abs(times.at(-1) - lasts / 2) < 0.05 && times.length > 60, `plotted from ${times[0]} to ${times.at(-1)} s, ${times.length} moments`);
    check(Math.max(...first) - Math.min(...first) > 0.1 && Math.max(...speed.data[1]) > 100, 'and it is a motion');
    await press(page, 'Play');
    await page.waitForFunction((at) => window.mrrocPanel.state().time > at + 1, lasts / 2, { timeout: TIMEOUT, polling: 50 });
    if (shots) {
      const drawn = await browser.newPage({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
      await drawn.goto(shown.address);
      await drawn.locator('#at').fill(String(lasts / 2));
      await drawn.waitForTimeout(5000);
      await shot(drawn, 'played');
      await drawn.close();
    }
  } finally {
    await context.close();
    await shown.end();
  }
  for (const file of files) check(run(['replay', file]).status === 0, `the demands of ${file} are the same to the bit`);
  // So are those of the cell that was operated and attacked, whose arms went for as long as that took.
  const again = run(['replay', recorded, '--partial'], []);
  check(again.status === 0, `its demands are those that its program gives by itself, to the bit: ${again.stdout}${again.stderr}`);
  const played = await start(['panel', recorded, '--cell', cell]);
  try {
    const page = await plainBrowser.newPage();
    await page.goto(played.address);
    await page.waitForFunction(() => window.mrrocPanel.state()?.robots[0]?.tool, null, { timeout: TIMEOUT, polling: 50 });
    await page.locator('#at').fill('2');
    await page.waitForFunction(() => Math.abs(window.mrrocPanel.state().time - 2) < 0.1, null, { timeout: TIMEOUT, polling: 50 });
    await page.close();
  } finally {
    await played.end();
  }
}

/** A cell of 64 robots is shown. */
async function crowd(browser) {
  const many = join(folder, 'crowd.toml');
  const standing = Array.from({ length: 62 }, (_, i) => `
[robots.standing${i}]
kind = "irp6"
start = [0.0, -1.57, 0.16, -0.16, 4.71, 0.0]
base = { xyz = [${2.5 * (i % 8) + 5}.0, ${2.5 * Math.floor(i / 8) - 8}.0, 0.0] }
`.replace(/(\.5)\.0/g, '$1'));
  writeFileSync(many, readFileSync(cell, 'utf8') + standing.join(''));
  const shown = await start(['--cell', many, '--no-picture', '--panel'], ['--turns', '1']);
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  try {
    await page.goto(shown.address);
    await page.waitForFunction(() => window.mrrocPanel.state()?.robots.filter(({ links }) => links.length > 2).length === 64, null, { timeout: 60000, polling: 200 });
    // All of them are in the picture, and no name hides another one.
    const names = await page.locator('#labels span:visible').evaluateAll((labels) => labels.map((label) => label.getBoundingClientRect().toJSON()));
    const apart = names.every((a, i) => names.slice(i + 1).every((b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top));
    check(names.length > 15 && apart, `names of 64 robots can be read: ${names.length}`);
    await shot(page, 'crowd');
  } finally {
    await page.close();
    await shown.end();
  }
}

// A browser that draws by the processor, and one that draws no 3D at all and leaves the processor to the cell.
const launch = (nice, args) => chromium.launch({ executablePath: nicely(browserPath, nice), args: ['--no-sandbox', ...args] });
const [browser, plainBrowser] = [await launch(19, DRAWING), await launch(5, ['--disable-3d-apis', '--disable-gpu'])];
try {
  await tested("the panel's page in a browser", async () => {
    const began = Date.now();
    const recorded = await operate(browser, plainBrowser);
    await play(browser, plainBrowser, recorded);
    await crowd(browser);
    console.log(`panel: ${checks()} facts hold (${((Date.now() - began) / 1000).toFixed(0)} s)`);
  });
} finally {
  await Promise.all([browser.close(), plainBrowser.close()]);
  rmSync(folder, { recursive: true, force: true });
}
