// SPDX-License-Identifier: MIT
//
// The page around page.cpp: its controls, the mouse, the loop of pictures and the chart.
import {drawChart, readThesisTable} from './chart.js';

const $ = (id) => document.getElementById(id);
const canvas = $('view');
const state = {ready: false, status: null, comparison: null, measured: [], errors: []};
window.phymulPage = state;  // for the test

let phymul;
const call = (name, result, types, values) => phymul.ccall(name, result, types, values);
const failure = () => call('page_error', 'string', [], []);

/// Says what went wrong.
const told = (name, types, values) => call(name, 'number', types, values) || say(failure(), true);

function say(text, wrong = false) {
  $('message').textContent = text;
  $('message').classList.toggle('wrong', wrong);
  if (wrong) state.errors.push(text);
}

/// Shows a sentence before work that stops the page for a while.
function later(text, work) {
  state.ready = false;
  say(text);
  return new Promise((resolve) => requestAnimationFrame(() => setTimeout(() => {
    const good = work();
    if (good) say('');
    else say(failure(), true);
    state.ready = good || Boolean(state.status);  // with the organ before, if there is one
    resolve(good);
  }, 0)));
}

const spacings = {'liver': [16, 12, 9, 7], 'bean.stl': [6, 4.5, 3.5, 2.5]};
let ownFile = null;

async function fill() {
  const organ = $('organ').value, spacing = 1e-3 * $('spacing').value, backend = $('backend').value;
  Object.assign(state, {ready: false, comparison: null});
  $('error').textContent = 'let go after a pull';
  if (organ === 'liver') {
    return later('Filling the liver ...', () => call('page_fill_liver', 'number', ['number', 'string'], [spacing, backend]));
  }
  let bytes;
  try {
    bytes = new Uint8Array(await (ownFile || await fetch(organ)).arrayBuffer());
  } catch (error) {
    state.ready = Boolean(state.status);
    return say(`${organ}: ${error.message}`, true);
  }
  return later('Filling the surface ...', () => {
    const at = phymul._malloc(bytes.length);
    phymul.HEAPU8.set(bytes, at);
    const good = call('page_fill_stl', 'number', ['number', 'number', 'number', 'string'], [at, bytes.length, spacing, backend]);
    phymul._free(at);
    return good;
  });
}

function offerSpacings(list = spacings[$('organ').value]) {
  $('spacing').replaceChildren(...list.map((mm) => new Option(`${mm} mm`, mm)));
  $('spacing').selectedIndex = 1;
}

/// A file of any size: spacings by its longest side.
async function takeFile() {
  ownFile = $('file').files[0];
  if (!ownFile) return;
  const view = new DataView(await ownFile.arrayBuffer());
  let size = 0;
  for (const axis of [0, 1, 2]) {
    let low = Infinity, high = -Infinity;
    for (let k = 84; k + 50 <= view.byteLength; k += 50) {
      const at = view.getFloat32(k + 12 + 4 * axis, true);
      low = Math.min(low, at);
      high = Math.max(high, at);
    }
    if (high - low > size) size = high - low;
  }
  if (!$('organ').querySelector('[value=own]')) $('organ').append(new Option('your file', 'own'));
  $('organ').value = 'own';
  offerSpacings([12, 18, 24, 32].map((n) => Number(((size || 100) / n).toPrecision(2))));
  await fill();
}

function sizeCanvas() {
  const scale = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * scale)), height = Math.max(1, Math.round(canvas.clientHeight * scale));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
}

const place = (event) => {
  const scale = window.devicePixelRatio || 1;
  return [event.offsetX * scale, event.offsetY * scale, canvas.width, canvas.height];
};
const four = ['number', 'number', 'number', 'number'];
let turning = false;

function listen() {
  canvas.addEventListener('pointerdown', (event) => {
    if (!state.ready) return;
    canvas.setPointerCapture(event.pointerId);
    const taken = event.button === 0 && call('page_take', 'number', four, place(event));
    turning = !taken;
    canvas.classList.toggle('held', Boolean(taken));
    if (taken) $('error').textContent = 'let go after a pull';
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!event.buttons || !state.ready) return;
    if (turning) call('page_turn', null, ['number', 'number'], [0.008 * event.movementX, 0.008 * event.movementY]);
    else told('page_move', four, place(event));
  });
  const letGo = () => {
    const held = canvas.classList.contains('held');
    canvas.classList.remove('held');
    if (!held) return;
    told('page_release', [], []);
    compare();
  };
  canvas.addEventListener('pointerup', letGo);
  canvas.addEventListener('pointercancel', letGo);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    if (state.ready) call('page_zoom', null, ['number'], [Math.exp(-0.001 * event.deltaY)]);
  }, {passive: false});
  $('organ').addEventListener('change', () => { ownFile = null; offerSpacings(); fill(); });
  $('spacing').addEventListener('change', fill);
  $('backend').addEventListener('change', () => state.status &&
    later('Changing ...', () => call('page_use', 'number', ['string'], [$('backend').value])));
  $('file').addEventListener('change', takeFile);
  $('reset').addEventListener('click', () => state.ready && told('page_reset', [], []));
  $('measure').addEventListener('click', measure);
}

