// The error ladder: every try is a rung, a click brings it back, two are shown side by side.

import { element, short } from './controls.js';
import { get } from './server.js';

const percent = (value) => (value === null || value === undefined ? '–' : `${(100 * value).toPrecision(4)} %`);
const ORIGIN = { given: 'as given', hand: 'by hand', fit: 'fit', diagnosis: 'diagnosis' };

const cell = (text, className = 'num') => element('td', { className }, text);

/** Draws the ladder. `act` has restore, forget, exported and beside. */
export function ladder(board, pair, act) {
  const most = Math.max(...board.rungs.map((r) => r.errors.fitted ?? 0), 1e-9);
  const head = ['try', 'how', 'fitted', 'kept out', 'forecast', 'side by side', ''];
  const rows = board.rungs.map((rung) => {
    const name = element('button', { title: 'Brings this model back' }, rung.name);
    name.dataset.rung = rung.id;
    name.addEventListener('click', () => act.restore(rung));
    const fitted = cell(percent(rung.errors.fitted));
    const bar = element('span', { className: 'bar' });
    bar.style.width = `${Math.max(2, 100 * (rung.errors.fitted ?? 0) / most)}%`;
    fitted.append(bar);
    const beside = element('td');
    for (const [i, side] of ['A', 'B'].entries()) {
      const radio = element('input', { type: 'radio', name: `side-${side}`, checked: pair[i] === rung.id });
      radio.setAttribute('aria-label', `${rung.name} as ${side}`);
      radio.addEventListener('change', () => act.beside(i, rung.id));
      beside.append(element('label', {}, radio, side, ' '));
    }
    const more = element('td');
    const files = element('button', { title: 'FMU, .ssv, model.toml, campaign with roles, report, command line' }, 'Export');
    files.setAttribute('aria-label', `Export ${rung.name}`);
    files.addEventListener('click', () => act.exported(rung));
    more.append(files, ' ');
    if (rung.id !== board.rungs[0].id) {
      const forget = element('button', {}, 'Forget');
      forget.setAttribute('aria-label', `Forget ${rung.name}`);
      forget.addEventListener('click', () => act.forget(rung));
      more.append(forget);
    }
    const row = element('tr', { className: rung.id === board.base ? 'current' : '' },
      element('td', {}, name), cell(ORIGIN[rung.origin] ?? rung.origin, ''), fitted, cell(percent(rung.errors.kept_out)),
      cell(percent(rung.forecast)), beside, more);
    return row;
  });
  const th = head.map((text, i) => element('th', { className: i > 1 && i < 5 ? 'num' : '', scope: 'col' }, text || 'files'));
  const table = element('table', {}, element('thead', {}, element('tr', {}, ...th)), element('tbody', {}, ...rows));
  const focused = document.activeElement?.dataset?.rung;
  document.getElementById('ladder').replaceChildren(table);
  if (focused) table.querySelector(`[data-rung="${focused}"]`)?.focus();
}

/** Two rungs side by side: errors, and what differs. */
export async function beside(board, pair, runs) {
  const host = document.getElementById('beside');
  const [a, b] = pair.map((id) => board.rungs.find((rung) => rung.id === id));
  if (!a || !b || a === b) { host.replaceChildren(); return; }
  const differences = await get(`api/differences?first=${a.id}&second=${b.id}`);
  const row = (name, x, y) => element('tr', {}, element('td', {}, name), cell(x), cell(y));
  const value = (d, v) => (v === null ? (d.second === 1 || d.first === 1 ? 'off' : 'usual') : short(v));
  const rows = [
    row('error of the runs fitted', percent(a.errors.fitted), percent(b.errors.fitted)),
    row('of those kept out', percent(a.errors.kept_out), percent(b.errors.kept_out)),
    row('of one-cycle forecasts', percent(a.forecast), percent(b.forecast)),
    ...runs.map((run, i) => row(`error of ${run.name}`, percent(a.errors.by_run[i]), percent(b.errors.by_run[i]))),
    ...differences.map((d) => row(d.name, value(d, d.first), value(d, d.second))),
  ];
  const th = ['', a.name, b.name].map((text, i) => element('th', { scope: 'col', className: i ? 'num' : '' }, text || 'only what differs'));
  host.replaceChildren(element('h3', {}, 'Side by side'),
    element('div', { className: 'scroll', tabIndex: 0, role: 'region', ariaLabel: 'two tries' },
      element('table', {}, element('thead', {}, element('tr', {}, ...th)), element('tbody', {}, ...rows))));
}

/** Says what work has found. */
export function outcome(found, act) {
  const host = document.getElementById('outcome');
  if (!found) { host.hidden = true; return; }
  host.hidden = false;
  const children = [];
  const f = found.finding;
  if (found.error) children.push(element('p', {}, `${found.what} failed: ${found.error}`));
  else if (f.kind === 'rung') children.push(element('p', {}, `Kept on the ladder. ${f.note}`));
  else if (f.kind === 'scores') {
    const best = f.scores.slice(0, 10);
    const most = Math.max(...best.map((s) => s.gain), 1e-9);
    const rows = best.map((s) => {
      const on = element('button', {}, 'Switch on');
      on.setAttribute('aria-label', `Switch on ${s.id}`);
      on.addEventListener('click', () => act.switchOn(s.id, s.start));
      const gain = cell(s.gain.toPrecision(4));
      const bar = element('span', { className: 'bar' });
      bar.style.width = `${Math.max(0, 100 * s.gain / most)}%`;
      gain.append(bar);
      return element('tr', {}, element('td', {}, s.id), gain, element('td', {}, on));
    });
    children.push(element('h2', {}, 'Which effect would help most'),
      element('div', { className: 'scroll', tabIndex: 0, role: 'region', ariaLabel: 'effects by gain' },
        element('table', { id: 'scores' }, element('tbody', {}, ...rows))),
      element('p', { className: 'quiet' }, f.note));
  } else {
    if (f.summary) children.push(element('h2', {}, 'Diagnosis'), element('p', {}, f.summary));
    const links = f.files.flatMap((file) => [
      element('a', { href: `files/${file}`, target: '_blank', rel: 'noopener', download: file.endsWith('.fmu') ? '' : undefined }, file.split('/').slice(1).join('/')), ' ',
    ]);
    for (const a of links) if (a.download === 'undefined') a.removeAttribute('download');
    children.push(element('p', {}, 'Files: ', ...links));
    const commands = f.commands ?? [f.command];
    children.push(element('p', {}, 'The same by command line:'), element('pre', {}, commands.join('\n')));
  }
  const close = element('button', {}, 'Close');
  close.addEventListener('click', () => { host.hidden = true; });
  host.replaceChildren(...children, close);
}
