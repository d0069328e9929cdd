// Files dropped on the page: columns, units, operating point, structure; the server makes a campaign of them.

import { element, short } from './controls.js';
import { get, post, sendFile } from './server.js';

// What a sensor at the tip may read, with the units that its file may have left out.
const UNITS = { displacement: ['m', 'mm', 'um', 'nm', 'V'], velocity: ['m/s', 'mm/s', 'um/s', 'V'], acceleration: ['m/s^2', 'g', 'V'] };
const dialog = () => document.getElementById('import');
const fail = (error) => { document.getElementById('import-error').textContent = error ? error.message : ''; };

const field = (text, input) => element('label', {}, `${text} `, input);
const options = (list) => list.map(([value, text]) => element('option', { value }, text));
const choice = (list) => element('select', {}, ...options(list));

async function offer(files) {
  fail(null);
  const body = document.getElementById('import-body');
  body.replaceChildren(element('p', {}, `Reading ${files.length} file(s) …`));
  if (!dialog().open) dialog().showModal();
  try {
    const read = [];
    for (const file of files) read.push(await sendFile(file));
    const templates = await get('api/templates');
    form(body, read, templates);
  } catch (error) { body.replaceChildren(); fail(error); }
}

function form(body, read, templates) {
  const channels = read[0].channels;
  const row = (c) => element('tr', {}, ...[c.name, c.unit || '–', String(c.samples), c.problem ?? `${short(c.least)} to ${short(c.most)}`]
    .map((text) => element('td', {}, text)));
  const head = ['channel', 'unit', 'samples', 'range'].map((text) => element('th', { scope: 'col' }, text));
  const table = element('table', {}, element('thead', {}, element('tr', {}, ...head)), element('tbody', {}, ...channels.map(row)));
  const names = channels.map((c) => [c.name, c.name]);
  const time = choice([['', 'found by name and unit'], ...names]);
  const rate = element('input', { type: 'number', step: 'any', min: 0, placeholder: 'only for files without times' });
  const quantity = choice(Object.keys(UNITS).map((q) => [q, q]));
  const motion = choice([['', 'found by unit and name'], ...names]);
  const unit = choice([]);
  const units = () => unit.replaceChildren(...options([['', 'as the file says'], ...UNITS[quantity.value].map((u) => [u, u])]));
  quantity.addEventListener('change', () => { units(); fail(null); });
  units();
  const structure = choice([['', 'start values of the FMU'], ...templates.map((t) => [t.name, `${t.name}: ${t.sentence}`])]);
  const name = element('input', { value: read[0].file.replace(/\.[^.]*$/, '') });
  const points = read.map((file) => ({
    file: file.file,
    belt: element('input', { required: true, placeholder: '0.1, or a channel' }),
    force: element('input', { required: true, placeholder: '60, or a channel' }),
  }));
  body.replaceChildren(
    element('div', { className: 'scroll', tabIndex: 0, role: 'region', ariaLabel: 'channels' }, table),
    field('Name of the campaign', name), field('Times', time), field('Samples per second', rate),
    field('Measured at the tip', quantity), field('Its channel', motion), field('Its unit', unit),
    ...points.flatMap((p) => [field(`${p.file}: belt velocity in m/s`, p.belt), field(`${p.file}: normal force in N`, p.force)]),
    field('Structure', structure));
  document.getElementById('import-go').onclick = async () => {
    fail(null);
    const text = (input) => (input.value.trim() === '' ? null : input.value.trim());
    if (points.some((p) => !text(p.belt) || !text(p.force))) {
      fail(new Error('Give belt velocity and normal force of each file: a value, or the name of a channel.'));
      return;
    }
    if (quantity.value !== 'displacement' && !text(motion)) {
      fail(new Error(`Choose the channel of the ${quantity.value}.`));
      return;
    }
    try {
      const made = await post('api/import', {
        files: read.map((f) => f.file), name: name.value, template: text(structure), time: text(time),
        rate: rate.value === '' ? null : Number(rate.value), [quantity.value]: text(motion), unit: text(unit),
        belt_velocity: points.map((p) => text(p.belt)), normal_force: points.map((p) => text(p.force)),
      });
      body.replaceChildren(element('p', {}, 'Imported. The campaign is being opened.'),
        element('p', {}, 'The same by command line:'), element('pre', {}, made.command));
    } catch (error) { fail(error); }
  };
}

/** Takes files that are dropped, and those of the button. */
export function listen() {
  const mark = (on) => document.body.classList.toggle('dropping', on);
  document.addEventListener('dragover', (event) => { event.preventDefault(); mark(true); });
  document.addEventListener('dragleave', (event) => { if (!event.relatedTarget) mark(false); });
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    mark(false);
    if (event.dataTransfer.files.length) offer([...event.dataTransfer.files]);
  });
  const input = document.getElementById('file');
  input.addEventListener('change', () => { if (input.files.length) offer([...input.files]); input.value = ''; });
}
