// Pictures. Long series are thinned to what a picture can show; a zoom shows the samples of its range.

const MOST = 1400;
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

const axis = (title, more = {}) => ({
  title: { text: title, standoff: 8 }, gridcolor: colour('grid'), zerolinecolor: colour('grid'), linecolor: colour('line'),
  automargin: true, ...more,
});
const layout = (more) => ({
  margin: { l: 58, r: 12, t: 24, b: 44 }, paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
  font: { color: colour('ink'), size: 12 }, legend: { orientation: 'h', y: 1.02, yanchor: 'bottom' }, uirevision: 'kept',
  hovermode: 'closest', ...more,
});
const CONFIG = { responsive: true, displaylogo: false, scrollZoom: false, modeBarButtonsToRemove: ['lasso2d', 'select2d'] };
const draw = (id, traces, more) => window.Plotly.react(id, traces, layout(more), CONFIG);

/** Indices of at most MOST samples within a range of x. */
function thin(x, range, most = MOST) {
  let first = 0;
  let past = x.length;
  if (range) {
    while (first < past && x[first] < range[0]) first += 1;
    while (past > first && x[past - 1] > range[1]) past -= 1;
    first = Math.max(0, first - 1);
    past = Math.min(x.length, past + 1);
  }
  const step = Math.max(1, Math.ceil((past - first) / most));
  const out = [];
  for (let i = first; i < past; i += step) out.push(i);
  return out;
}
const at = (values, indices, factor = 1) => indices.map((i) => {
  const value = values[i];
  return value === null || value === undefined ? null : factor * value;
});
const line = (name, tone, x, y, more = {}) => ({
  name, x, y, mode: 'lines', type: 'scatter', line: { color: colour(tone), width: 1.4, dash: more.dash }, connectgaps: false,
  hovertemplate: `%{x:.5g}, %{y:.4g}<extra>${name}</extra>`, ...more,
});
const dots = (name, tone, x, y, more = {}) => ({
  name, x, y, mode: 'markers', type: 'scatter', marker: { color: colour(tone), size: 4, symbol: more.symbol }, ...more,
});

let zoom = null;
let drawn = null;

// What the sensor reads, and the scales in which a tip's motion and its lines are read best.
let quantity = { name: 'displacement', unit: 'm' };
const prefixed = (prefix) => `${prefix}${quantity.unit}`.replace('^2', '²');
/** Takes over what the sensor of a campaign reads. */
export const reads = (of) => { quantity = of; };
/** The displacement of a tip, which the sensor may read. */
const displacement = (series) => (series.displacement.length ? series.displacement : series.reading);

function motion({ run, curves, other }) {
  const m = run.measured;
  const kept = thin(m.time, zoom);
  const x = at(m.time, kept);
  const traces = [
    line('measured', 'measured', x, at(m.reading, kept, 1e3)),
    line('model', 'model', x, at(curves.reading, kept, 1e3)),
  ];
  if (other) traces.push(line(other.name, 'other', x, at(other.curves.reading, kept, 1e3), { dash: 'dot' }));
  traces.push(line('measured less model', 'model', x, at(curves.residual, kept, 1e3), { yaxis: 'y2', showlegend: false }));
  if (other) traces.push(line(`measured less ${other.name}`, 'other', x, at(other.curves.residual, kept, 1e3), { yaxis: 'y2', showlegend: false }));
  return draw('motion', traces, {
    xaxis: axis('time in s', { anchor: 'y2', range: zoom || undefined, autorange: !zoom }),
    yaxis: axis(`${quantity.name}<br>in ${prefixed('m')}`, { domain: [0.42, 1] }),
    yaxis2: axis(`measured less<br>model in ${prefixed('m')}`, { domain: [0, 0.34], anchor: 'x' }),
  });
}

function phase({ run, curves, other }) {
  const m = run.measured;
  const kept = thin(m.time, zoom, 2 * MOST);
  const traces = [
    line('measured', 'measured', at(displacement(m), kept, 1e3), at(m.velocity, kept)),
    line('model', 'model', at(displacement(curves), kept, 1e3), at(curves.velocity, kept)),
  ];
  if (other) traces.push(line(other.name, 'other', at(displacement(other.curves), kept, 1e3), at(other.curves.velocity, kept), { dash: 'dot' }));
  return draw('phase', traces, { xaxis: axis('displacement in mm'), yaxis: axis('velocity in m/s') });
}

function friction({ run, curves, other }) {
  const m = run.measured;
  const kept = thin(m.time, zoom);
  const traces = [dots('measured', 'quiet', at(m.relative, kept), at(m.friction, kept), { marker: { color: colour('quiet'), size: 3 } })];
  const model = (name, tone, c) => {
    if (!c.friction.length) return;
    traces.push(dots(name, tone, at(c.relative, kept), at(c.friction, kept), { marker: { color: colour(tone), size: 3 } }));
  };
  model('model', 'model', curves);
  if (other) model(other.name, 'other', other.curves);
  return draw('friction', traces, {
    xaxis: axis('velocity relative to the belt in m/s'), yaxis: axis('friction over normal force, 1'),
  });
}