/// The error of the last pull against a finer body.
function compare() {
  $('error').textContent = 'computing ...';
  requestAnimationFrame(() => setTimeout(() => {
    const answer = call('page_compare', 'string', [], []);
    if (!answer) return void ($('error').textContent = failure());
    state.comparison = JSON.parse(answer);
    const {mean, moved, largest, particles} = state.comparison;
    $('error').textContent = moved > 0 ? `${(100 * mean / moved).toFixed(1)} %, ${(1e3 * mean).toFixed(2)} mm (at most ` +
      `${(1e3 * largest).toFixed(1)} mm) from ${particles.toLocaleString('en')} particles` : 'nothing was moved';
  }, 0));
}

const colours = {cpu: '#1f6fb4', gl: '#d2691e', 'gl-compute': '#6a9a2d'};
let published = [];

function chart() {
  const mine = (backend) => state.measured.filter((one) => one.backend === backend);
  const theirs = (backend) => published.filter((one) => one.backend === backend);
  drawChart($('chart'), [
    {name: 'here: cpu', colour: colours.cpu, points: mine('cpu')},
    {name: 'here: gl', colour: colours.gl, points: mine('gl')},
    {name: 'with an H100: cpu, 1 thread', colour: colours.cpu, dash: '2 4', points: theirs('cpu')},
    {name: 'H100: gl', colour: colours.gl, dash: '2 4', points: theirs('gl')},
    {name: 'H100: gl-compute', colour: colours['gl-compute'], dash: '2 4', points: theirs('gl-compute')},
    {name: 'thesis 2007, GPU: 314 µs', colour: '#7b3f98', mark: true, points: [{particles: 275, seconds: 314e-6}]},
    {name: 'thesis 2007, CPU: 270 µs', colour: '#2b2b2b', mark: true, points: [{particles: 275, seconds: 270e-6}]},
  ]);
}

async function measure() {
  if (!state.ready) return;
  state.ready = false;
  $('measure').disabled = true;
  state.measured = [];
  for (const backend of ['cpu', 'gl']) {
    if ($('backend').querySelector(`[value=${backend}]`).disabled) continue;
    for (const side of [2, 4, 0, 10, 16, 24, 32]) {
      $('progress').textContent = `${backend}, ${side ? side ** 3 : 275} particles ...`;
      await new Promise((resolve) => setTimeout(resolve, 30));
      const answer = call('page_step_time', 'string', ['number', 'string'], [side, backend]);
      if (!answer) {
        say(`${backend}: ${failure()}`, true);
        break;
      }
      state.measured.push({backend, ...JSON.parse(answer)});
      chart();
      if (state.measured.at(-1).seconds > 0.05) break;  // the next one would take seconds a step
    }
  }
  $('progress').textContent = 'done';
  $('measure').disabled = false;
  state.ready = true;
}

function show(status) {
  $('particles').textContent = `${status.particles.toLocaleString('en')} in ${status.cells.toLocaleString('en')} tetrahedra`;
  $('rate').textContent = `${Math.round(status.stepsPerSecond).toLocaleString('en')} steps/s`;
  $('speed').textContent = `${status.speed.toFixed(2)} × real time`;
  $('pull').textContent = status.held ? `${(1e3 * status.pull).toFixed(1)} mm` : 'none';
  $('moved').textContent = `${(1e3 * status.moved).toFixed(1)} mm at most`;
  $('device').textContent = status.device;
  if (status.failure) say(status.failure, true);
}

let before = 0, shown = 0;
function frame(now) {
  requestAnimationFrame(frame);
  const seconds = Math.min((now - before) / 1000, 0.1);
  before = now;
  if (!state.ready) return;
  sizeCanvas();
  if (!call('page_frame', 'number', ['number', 'number', 'number'], [seconds, canvas.width, canvas.height])) {
    state.ready = false;
    return say(failure(), true);
  }
  state.status = JSON.parse(call('page_status', 'string', [], []));
  if (now - shown > 200) {
    shown = now;
    show(state.status);
  }
}

async function start() {
  phymul = await createPhymul();
  state.phymul = phymul;
  sizeCanvas();
  if (!call('page_open', 'number', ['string'], ['#view'])) return say(failure(), true);
  const why = call('page_why_unavailable', 'string', ['string'], ['gl']);
  if (why) {
    const gl = $('backend').querySelector('[value=gl]');
    gl.disabled = true;
    gl.textContent = `gl: ${why}`;
  }
  offerSpacings();
  listen();
  published = readThesisTable(await (await fetch('thesis_table_h100.csv')).text());
  chart();
  await fill();
  requestAnimationFrame(frame);
}

start().catch((error) => say(String(error), true));
