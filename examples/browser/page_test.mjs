// SPDX-License-Identifier: MIT
//
// page_test.mjs CHROMIUM FOLDER SCREENSHOTS: opens the page of FOLDER in headless Chromium, pulls the organ by the mouse
// on both backends, and measures. Fails with a sentence.
import {mkdirSync, readdirSync, statSync} from 'node:fs';
import {join} from 'node:path';
import {Expectations, Page, pause, serve} from '../../tests/browser/chromium.mjs';

const [chromium, folder, screenshots] = process.argv.slice(2);
const mostBytes = 3e6;
const {expect, finish} = new Expectations();
const say = (text) => console.log(text);
mkdirSync(screenshots, {recursive: true});

const server = await serve(folder);
let page;
const evaluate = (expression) => page.evaluate(expression);
const until = (expression, seconds, what) =>
  page.until(expression, seconds, what, "document.getElementById('message').textContent");
const screenshot = (name) => page.screenshot(join(screenshots, name));
const choose = (id, value) => evaluate(
  `{const it = document.getElementById('${id}'); it.value = '${value}'; it.dispatchEvent(new Event('change'));}`);
const settled = () => until('phymulPage.ready && phymulPage.status', 120, 'the page is ready');
const status = () => evaluate('phymulPage.status');

/// Pixels of the canvas that are not its background, of all; and where they are, as text.
const picture = () => evaluate(`new Promise((resolve) => requestAnimationFrame(() => {  // after the page's own
  const small = new OffscreenCanvas(120, 60).getContext('2d');
  small.drawImage(document.getElementById('view'), 0, 0, 120, 60);
  const {data} = small.getImageData(0, 0, 120, 60);
  let mask = '';
  for (let k = 0; k < data.length; k += 4) mask += [0, 1, 2].some((c) => Math.abs(data[k + c] - data[c]) > 12) ? '1' : '0';
  resolve({mask, share: mask.replaceAll('0', '').length / mask.length});
}))`);

/// Drags from the middle of the organ to the right and up; what the page says while it is held.
async function drag(name) {
  const box = await evaluate("(({x, y, width, height}) => ({x, y, width, height}))(document.getElementById('view').getBoundingClientRect())");
  const from = {x: box.x + 0.5 * box.width, y: box.y + 0.45 * box.height};
  const mouse = (type, x, y) => page.send('Input.dispatchMouseEvent', {type, x, y, button: 'left', buttons: type === 'mouseReleased' ? 0 : 1, clickCount: 1});
  const rest = await picture();
  await mouse('mousePressed', from.x, from.y);
  for (let k = 1; k <= 10; ++k) {
    await mouse('mouseMoved', from.x + 6 * k, from.y - 3 * k);
    await pause(60);
  }
  const begin = (await status()).time;
  await until(`phymulPage.status.time > ${begin + 0.6}`, 120, `${name}: the simulation goes on while the organ is held`);
  await pause(300);
  const held = await status(), pulled = await picture();
  const changed = [...pulled.mask].filter((one, k) => one !== rest.mask[k]).length / rest.mask.length;
  expect(rest.share > 0.05 && rest.share < 0.9, `${name}: the organ covers ${(100 * rest.share).toFixed(0)} % of the picture`);
  expect(changed > 0.005, `${name}: held, it covers others: ${(100 * changed).toFixed(1)} % of the picture`);
  const rate = await evaluate("document.getElementById('rate').textContent");
  expect(/^[1-9][0-9,]* steps.s$/.test(rate), `${name}: the rate is shown: ${rate}`);
  await screenshot(`${name}_held.png`);
  await evaluate('phymulPage.comparison = null');
  await mouse('mouseReleased', from.x + 60, from.y - 30);
  await until('phymulPage.comparison', 120, `${name}: the error is computed`);
  const error = await evaluate('phymulPage.comparison');
  const said = await evaluate("document.getElementById('error').textContent");
  expect(/^[0-9.]+ %, [0-9.]+ mm/.test(said), `${name}: the error is shown: ${said}`);
  await until('phymulPage.status.moved < 0.002', 120, `${name}: the organ returns`);
  return {held, error};
}

try {
  page = await Page.open(chromium, server.address, 1280, 1250);
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
  expect(apart < 0.1, `the same drag moves the surface alike on both backends: ${(100 * apart).toFixed(2)} % apart`);
  for (const [one, other, most] of [['cpu', 'reference', 1e-3], ['gl', 'reference', 1e-3]]) {
    const difference = await evaluate(`phymulPage.phymul.ccall('page_difference', 'number', ['string', 'string', 'number'], ['${one}', '${other}', 100])`);
    expect(difference >= 0 && difference < most, `${one} and ${other} agree after 100 steps: ${difference.toExponential(2)} of the largest displacement`);
  }

  // Pressed and let go between two pictures, the organ is free all the same.
  await evaluate(`{
    const canvas = document.getElementById('view'), {x, y, width, height} = canvas.getBoundingClientRect();
    const at = {pointerId: 1, button: 0, clientX: x + 0.5 * width, clientY: y + 0.45 * height};
    canvas.setPointerCapture = () => {};  // it knows no pointer of a script
    phymulPage.comparison = null;
    for (const type of ['pointerdown', 'pointerup']) canvas.dispatchEvent(new PointerEvent(type, at));
  }`);
  await until('phymulPage.comparison', 120, 'a click lets go at once');

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

  await page.resize(390, 844, true);
  await pause(1500);
  expect(await evaluate('document.documentElement.scrollWidth <= 390'), 'the page fits a phone');
  await screenshot('phone.png');

  const files = readdirSync(folder).map((name) => [name, statSync(join(folder, name)).size]);
  const bytes = files.reduce((sum, [, size]) => sum + size, 0);
  say(files.map(([name, size]) => `${name} ${size}`).join(', '));
  expect(bytes < mostBytes, `all files together have ${bytes} bytes, less than ${mostBytes}`);
  expect(server.missing.length === 0, `every file that the page asks for is there: ${server.missing.join(', ') || 'it is'}`);
  expect(page.errors.length === 0, `the browser's console is empty: ${page.errors.slice(0, 3).join('; ') || 'it is'}`);
  const said = await evaluate('phymulPage.errors');
  expect(said.length === 0, `the page showed no error: ${said.join('; ') || 'none'}`);
} catch (error) {
  expect(false, error.message);
  if (page?.errors.length) say(`the console: ${page.errors.slice(0, 10).join('\n')}`);
  await page?.screenshot(join(screenshots, 'failure.png')).catch(() => {});
} finally {
  await page?.close();
  server.close();
}
finish();
