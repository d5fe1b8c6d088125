// The panel at an address of a network, to which only TLS leads: by Chromium, curl and openssl. It runs in a network namespace of its own,
// where 192.0.2.1 is this machine.

import { execFileSync, spawn, spawnSync } from 'node:child_process';
import { chmodSync, copyFileSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';
import { TIMEOUT, check, checks, tested, nicely, start as started, told } from './kit.mjs';

const [browserPath, program, cellFile] = process.argv.slice(2);
const start = (words, variables) => started(program, words, { variables });
const address = '192.0.2.1:7411';
const folder = mkdtempSync(join(tmpdir(), 'mrroc-panel-network-'));
const cell = join(folder, 'cell.toml');
copyFileSync(cellFile, cell);
const words = ['--cell', cell, '--processes', '--panel', '--no-picture'];

/** What curl says: the status of the answer, 0 for none, and how it ended. */
function curl(...options) {
  const asked = spawnSync('curl', ['--silent', '--max-time', '10', '--output', '/dev/null', '--write-out', '%{http_code}', ...options]);
  return { status: Number(asked.stdout), ended: asked.status };
}

/** What is said of a panel that is not shown, up to this word; its cell runs all the same. */
const refusal = (asked, word) => new Promise((resolve, reject) => {
  const child = spawn(program, words, { stdio: ['ignore', 'pipe', 'pipe'], env: { ...process.env, MRROC_PANEL_ADDRESS: asked } });
  let said = '';
  const over = setTimeout(() => { child.kill(); reject(new Error(`not said: ${word}:\n${said}`)); }, TIMEOUT);
  const hear = (text) => {
    said += text;
    if (!said.includes(word)) return;
    clearTimeout(over);
    child.on('close', () => resolve(said));
    child.kill();
  };
  child.stdout.on('data', hear);
  child.stderr.on('data', hear);
});

/** The fingerprint of who answers there, as openssl sees it. */
function fingerprint() {
  const said = spawnSync('openssl', ['s_client', '-connect', address], { input: '' });
  return execFileSync('openssl', ['x509', '-noout', '-fingerprint', '-sha256'], { input: said.stdout }).toString().trim().split('=')[1];
}

/** A certificate that signs itself: nobody knows it, but who compares its fingerprint. */
async function signedByItself() {
  const runs = await start(words, { MRROC_PANEL_ADDRESS: address });
  const browser = await chromium.launch({ executablePath: nicely(browserPath, 5), args: ['--no-sandbox', '--disable-3d-apis', '--disable-gpu'] });
  try {
    check(runs.address.startsWith(`https://${address}/#token=`), `it prints where it is: ${runs.address}`);
    check(runs.said().includes(fingerprint()), 'the fingerprint that it prints is that of its certificate');
    // Without TLS, without trust, under another name, from another origin.
    check(curl(`http://${address}/`).status === 0, 'nothing is said without TLS');
    check(curl(`https://${address}/`).ended === 60, 'a certificate that signs itself is not trusted by itself');
    check(curl('--insecure', `https://${address}/`).status === 200, 'the page is there');
    check(curl('--insecure', '--tls-max', '1.2', `https://${address}/`).status === 0, 'nothing older than TLS 1.3 is spoken');
    check(curl('--insecure', '-H', 'Host: cell.example', `https://${address}/`).status === 403, 'another name is no host of it');
    const upgrade = (origin) => curl('--insecure', '--http1.1', '-H', `Origin: ${origin}`, '-H', 'Connection: Upgrade', '-H', 'Upgrade: websocket',
      '-H', 'Sec-WebSocket-Version: 13', '-H', 'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==', '--max-time', '2', `https://${address}/connect`).status;
    check(upgrade(`http://${address}`) === 403 && upgrade('https://evil.example') === 403, 'a page of another origin does not connect');
    check(upgrade(`https://${address}`) === 101, 'its own page does');

    const careful = await browser.newPage();
    const refused = await careful.goto(runs.address).then(() => '', (error) => error.message);
    check(refused.includes('ERR_CERT_AUTHORITY_INVALID'), `a browser warns: ${refused}`);
    const context = await browser.newContext({ ignoreHTTPSErrors: true });
    const page = await context.newPage();
    await page.goto(runs.address);
    const shows = (word) => page.waitForFunction((expected) => window.mrrocPanel.state()?.state === expected, word, { timeout: TIMEOUT, polling: 50 });
    await shows('running');
    check(await page.evaluate(() => window.isSecureContext && location.protocol === 'https:'), 'the page is secure');
    await page.keyboard.press('Escape');
    await shows('latched');
  } catch (error) {
    throw await told(error, runs);
  } finally {
    await browser.close();
    await runs.end();
  }
}

/** A certificate of an authority that is trusted, made for this address. */
async function ofAnAuthority() {
  const own = join(folder, 'certificates'), file = (name) => join(own, name);
  mkdirSync(own);
  const openssl = (...options) => execFileSync('openssl', options, { stdio: 'ignore' });
  const key = ['-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:P-256', '-nodes'];
  openssl('req', '-x509', ...key, '-keyout', join(folder, 'ca.key'), '-out', join(folder, 'ca.pem'), '-subj', '/CN=an authority', '-days', '2');
  openssl('req', '-x509', ...key, '-CA', join(folder, 'ca.pem'), '-CAkey', join(folder, 'ca.key'), '-keyout', file('panel.key'), '-out', file('panel.pem'),
    '-subj', '/CN=panel', '-addext', 'subjectAltName=IP:192.0.2.1', '-addext', 'basicConstraints=critical,CA:FALSE', '-days', '2');
  chmodSync(file('panel.key'), 0o644);
  check((await refusal(address, 'chmod 600')).includes('panel.key'), 'a key that others may read is refused');
  chmodSync(file('panel.key'), 0o600);
  const runs = await start(words, { MRROC_PANEL_ADDRESS: address });
  try {
    check(curl('--cacert', join(folder, 'ca.pem'), `https://${address}/`).status === 200, 'who trusts the authority needs no fingerprint');
    check(runs.said().includes(fingerprint()), 'the fingerprint is that of the own certificate');
  } finally {
    await runs.end();
  }
}

/** Addresses that are none. */
async function refuses() {
  for (const [asked, said] of [['0.0.0.0:7411', 'all networks'], ['7411', 'is no address']]) {
    check(!(await refusal(asked, said)).includes('#token='), `${asked} is refused`);
  }
}

try {
  await tested('a page of a network', signedByItself);
  await ofAnAuthority();
  await refuses();
  console.log(`panel on a network: ${checks()} facts hold`);
} finally {
  rmSync(folder, { recursive: true, force: true });
}
