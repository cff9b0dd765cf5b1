// SPDX-License-Identifier: MIT
//
// page_test.mjs CHROMIUM FOLDER SCREENSHOTS: opens the page of FOLDER in headless Chromium, pulls the organ by the mouse
// on both backends, and measures. Fails with a sentence. Talks to the browser by the DevTools protocol over a pipe, so it
// needs nothing but node.
import {spawn} from 'node:child_process';
import {mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {tmpdir} from 'node:os';
import {join, normalize} from 'node:path';

const [chromium, folder, screenshots] = process.argv.slice(2);
const mostBytes = 3e6;
const patience = Number(process.env.PHYMUL_PATIENCE || 1);  // on a busy machine, waits are so many times as long
const failures = [];
const say = (text) => console.log(text);
function expect(holds, text) {
  say(`${holds ? 'ok' : 'FAILED'}: ${text}`);
  if (!holds) failures.push(text);
}

// A server that gives files and counts what it gives.
const types = {html: 'text/html', js: 'text/javascript', css: 'text/css', wasm: 'application/wasm'};
const served = new Map();
const server = createServer((request, response) => {
  const name = normalize(request.url.split('?')[0]).replace(/^\/$/, '/index.html');
  try {
    const bytes = readFileSync(join(folder, name));
    served.set(name, bytes.length);
    response.writeHead(200, {'Content-Type': types[name.split('.').at(-1)] || 'application/octet-stream'}).end(bytes);
  } catch {
    response.writeHead(404).end();
    failures.push(`${name} was asked for, which is not there`);
  }
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
const address = `http://127.0.0.1:${server.address().port}/`;

const profile = mkdtempSync(join(tmpdir(), 'phymul-page-'));
const browser = spawn(chromium, ['--headless', '--no-sandbox', '--disable-background-networking', '--disable-component-update',
  '--disable-sync', '--no-first-run', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  `--user-data-dir=${profile}`, '--remote-debugging-pipe', 'about:blank'], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});

// DevTools messages end with a zero byte.
let next = 0, left = '';
const waiting = new Map(), pageErrors = [];
browser.stdio[4].on('data', (data) => {
  const parts = (left + data).split('\0');
  left = parts.pop();
  for (const part of parts) {
    const message = JSON.parse(part);
    if (message.id && waiting.has(message.id)) {
      const {resolve, reject} = waiting.get(message.id);
      waiting.delete(message.id);
      if (message.error) reject(new Error(message.error.message));
      else resolve(message.result);
    } else if (message.method === 'Runtime.exceptionThrown') {
      pageErrors.push(message.params.exceptionDetails.exception?.description || message.params.exceptionDetails.text);
    } else if (message.method === 'Runtime.consoleAPICalled' && ['error', 'warning'].includes(message.params.type)) {
      pageErrors.push(message.params.args.map((a) => a.value ?? a.description).join(' '));
    } else if (message.method === 'Log.entryAdded' && ['error', 'warning'].includes(message.params.entry.level)) {
      pageErrors.push(message.params.entry.text);
    }
  }
});
let session;
const send = (method, params = {}) => new Promise((resolve, reject) => {
  waiting.set(++next, {resolve, reject});
  browser.stdio[3].write(JSON.stringify({id: next, method, params, sessionId: session}) + '\0');
});
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
async function evaluate(expression) {
  const {result, exceptionDetails} = await send('Runtime.evaluate', {expression, returnByValue: true, awaitPromise: true});
  if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description || exceptionDetails.text}`);
  return result.value;
}
async function until(expression, seconds, what) {
  for (const end = Date.now() + 1000 * patience * seconds; Date.now() < end; await pause(200)) {
    if (await evaluate(expression)) return;
  }
  throw new Error(`${what}: not within ${patience * seconds} s; the page says "${await evaluate("document.getElementById('message').textContent")}"`);
}
async function screenshot(name) {
  const {data} = await send('Page.captureScreenshot', {format: 'png', captureBeyondViewport: true});
  writeFileSync(join(screenshots, name), Buffer.from(data, 'base64'));
}
const choose = (id, value) => evaluate(
  `{const it = document.getElementById('${id}'); it.value = '${value}'; it.dispatchEvent(new Event('change'));}`);
const settled = () => until('phymulPage.ready && phymulPage.status', 120, 'the page is ready');
const status = () => evaluate('phymulPage.status');

/// Drags from the middle of the organ to the right and up; what the page says while it is held.
async function drag(name) {
  const box = await evaluate("(({x, y, width, height}) => ({x, y, width, height}))(document.getElementById('view').getBoundingClientRect())");
  const from = {x: box.x + 0.5 * box.width, y: box.y + 0.45 * box.height};
  const mouse = (type, x, y) => send('Input.dispatchMouseEvent', {type, x, y, button: 'left', buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1});
  await mouse('mousePressed', from.x, from.y);
  for (let k = 1; k <= 10; ++k) {
    await mouse('mouseMoved', from.x + 6 * k, from.y - 3 * k);
    await pause(60);
  }
  const begin = (await status()).time;
  await until(`phymulPage.status.time > ${begin + 0.6}`, 120, `${name}: the simulation goes on while the organ is held`);
  await pause(300);
  const held = await status();
  await screenshot(`${name}_held.png`);
  await evaluate('phymulPage.comparison = null');
  await mouse('mouseReleased', from.x + 60, from.y - 30);
  await until('phymulPage.comparison', 120, `${name}: the error is computed`);
  const error = await evaluate('phymulPage.comparison');
  await until('phymulPage.status.moved < 0.002', 120, `${name}: the organ returns`);
  return {held, error};
}

try {
  mkdirSync(screenshots, {recursive: true});
  const {targetInfos} = await send('Target.getTargets');
  const {targetId} = targetInfos.find((target) => target.type === 'page');
  ({sessionId: session} = await send('Target.attachToTarget', {targetId, flatten: true}));
  for (const domain of ['Page', 'Runtime', 'Log']) await send(`${domain}.enable`);
  await send('Emulation.setDeviceMetricsOverride', {width: 1280, height: 1250, deviceScaleFactor: 1, mobile: false});
  await send('Page.navigate', {url: address});
  await until('window.phymulPage', 60, 'the page runs');
  await settled();
  await until('phymulPage.status.stepsPerSecond > 0', 60, 'steps are taken');
  await screenshot('rest.png');

  const drags = {};
  for (const backend of ['cpu', 'gl']) {
    if (backend !== 'cpu') await choose('backend', backend);
    await settled();
    await until(`phymulPage.status.backend === '${backend}' && phymulPage.status.stepsPerSecond > 0`, 120, `${backend} takes steps`);
    const {held, error} = drags[backend] = await drag(backend);
    const share = error.mean / error.moved;
    say(`${backend}: ${held.device}; ${held.particles} particles, ${Math.round(held.stepsPerSecond)} steps/s, ` +
      `${held.speed.toFixed(2)} x real time; pulled ${(1e3 * held.pull).toFixed(1)} mm; error ${(100 * share).toFixed(1)} %`);
    expect(held.held === 1, `${backend}: the mouse has taken the organ`);
    expect(held.pull > 0.01 && held.moved > 0.8 * held.pull && held.moved < 1.5 * held.pull, `${backend}: the surface follows the mouse`);
    expect(share > 0.001 && share < 0.2, `${backend}: the error against a finer body is between 0.1 and 20 %`);
  }
  const apart = Math.abs(drags.cpu.held.moved - drags.gl.held.moved) / drags.cpu.held.moved;
  expect(apart < 0.05, `the same drag moves the surface alike on both backends: ${(100 * apart).toFixed(2)} % apart`);
  for (const [one, other, most] of [['cpu', 'reference', 1e-3], ['gl', 'reference', 1e-3]]) {
    const difference = await evaluate(`phymulPage.phymul.ccall('page_difference', 'number', ['string', 'string', 'number'], ['${one}', '${other}', 100])`);
    expect(difference >= 0 && difference < most, `${one} and ${other} agree after 100 steps: ${difference.toExponential(2)} of the largest displacement`);
  }

  await choose('organ', 'bean.stl');
  await settled();
  await until('phymulPage.status.stepsPerSecond > 0', 60, 'the bean takes steps');
  const {held} = await drag('bean');
  expect(held.held === 1 && held.moved > 0.002, `a surface from a file is pulled: ${(1e3 * held.moved).toFixed(1)} mm`);

  await evaluate("document.getElementById('measure').click()");
  await until("document.getElementById('progress').textContent === 'done'", 300, 'the chart is measured');
  const points = await evaluate('phymulPage.measured');
  for (const backend of ['cpu', 'gl']) {
    const own = points.filter((point) => point.backend === backend).sort((a, b) => a.particles - b.particles);
    say(`${backend}: ${own.map((p) => `${p.particles}: ${(1e6 * p.seconds).toPrecision(3)} us`).join(', ')}`);
    expect(own.length >= 4 && own.at(-1).seconds > own[0].seconds, `${backend}: the chart has bodies of many sizes, and large ones take longer`);
  }
  expect(await evaluate("document.querySelectorAll('#chart circle').length") > 25, 'the chart shows them beside the table');
  await screenshot('chart.png');

  await send('Emulation.setDeviceMetricsOverride', {width: 390, height: 844, deviceScaleFactor: 1, mobile: true});
  await pause(1500);
  expect(await evaluate('document.documentElement.scrollWidth <= 390'), 'the page fits a phone');
  await screenshot('phone.png');

  const bytes = [...served.values()].reduce((sum, size) => sum + size, 0);
  say([...served].map(([name, size]) => `${name} ${size}`).join(', '));
  expect(bytes < mostBytes, `all files together have ${bytes} bytes, less than ${mostBytes}`);
  expect(pageErrors.length === 0, `the browser's console is empty: ${pageErrors.slice(0, 3).join('; ') || 'it is'}`);
  const said = await evaluate('phymulPage.errors');
  expect(said.length === 0, `the page showed no error: ${said.join('; ') || 'none'}`);
} catch (error) {
  expect(false, error.message);
  if (pageErrors.length) say(`the console: ${pageErrors.slice(0, 10).join('\n')}`);
  await screenshot('failure.png').catch(() => {});
} finally {
  await send('Browser.close').catch(() => {});
  server.close();
  if (browser.exitCode === null) await new Promise((resolve) => browser.once('exit', resolve));
  rmSync(profile, {recursive: true, force: true});
}
if (failures.length) {
  console.error(`${failures.length} failed`);
  process.exit(1);
}
process.exit(0);