function spectrum({ curves, other }) {
  const one = (name, tone, s, more) => {
    const kept = thin(s.frequency, null);
    return line(name, tone, at(s.frequency, kept), at(s.amplitude, kept, 1e6), more);
  };
  const [measured, model, left] = curves.spectra;
  const traces = [one('measured', 'measured', measured), one('model', 'model', model), one('left', 'quiet', left, { dash: 'dot' })];
  if (other) traces.push(one(other.name, 'other', other.curves.spectra[1], { dash: 'dash' }));
  document.getElementById('spectrum-caption').textContent =
    `Amplitude spectra over ${curves.stretch.toPrecision(3)} s, the longest stretch that segments cover without a gap.`;
  return draw('spectrum', traces, {
    xaxis: axis('frequency in Hz', { type: 'log' }), yaxis: axis(`amplitude in ${prefixed('µ')}`, { type: 'log', exponentformat: 'power' }),
  });
}

function breakAway({ run, curves, other }) {
  const traces = [];
  const add = (name, tone, list, symbol) => {
    const y = list.map((e) => e.force);
    const marker = { color: colour(tone), size: 7, symbol };
    traces.push(dots(name, tone, list.map((e) => 1e3 * e.dwell), y, { marker, legendgroup: name }));
    traces.push(dots(name, tone, list.map((e) => 1e3 * e.place), y, { marker, legendgroup: name, showlegend: false, xaxis: 'x2' }));
  };
  add('measured', 'measured', run.measured.break_aways, 'circle-open');
  add('model', 'model', curves.break_aways, 'cross');
  if (other) add(other.name, 'other', other.curves.break_aways, 'x');
  return draw('breakaway', traces, {
    xaxis: axis('dwell in ms', { domain: [0, 0.47] }), xaxis2: axis('place in mm', { domain: [0.53, 1], anchor: 'y' }),
    yaxis: axis('friction over<br>normal force, 1'),
  });
}

const PICTURES = [motion, phase, friction, spectrum, breakAway];
let waiting = 0;

/**
 * Draws all pictures of a run, the motion at once and the others in the frames after it, so that a slider stays light; then does
 * what comes last.
 */
export function show(what, last = () => {}) {
  drawn = what;
  motion(what);
  waiting += 1;
  const turn = waiting;
  const pictures = [...PICTURES.slice(1).map((picture) => () => picture(drawn)), last];
  const next = () => {
    if (turn !== waiting || !pictures.length) return;
    pictures.shift()();
    requestAnimationFrame(next);
  };
  requestAnimationFrame(next);
}

/** Links the zoom of the motion to all else that shows samples. */
export function link() {
  const box = document.getElementById('motion');
  box.on('plotly_relayout', (change) => {
    if ('xaxis.range[0]' in change) zoom = [change['xaxis.range[0]'], change['xaxis.range[1]']];
    else if (change['xaxis.range']) zoom = change['xaxis.range'];
    else if (change['xaxis.autorange']) zoom = null;
    else return;
    if (drawn) show(drawn);
  });
}

/** Forgets the zoom, as another run is shown. */
export const unzoom = () => { zoom = null; };

/** The runs as a map of operating points. */
export function map(runs, errors, shown, choose) {
  const text = runs.map((r, i) => `${r.name}<br>${errors?.[i] == null ? 'no error' : `${(100 * errors[i]).toPrecision(3)} %`}` +
    `${r.kept_out ? '<br>kept out' : ''}`);
  const traces = [{
    type: 'scatter', mode: 'markers+text', x: runs.map((r) => r.belt_velocity), y: runs.map((r) => r.normal_force),
    text: runs.map((r) => r.name), textposition: 'top center', hovertext: text, hoverinfo: 'text', cliponaxis: false,
    marker: {
      size: runs.map((_, i) => (i === shown ? 20 : 13)), color: runs.map((_, i) => (errors?.[i] == null ? null : 100 * errors[i])),
      symbol: runs.map((r) => (r.kept_out ? 'diamond' : 'circle')), colorscale: 'Viridis', reversescale: true, cmin: 0,
      line: { color: colour('ink'), width: runs.map((_, i) => (i === shown ? 3 : 1)) },
      colorbar: { title: { text: 'error in %', side: 'right' }, thickness: 10, len: 1 },
    },
  }];
  const range = (values) => {
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const pad = 0.18 * (high - low || Math.abs(high) || 1);
    return [low - pad, high + pad];
  };
  draw('map', traces, {
    showlegend: false, margin: { l: 52, r: 8, t: 16, b: 44 },
    xaxis: axis('belt velocity in m/s', { range: range(runs.map((r) => r.belt_velocity)) }),
    yaxis: axis('normal force in N', { range: range(runs.map((r) => r.normal_force)) }),
  });
  const box = document.getElementById('map');
  box.removeAllListeners('plotly_click');
  box.on('plotly_click', (event) => choose(event.points[0].pointIndex));
}

/** The error over the iterations of a fit. */
export function falling(errors) {
  draw('work-errors', [line('error', 'model', errors.map((_, i) => i), errors.map((e) => 100 * e), { mode: 'lines+markers' })], {
    showlegend: false, xaxis: axis('iteration'), yaxis: axis('error in %', { type: 'log' }),
  });
}
