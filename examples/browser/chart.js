// SPDX-License-Identifier: MIT
//
// A chart of particles against time of a step, both logarithmic, as SVG.

const width = 900, height = 430, left = 70, right = 235, top = 14, bottom = 48;
const least = {x: 3, y: 1e-7}, most = {x: 3e5, y: 1};

const x = (particles) => left + (width - left - right) * Math.log(particles / least.x) / Math.log(most.x / least.x);
const y = (seconds) => height - bottom - (height - top - bottom) * Math.log(seconds / least.y) / Math.log(most.y / least.y);

function element(name, attributes, text) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function axes(svg) {
  const grey = {stroke: '#d9dee5', 'stroke-width': 1};
  const names = {1e-6: '1 µs', 1e-5: '10 µs', 1e-4: '100 µs', 1e-3: '1 ms', 1e-2: '10 ms', 1e-1: '100 ms', 1: '1 s', 1e-7: '0.1 µs'};
  for (const [seconds, name] of Object.entries(names)) {
    svg.append(element('line', {x1: left, x2: width - right, y1: y(seconds), y2: y(seconds), ...grey}));
    svg.append(element('text', {x: left - 8, y: y(seconds) + 4, 'text-anchor': 'end', 'font-size': 13, fill: '#48536a'}, name));
  }
  for (const particles of [10, 100, 1000, 10000, 100000]) {
    svg.append(element('line', {x1: x(particles), x2: x(particles), y1: top, y2: height - bottom, ...grey}));
    svg.append(element('text', {x: x(particles), y: height - bottom + 18, 'text-anchor': 'middle', 'font-size': 13, fill: '#48536a'},
      particles.toLocaleString('en')));
  }
  svg.append(element('text', {x: (left + width - right) / 2, y: height - 8, 'text-anchor': 'middle', 'font-size': 14, fill: '#1d2433'},
    'particles'));
}

/// series: {name, colour, dash, points: [{particles, seconds}]}; without a line where there is `mark`.
export function drawChart(place, series) {
  const svg = element('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': 'Time of a step by number of particles'});
  axes(svg);
  series.forEach((one, row) => {
    const points = one.points.slice().sort((a, b) => a.particles - b.particles);
    const stroke = {stroke: one.colour, fill: 'none', 'stroke-width': one.dash ? 1.5 : 2.5, 'stroke-dasharray': one.dash || 'none'};
    if (!one.mark) svg.append(element('polyline', {points: points.map((p) => `${x(p.particles)},${y(p.seconds)}`).join(' '), ...stroke}));
    for (const p of points) {
      const dot = element('circle', {cx: x(p.particles), cy: y(p.seconds), r: one.mark ? 6 : one.dash ? 2.5 : 4, fill: one.colour});
      dot.append(element('title', {}, `${one.name}: ${p.particles} particles, ${(1e6 * p.seconds).toPrecision(3)} µs`));
      svg.append(dot);
    }
    const at = top + 16 + 22 * row;
    svg.append(element('line', {x1: width - right + 14, x2: width - right + 40, y1: at - 4, y2: at - 4, ...stroke}));
    if (one.mark) svg.append(element('circle', {cx: width - right + 27, cy: at - 4, r: 6, fill: one.colour}));
    svg.append(element('text', {x: width - right + 47, y: at, 'font-size': 13, fill: '#1d2433'}, one.name));
  });
  place.replaceChildren(svg);
}

/// Of a CSV file of bench/thesis_table: microseconds a step of the longest run of each body, by backend.
export function readThesisTable(csv) {
  const [head, ...rows] = csv.trim().split('\n').map((line) => line.match(/("[^"]*"|[^,]*)(,|$)/g)
    .map((cell) => cell.replace(/,$/, '').replace(/^"|"$/g, '')));
  const column = (name) => {
    const found = head.indexOf(name);
    if (found < 0) throw new Error(`the table has no column "${name}"`);
    return found;
  };
  const [law, particles, backend, steps, time] = ['law', 'particles', 'backend', 'steps', 'us_per_step'].map(column);
  const longest = new Map();
  for (const row of rows) {
    if (!row[law].startsWith('near the thesis') || !row[time]) continue;
    const key = `${row[backend]} ${row[particles]}`;
    if (longest.has(key) && longest.get(key).steps > Number(row[steps])) continue;
    longest.set(key, {backend: row[backend], particles: Number(row[particles]), steps: Number(row[steps]), seconds: 1e-6 * row[time]});
  }
  return [...longest.values()];
}
